"""A law whose command goes out with the other sign, and which is told so."""

import pytest

from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.control.controlled import PressureB, Velocity
from hydroservo.control.controllers import PI, InvertedPolarity, Saturation
from hydroservo.control.references import Step
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.loads import Constant
from hydroservo.machine.mechanics import MassSpringDamper
from hydroservo.machine.plants import Cylinder
from hydroservo.testing.examples import example

H = 1e-3
SPECIMEN = MassSpringDamper(6.0, stiffness=1e7, rest_position=0.039, damping=1e4)
GAINS = PI(1e-8, 1e-5)
LAW = PI(2.0, 30.0, anti_windup=20.0, saturation=Saturation(5.0), controls=Velocity())


@pytest.mark.parametrize("demand", [0.6, -0.6, 30.0])
def test_it_is_the_law_in_a_machine_that_is_turned_round(demand: float) -> None:
    """Commands applied with the other sign are the law's own, also where a limit holds them."""
    law = InvertedPolarity(LAW)
    s, alone = law.init(), LAW.init()
    for k in range(200):
        velocity, r = 0.1 + 0.01 * (k % 7), Demand(demand, 0.0, 0.0)
        s = law.step(s, Measurement(velocity, 0.0, 0.0, s.u, 0.0, 0.0, 0.0), r, H)
        alone = LAW.step(alone, Measurement(velocity, 0.0, 0.0, alone.u, 0.0, 0.0, 0.0), r, H)
        assert s.u == -alone.u != 0.0
        assert s.controller == alone


@pytest.mark.parametrize("to", [10e5, 30e5])
def test_with_it_the_pressure_in_chamber_b_goes_where_it_is_asked_to(to: float) -> None:
    loop = example(
        Loop,
        Simulation(0.1, 1e-3, 50, record_period=1e-3),
        plant=example(Cylinder, mechanism=SPECIMEN),
        controls=PressureB(),
        reference=Step(20e5, to, 0.01),
        load=Constant(0.0),
        controller=InvertedPolarity(GAINS),
    )
    found = simulate(loop, compiled=False)["plant.pressure_b"].values
    assert found[-1] == pytest.approx(to, rel=0.02)
    straight = replace(loop, {"controller": GAINS, "simulation.duration": 0.05})
    lost = simulate(straight, compiled=False)["plant.pressure_b"].values
    assert abs(lost[-1] - to) > abs(lost[0] - to)
