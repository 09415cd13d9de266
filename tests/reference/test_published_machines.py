"""Numbers that others published of machines like these."""

import math

import numpy as np
import pytest

from hydroservo.mechanics import Mass, Viscous, ViscousState
from hydroservo.oils import AeratedOil, ConstantOil
from hydroservo.plants import Cylinder, CylinderState
from hydroservo.signals import PortFlows

INCH, POUND, PSI = 0.0254, 0.45359237, 6894.757293168361


def test_natural_frequency_of_a_worked_example() -> None:
    """77.033 Hz: 4 in bore, 2.5 in rod, 12 in stroke, 1000 lb, 180 000 psi, mid-stroke, no dead volume.

    Source: Delta Computer Systems, "Computing the Natural Frequency of the Cylinder and Load",
    forum.deltamotion.com/t/1042. Here: the eigenvalues of the machine's Jacobian, by differences:
    77.030 Hz.
    """
    little = 1e-9
    plant = Cylinder.from_diameters(
        4.0 * INCH, 2.5 * INCH, 12.0 * INCH, line_volume_a=little, line_volume_b=little
    )._replace(
        internal_leakage=0.0,
        oil=ConstantOil(180e3 * PSI),
        friction=Viscous(0.0),
        mechanism=Mass(1000.0 * POUND),
    )
    at = np.array([0.0, plant.start_position, plant.area_b / plant.area_a * 1e6, 1e6])

    def rates(y: np.ndarray) -> np.ndarray:
        state = CylinderState(*y.tolist(), ViscousState())
        return np.array(plant.deriv(state, PortFlows(0.0, 0.0, 0.0, 0.0), 0.0)[:4])

    nudges = np.diag([1e-4, 1e-6, 1e3, 1e3])
    columns = [(rates(at + one) - rates(at - one)) / (2.0 * one.sum()) for one in nudges]
    frequency = np.abs(np.linalg.eigvals(np.column_stack(columns))).max() / (2.0 * math.pi)
    assert frequency == pytest.approx(77.033, rel=1e-4)


@pytest.mark.parametrize(("pressure", "printed", "within"), [(500.0, 0.8, 0.06), (2000.0, 0.98, 0.005)])
def test_what_air_takes_off_the_bulk_modulus(pressure: float, printed: float, within: float) -> None:
    """Factors 0.8 and 0.98 at 500 and 2000 psi with 2 % of entrained air in MIL-H-83282 oil of 300 000 psi.

    Source: The Lee Company, Engineering data, Bulk modulus (actual), two worked examples that read the
    factor off a chart. Air compressed slowly (n = 1) gives 0.746 and 0.978 here: the chart, which also knows
    of air that dissolves, is stiffer at low pressure.
    """
    oil = AeratedOil(300e3 * PSI, 0.02, 1.0)
    liquid = 300e3 * PSI + pressure * PSI
    assert oil.bulk_modulus(pressure * PSI) / liquid == pytest.approx(printed, abs=within)
