"""A machine with stiction, an end stop, a relief valve and air in its oil: nothing stalls or lies."""

from functools import cache

import numpy as np
import pytest
import xarray as xr

from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.control.controllers import PI
from hydroservo.control.loop import AUTO
from hydroservo.control.references import Square
from hydroservo.core.errors import HydroservoWarning
from hydroservo.core.roles import Integrator
from hydroservo.machine.integrators import RK4, Rosenbrock, Tsit5
from hydroservo.machine.loads import Constant
from hydroservo.machine.mechanics import Stops, Stribeck
from hydroservo.machine.oils import AeratedOil
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.supplies import PumpSupply
from hydroservo.machine.valves import FirstOrderValve, FourEdges
from hydroservo.testing.examples import example

STROKE = 0.078
LOOP = Loop(
    Simulation(0.4, 1e-3, AUTO, record_period=1e-3, tolerance=1e-4),
    plant=example(Cylinder, stroke=STROKE, start_position=0.06, friction=example(Stribeck), oil=AeratedOil()),
    valve=example(FirstOrderValve, orifice=example(FourEdges)),
    supply=example(PumpSupply),
    load=Constant(50.0),
    reference=Square(0.1, 2.0),
    controller=PI(3.0, 100.0),
)
INTEGRATORS = (RK4(), Rosenbrock(), Tsit5(1e-9))


@cache
def run(integrator: Integrator, substeps: int = AUTO) -> xr.Dataset:
    return simulate(
        replace(LOOP, {"simulation.integrator": integrator, "simulation.substeps": substeps}),
        record=["plant.position", "plant.velocity", "plant.pressure_a", "plant.pressure_b"],
    )


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda one: type(one).__name__)
def test_it_hits_the_stop_and_stays_there(integrator: Integrator) -> None:
    found = run(integrator)
    assert not bool(found["diverged"])
    assert "warning" not in found.attrs
    assert STROKE < found["plant.position"].values.max() < STROKE + 2.0 * 40e5 * 4.91e-4 / Stops().stiffness
    assert abs(found["plant.velocity"].values[-1]) < 1e-6
    assert found["plant.pressure_b"].values.min() > -101325.0


@pytest.mark.parametrize("other", INTEGRATORS[:2], ids=lambda one: type(one).__name__)
def test_all_integrators_agree(other: Integrator) -> None:
    """Within a few times the tolerance of automatic substeps, relative to each state's largest value."""
    exact, found = run(INTEGRATORS[2]), run(other)
    for path in ("plant.position", "plant.velocity", "plant.pressure_a", "plant.pressure_b"):
        apart = np.abs(found[path].values - exact[path].values).max() / np.abs(exact[path].values).max()
        assert apart < 1e-3, path


@pytest.mark.filterwarnings("ignore:the pressure in a chamber fell")
@pytest.mark.parametrize(("integrator", "substeps"), [(RK4(), 4), (Rosenbrock(), 1)])
def test_steps_that_are_too_coarse_for_it_say_so(integrator: Integrator, substeps: int) -> None:
    with pytest.warns(HydroservoWarning, match="too coarse to be trusted"):
        run(integrator, substeps)
