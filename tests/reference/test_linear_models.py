"""Linear models: the formulas of hydraulics written out, python-control, and a describing function."""

import math
from typing import Any

import control
import numpy as np
import pytest

from hydroservo import ParameterError, linearize, load_scenario, replace
from hydroservo.control.controllers import PI, Saturation
from hydroservo.control.holds import DelayedHold
from hydroservo.control.loop import Loop
from hydroservo.interop import from_statespace, to_nlsys, to_statespace
from hydroservo.linear import Linearization, margins
from hydroservo.linear.linearize import linearization_at
from hydroservo.linear.measurement import ASKED, GIVEN, ExcitationPlan, measure_spectra
from hydroservo.linear.operating_point import OperatingPoint, machine_point, operating_point
from hydroservo.linear.system import part_slopes
from hydroservo.linear.textbook import textbook
from hydroservo.linear.view import responses
from hydroservo.machine.mechanics import Viscous

SYMMETRIC = [  # the machines of a load pressure, and commands [V]
    ("paper/sine-pi", 0.0),
    ("paper/sine-pi", 0.02),
    ("paper/sine-pi", -0.05),
    ("rig/1khz-pi-sine", 0.0),
    ("rig/1khz-pi-sine", 0.1),
    ("laws/pi-sine", 0.1),
    ("cases/load-step", -0.1),
    ("cases/soft-axis", 0.1),
    ("cases/drift", 0.0),
]
SINGLE_ROD = [  # machines of two chambers; friction with bristles has no formula, so theirs is viscous here
    ("axis/position", 1.0),
    ("axis/position", -1.0),
    ("axis/position-adrc", 2.0),
    ("cases/dead-band", 1.5),
    ("cases/stick-slip", 1.0),
]


@pytest.mark.parametrize(("name", "command"), SYMMETRIC)
def test_a_symmetric_machine_has_the_frequency_and_damping_of_the_textbook(name: str, command: float) -> None:
    """s^2 + (b/m + 4 beta K_ce/V_t) s + 4 beta (A^2 + b K_ce)/(V_t m), K_ce = C_tl + K_c.

    Q_L = C_d w x_v sqrt((p_s - p_r - p_L)/rho) has the flow-pressure coefficient Q_L/(2 (p_s - p_r - p_L)):
    Merritt, Hydraulic Control Systems, 1967, ch. 5 and 6.
    """
    loop = load_scenario(name)
    point = machine_point(loop, command)
    plant, valve = point.loop.plant, point.loop.valve
    coefficient = 0.0
    if command:
        orifice, load = valve.orifice, point.machine.plant.hydraulic_force / plant.piston_area
        line = point.loop.supply.pressures(point.machine.supply)
        opening = valve.gain * abs(command)
        drop = line.supply - line.tank - math.copysign(1.0, command) * load
        flow = (
            orifice.discharge_coefficient
            * orifice.area_gradient
            * opening
            * math.sqrt(drop / orifice.density)
        )
        coefficient = flow / (2.0 * drop)
    leak = plant.leakage + coefficient
    spring = 4.0 * plant.bulk_modulus / plant.total_volume
    frequency = math.sqrt(spring * (plant.piston_area**2 + plant.damping * leak) / plant.mass)
    damping = (plant.damping / plant.mass + spring * leak) / (2.0 * frequency)
    model = linearization_at(point, "machine")
    roots = np.roots([1.0, 2.0 * damping * frequency, frequency**2]).tolist()
    first, second = (nearest_pole(model, root) for root in roots)
    assert (first, second) == pytest.approx(tuple(roots), rel=1e-6)
    found = np.sqrt(first * second)
    assert found == pytest.approx(frequency, rel=1e-6)
    assert -(first + second) / (2.0 * found) == pytest.approx(damping, rel=1e-6)
    book = textbook(point)
    assert book is not None
    assert book.natural_frequency == pytest.approx(
        plant.piston_area * math.sqrt(spring / plant.mass), rel=1e-9
    )
    merritt = leak / plant.piston_area * math.sqrt(plant.bulk_modulus * plant.mass / plant.total_volume)
    merritt += (
        plant.damping
        / (4.0 * plant.piston_area)
        * math.sqrt(plant.total_volume / (plant.bulk_modulus * plant.mass))
    )
    assert book.damping_ratio == pytest.approx(merritt, rel=1e-6)


def viscous(name: str) -> Loop:
    return replace(load_scenario(name), {"plant.friction": Viscous(1000.0)})


@pytest.mark.parametrize(("name", "command"), SINGLE_ROD)
def test_a_cylinder_has_the_poles_of_its_two_columns_of_oil(name: str, command: float) -> None:
    """m dv = A_A p_A - A_B p_B - b v, dp_A = r_A (-A_A v - (K_A + C) p_A + C p_B), and likewise of B.

    r is beta/V, C the leakage past the piston, K the flow-pressure coefficients: the characteristic
    polynomial, multiplied out. Jelali and Kroll, Hydraulic Servo-systems, 2003, ch. 4.
    """
    point = machine_point(viscous(name), command)
    plant, x = point.loop.plant, point.machine.plant
    r_a = plant.oil.bulk_modulus(x.pressure_a) / (plant.dead_volume_a + plant.area_a * x.position)
    r_b = plant.oil.bulk_modulus(x.pressure_b) / (
        plant.dead_volume_b + plant.area_b * (plant.stroke - x.position)
    )
    k_a, k_b = flow_pressure_coefficients(point)
    mass, c, b = plant.mechanism.mass, plant.internal_leakage, 1000.0 / plant.mechanism.mass
    own_a, own_b, by_a, by_b = r_a * (k_a + c), r_b * (k_b + c), r_a * c, r_b * c
    spring = (plant.area_a**2 * r_a + plant.area_b**2 * r_b) / mass
    crossed = plant.area_a**2 * r_a * own_b + plant.area_b**2 * r_b * own_a
    crossed -= plant.area_a * plant.area_b * (r_a * by_b + r_b * by_a)
    both = own_a * own_b - by_a * by_b
    roots = np.roots([1.0, b + own_a + own_b, b * (own_a + own_b) + both + spring, b * both + crossed / mass])
    (expected,) = [root for root in roots.tolist() if root.imag > 0.0]
    found = nearest_pole(linearization_at(point, "machine"), expected)
    assert abs(found) == pytest.approx(abs(expected), rel=1e-6)
    assert -found.real / abs(found) == pytest.approx(-expected.real / abs(expected), rel=1e-6)
    book = textbook(point)
    assert book is not None
    assert book.natural_frequency == pytest.approx(math.sqrt(spring), rel=1e-9)


def flow_pressure_coefficients(point: OperatingPoint) -> tuple[float, float]:
    """-dQ_A/dp_A and dQ_B/dp_B of the valve as it is held, by central differences."""
    x, step = point.machine.plant, 100.0

    def flows(by_a: float, by_b: float) -> Any:
        ports = point.loop.ports(point.machine, point.command)
        return ports.flows(x.pressure_a + by_a, x.pressure_b + by_b)

    into_a = (flows(step, 0.0).a - flows(-step, 0.0).a) / (2.0 * step)
    out_of_b = (flows(0.0, step).b - flows(0.0, -step).b) / (2.0 * step)
    return -into_a, out_of_b


def nearest_pole(model: Linearization, to: complex) -> complex:
    return complex(min(model.poles.tolist(), key=lambda pole: abs(pole - to)))


@pytest.mark.parametrize("delay", [0.0, 4e-4])
def test_python_control_closes_the_loop_that_we_close(delay: float) -> None:
    """Machine and law, exported each by itself, connected by their signals' names."""
    loop = replace(load_scenario("rig/1khz-pi-sine"), {"hold": DelayedHold(delay)} if delay else {})
    machine = to_statespace(linearize(loop, sampled=True))
    law = to_statespace(linearize(loop, "controller"))
    whole = control.interconnect(
        [machine, law], inplist=["reference_value"], outlist=["velocity"], check_unused=False
    )
    ours = linearize(loop, "loop")
    w = np.geomspace(1.0, 3000.0, 50)
    theirs = whole(np.exp(1j * w * loop.simulation.period))
    np.testing.assert_allclose(ours.response(w, "velocity", "reference.value"), theirs, rtol=1e-8)
    poles = np.sort_complex(whole.poles())
    mine = np.sort_complex(ours.poles)
    for one in mine:
        assert np.abs(poles - one).min() < 1e-6


@pytest.mark.parametrize(("k_p", "k_i"), [(3.0, 600.0), (1.0, 100.0)])
def test_margins_of_the_exported_model_are_ours(k_p: float, k_i: float) -> None:
    loop = replace(load_scenario("rig/1khz-pi-sine"), {"controller": PI(k_p, k_i)})
    machine, law = linearize(loop, sampled=True), linearize(loop, "controller")
    g = to_statespace(machine)["velocity", "command"]
    k = to_statespace(law)["command", "velocity"]
    opened = control.series(g, -k)
    gain, phase, _, _, crossed, _ = control.stability_margins(opened)[:6]
    found = margins(loop)
    assert found.gain_margin == pytest.approx(gain, rel=1e-6)
    assert math.degrees(found.phase_margin) == pytest.approx(phase, rel=1e-6)
    grid = np.linspace(1.0, math.pi / loop.simulation.period, 20_001)
    disk, _, _ = control.disk_margins(opened, grid, returnall=False)
    assert found.disk_margin == pytest.approx(float(disk), rel=1e-4)
    assert crossed > 0.0


@pytest.mark.parametrize("unit", ["machine", "controller", "loop"])
def test_poles_damping_and_responses_of_the_exported_model_are_ours(unit: str) -> None:
    model = linearize(load_scenario("rig/1khz-pi-sine"), unit, command=0.05)
    system = to_statespace(model)
    with np.errstate(all="ignore"):  # of its poles at rest
        frequencies, damping, poles = control.damp(system, doprint=False)
    swings = [i for i, pole in enumerate(poles) if 1e-3 < frequencies[i] < 1e6]
    for i in swings:
        place = int(np.argmin(np.abs(model.poles - poles[i])))
        assert model.frequencies[place] == pytest.approx(frequencies[i], rel=1e-6)
        assert model.damping[place] == pytest.approx(damping[i], rel=1e-6, abs=1e-9)
    w = np.geomspace(1.0, 3000.0, 30)
    at = np.exp(1j * w * model.period) if model.period else 1j * w
    theirs = system(at, squeeze=False)
    for i, output in enumerate(model.outputs):
        for j, one in enumerate(model.inputs):
            ours = model.response(w, output.name, one.name)
            np.testing.assert_allclose(ours, theirs[i, j], rtol=1e-7, atol=1e-12)
    back = from_statespace(system, unit)
    np.testing.assert_array_equal(back.A, model.A)
    assert back.period == model.period


def test_the_machine_given_to_python_control_has_our_slopes() -> None:
    loop = replace(load_scenario("axis/position"), {"valve.hysteresis": 0.0})
    model, machine = linearize(loop, command=1.0), to_nlsys(loop, command=1.0)
    at = machine.params
    theirs = control.linearize(machine, at["state"], [at["command"], at["force"]], eps=1e-7)
    assert list(machine.output_labels) == list(to_statespace(model).output_labels)
    scale = np.abs(model.A).max(axis=1)[:, np.newaxis]
    assert (np.abs(theirs.A - model.A) < 1e-3 * scale).all()


def test_a_law_that_saturates_has_the_describing_function_of_saturation() -> None:
    """N = 2/pi (asin d + d sqrt(1 - d^2)), d = limit/A: Gelb, Vander Velde, 1968, ch. 2."""
    loop = replace(load_scenario("rig/1khz-pi-sine"), {"controller": PI(2.0, 0.0)})
    point = operating_point(loop, 0.0)
    plan = ExcitationPlan(np.array([40]), 500, 2, 1, seed=0)  # 80 Hz
    w = plan.frequencies(loop.simulation.period)
    parts, _, _ = part_slopes(point)
    opened = responses(point, parts, w).curves["open"]
    free = measure_spectra(loop, point, "command", 1e-3, plan, [])
    assert free.response(ASKED, GIVEN) == pytest.approx(-opened, rel=1e-3)
    for limit in (4e-4, 2e-4, 5e-5):
        held = replace(loop, {"controller": PI(2.0, 0.0, saturation=Saturation(limit))})
        heard = measure_spectra(held, operating_point(held, 0.0), "command", 1e-3, plan, [])
        given = 2.0 * float(np.abs(heard.spectra[GIVEN]).mean()) / plan.period
        share = limit / (given * float(np.abs(opened[0])))
        assert share < 1.0
        function = 2.0 / math.pi * (math.asin(share) + share * math.sqrt(1.0 - share**2))
        assert heard.response(ASKED, GIVEN) == pytest.approx(-opened * function, rel=0.01)


def test_what_is_no_linear_model_is_refused() -> None:
    with pytest.raises(ParameterError, match="must be what linearize returned"):
        to_statespace("rig/1khz-pi-sine")
    with pytest.raises(ParameterError, match=r"must be a control\.StateSpace"):
        from_statespace(1.0)
    with pytest.raises(ParameterError, match="must have a time step"):
        from_statespace(control.ss([[0.5]], [[1.0]], [[1.0]], [[0.0]], True))


def test_a_column_that_drains_at_once_is_no_spring() -> None:
    """Behind the open check valve of a pump drive: the pole's damping is a quarter of what formulas gave."""
    assert textbook(machine_point(load_scenario("axis/pump-controlled"), None)) is None
