"""Numbers of different blocks that do not go together are said, and those that just do are not."""

import pytest

from hydroservo import Loop, Simulation, replace
from hydroservo.control.controllers import PI
from hydroservo.control.references import Sine
from hydroservo.core.block import Block
from hydroservo.core.curve import Curve
from hydroservo.machine.loads import Step
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.sensors import Encoder, PressureTransducer, RigSensors
from hydroservo.machine.supplies import IdealSupply
from hydroservo.machine.valves import CurvedEdges, FourEdges, StaticValve
from hydroservo.runs.cautions import quietly, warnings_of
from hydroservo.runs.cautions.loop import mismatch_cautions
from hydroservo.runs.run import simulate
from hydroservo.scenario import load_scenario, scenarios
from hydroservo.testing.examples import example

LOOP = example(
    Loop,
    Simulation(0.01, 1e-3, 4),
    plant=example(Cylinder),
    supply=IdealSupply(40e5),
    controller=PI(3.0, 100.0),
)
LAPPED = StaticValve(1e-4, 5e-3, example(FourEdges, lap=1e-3))
OVERLAP = CurvedEdges(5e-3, Curve.from_samples([0.0, 0.2, 1.0], [0.0, 0.0, 1.0]))
NOTCHED = StaticValve(1e-4, 5e-3, example(FourEdges, shape=OVERLAP))
RIG = RigSensors(Encoder(1e-6))
MISMATCHES = [
    (
        {"load": Step(0.0, 100.0, 0.01)},
        {"load": Step(0.0, 100.0, 0.009)},
        "the load does not come: load.time is 0.01 s, and the run ends at 0.01 s",
    ),
    (
        {"valve": LAPPED},
        {"valve": LAPPED._replace(gain=1.01e-4)},
        "the valve stays shut: the largest command moves the spool by 1.00 mm, and its lap is 1.00 mm",
    ),
    (
        {"reference": Sine(0.01, 501.0)},
        {"reference": Sine(0.01, 500.0)},
        "reference.frequency is 501 Hz, beyond half the sample rate, 500 Hz",
    ),
    (
        {"sensors": RIG._replace(pressure_a=PressureTransducer(0.0, 39e5))},
        {"sensors": RIG._replace(pressure_a=PressureTransducer(0.0, 40e5))},
        "sensors.pressure_a.range_high is 39.0 bar, and the supply has 40.0 bar: beyond the range nothing is "
        "read",
    ),
    (
        {"sensors": RigSensors(Encoder(8e-3))},
        {"sensors": RigSensors(Encoder(7e-3))},
        "sensors.position.resolution is 8.00 mm, and the stroke 78.0 mm: a few counts tell no position",
    ),
    (
        {"plant.start_pressure_a": 41e5},
        {"plant.start_pressure_a": 40e5},
        "plant.start_pressure_a is 41.0 bar, above the 40.0 bar of the supply",
    ),
    (
        {"valve": NOTCHED},
        {"valve": NOTCHED._replace(gain=1.01e-4)},
        "the valve stays shut: the largest command moves the spool by 1.00 mm, and its edges overlap by more",
    ),
]


@pytest.mark.parametrize(("wrong", "right", "says"), MISMATCHES)
def test_what_does_not_go_together_is_said(
    wrong: dict[str, Block], right: dict[str, Block], says: str
) -> None:
    assert mismatch_cautions(replace(LOOP, right)) == []
    assert mismatch_cautions(replace(LOOP, wrong)) == [says]


def test_runs_say_it() -> None:
    loop = replace(LOOP, {"reference": Sine(0.01, 501.0)})
    assert MISMATCHES[2][2] in warnings_of(quietly(simulate)(loop, compiled=False))


def test_what_ships_goes_together() -> None:
    assert {name: found for name in scenarios() if (found := mismatch_cautions(load_scenario(name)))} == {}
