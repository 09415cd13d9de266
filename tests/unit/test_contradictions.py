"""Numbers that are allowed one by one and do not go together: refused in one line, however they are given."""

from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from hydroservo import Loop, ParameterError, ScenarioError, Simulation, replace
from hydroservo.control.controllers import DeadBandCompensation, DeadBandJump
from hydroservo.core.block import Block, Field
from hydroservo.core.validation import checked, consistent
from hydroservo.machine.mechanics import LuGre, OneLinkArm, Stribeck
from hydroservo.machine.oils import ConstantOil
from hydroservo.machine.plants import Cylinder, LoadPressurePlant
from hydroservo.machine.supplies import GasAccumulator, IdealSupply, PumpSupply, ReliefValve
from hydroservo.machine.valves import FirstOrderValve, FourEdges, SecondOrderValve, StaticValve
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import simulate
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example
from tests.support.bases import on_base

CONTRADICTIONS = [
    (
        example(LoadPressurePlant, start_position=0.1),
        "start_position = 0.1: must be at most the stroke, 0.078 [m]",
    ),
    (example(Cylinder, start_position=0.1), "start_position = 0.1: must be at most the stroke, 0.078 [m]"),
    (
        example(Cylinder, mechanism=example(OneLinkArm, base_distance=5.0)),
        "mechanism = 'OneLinkArm': can be at 4.649 to 4.808 [m] only: "
        "its lengths do not go with the stroke, 0 to 0.078 [m]",
    ),
    (
        example(Cylinder, stroke=0.2, mechanism=example(OneLinkArm)),
        "mechanism = 'OneLinkArm': can be at -0.05148 to 0.1085 [m] only: "
        "its lengths do not go with the stroke, 0 to 0.2 [m]",
    ),
    (
        example(Cylinder, oil=ConstantOil(7e8), start_pressure_b=1e9),
        "start_pressure_b = 1000000000.0: must be below the oil's bulk modulus there [Pa]",
    ),
    (
        example(OneLinkArm, arm_inertia=0.1),
        "arm_inertia = 0.1: must be at least arm_mass centre_distance^2, 0.18 [kg m^2]",
    ),
    (example(Stribeck, coulomb=70.0), "breakaway = 60.0: must be at least coulomb, 70 [N]"),
    (example(LuGre, coulomb=70.0), "breakaway = 60.0: must be at least coulomb, 70 [N]"),
    (IdealSupply(2e5, 2e5), "supply_pressure = 200000.0: must be above return_pressure, 200000 [Pa]"),
    (
        example(PumpSupply, accumulator=GasAccumulator(60e5, 5e-4)),
        "accumulator.precharge = 6000000.0: must be below 4.188e+06 [Pa], the pressure with the valve shut",
    ),
    (
        example(StaticValve, orifice=example(FourEdges, lap=6e-3)),
        "orifice.lap = 0.006: must be below max_opening, 0.005 [m]",
    ),
    (
        example(FirstOrderValve, max_opening=1e-3, orifice=example(FourEdges, lap=1e-3)),
        "orifice.lap = 0.001: must be below max_opening, 0.001 [m]",
    ),
    (
        example(SecondOrderValve, orifice=example(FourEdges, lap=6e-3)),
        "orifice.lap = 0.006: must be below max_opening, 0.005 [m]",
    ),
    (
        example(StaticValve, orifice=example(FourEdges, extra_lap_pa=6e-3, extra_lap_pb=5e-3)),
        "orifice.extra_lap_pa = 0.006: leaves no way from the supply: with the lap, it or extra_lap_pb must "
        "be below 0.005 [m]",
    ),
    (
        example(StaticValve, orifice=example(FourEdges, lap=1e-3, extra_lap_at=4e-3, extra_lap_bt=4e-3)),
        "orifice.extra_lap_at = 0.004: leaves no way to the tank: with the lap, it or extra_lap_bt must be "
        "below 0.005 [m]",
    ),
    (
        example(DeadBandJump, extend_overlap=10.0),
        "extend_overlap = 10.0: must be below saturation.limit, 10 [V]",
    ),
    (
        example(DeadBandCompensation, retract_overlap=12.0),
        "retract_overlap = 12.0: must be below saturation.limit, 10 [V]",
    ),
    (
        example(SecondOrderValve, hysteresis=0.01),
        "hysteresis = 0.01: must be below twice max_opening, 0.01 [m]",
    ),
]


@pytest.mark.parametrize(("block", "says"), CONTRADICTIONS, ids=lambda one: type(one).__name__)
def test_what_does_not_go_together(block: Block, says: str) -> None:
    with pytest.raises(ParameterError) as error:
        checked(block)
    assert str(error.value) == says


def test_the_limits_themselves_are_allowed() -> None:
    for block in (
        example(LoadPressurePlant, start_position=0.078),
        example(Cylinder, start_position=0.078),
        example(Stribeck, 60.0, 60.0),
        example(OneLinkArm, arm_inertia=0.18),
        example(StaticValve, orifice=example(FourEdges, lap=-6e-3)),
        example(StaticValve, orifice=example(FourEdges, extra_lap_pa=6e-3)),
    ):
        consistent(block)


def test_numbers_out_of_all_proportion_are_one_line() -> None:
    with pytest.raises(ParameterError, match="'PumpSupply': has numbers out of all proportion"):
        checked(
            example(
                PumpSupply, displacement=1e-200, leakage=0.0, relief=example(ReliefValve, gradient=1e-300)
            )
        )


class Inner(NamedTuple):
    """Two numbers of which the first is the smaller."""

    low: Annotated[float, Field("", "lower", "this test")] = 0.0
    high: Annotated[float, Field("", "upper", "this test")] = 1.0

    def check(self) -> None:
        if not self.low < self.high:
            raise ParameterError("low", self.low, f"must be below high, {self.high:g}")


class Outer(NamedTuple):
    """A block around it."""

    inner: Inner = Inner()


def test_the_path_stands_before_what_a_nested_block_says() -> None:
    with pytest.raises(ParameterError, match=r"^outer\.inner\.low = 2\.0: must be below high, 1$"):
        consistent(Outer(Inner(2.0)), "outer")


SHORT = {"simulation.duration": "2 ms", "simulation.substeps": 1}
LINK = "rig/excavator-link-pi"
CHANGED = f"{LINK}, overridden"


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"plant.mechanism.base_distance": "5 m"}, f"{CHANGED}: plant: mechanism = 'OneLinkArm': can be at"),
        (
            {"plant.start_position": "1 m"},
            f"{CHANGED}: plant: start_position = 1.0: must be at most the stroke",
        ),
        (
            {"plant.friction.breakaway": "1 N"},
            f"{CHANGED}: plant.friction: breakaway = 1.0: must be at least",
        ),
        (
            {"supply.accumulator.precharge": "300 bar"},
            f"{CHANGED}: supply: accumulator.precharge = 30000000.0",
        ),
        (
            {"uncertainty.plant.friction.coulomb": 0.6},
            f"{CHANGED}: uncertainty: leads to plant.friction.breakaway",
        ),
    ],
)
def test_a_scenario_names_the_table(changes: dict[str, object], says: str) -> None:
    with pytest.raises(ScenarioError) as error:
        load_scenario(LINK, changes)
    assert str(error.value).startswith(says)


def test_absurd_lengths_of_an_arm_are_one_line() -> None:
    arm = example(OneLinkArm, base_distance=1e-120, pin_distance=1e-120, closed_length=1e-120)
    with pytest.raises(ParameterError, match=r"plant\.mechanism\.base_distance = 1e-120: must be"):
        simulate(example(Loop, plant=example(Cylinder, stroke=1e-122, start_position=0.0, mechanism=arm)))
    huge = example(OneLinkArm, base_distance=1e200, pin_distance=1e200, closed_length=1e200)
    with pytest.raises(ParameterError, match="its lengths do not go with the stroke"):
        simulate(example(Loop, plant=example(Cylinder, mechanism=huge)))
    small = example(
        OneLinkArm, base_distance=1e-6, pin_distance=1e-6, closed_length=1.4e-6, arm_mass=0.0, payload=0.0
    )
    loop = example(
        Loop, Simulation(1e-3, 1e-4), example(Cylinder, stroke=1e-7, start_position=0.0, mechanism=small)
    )
    run = quietly(simulate)(loop, compiled=False)  # which says that the stroke is none of a machine
    assert np.isfinite(run["plant.velocity"][0])


LOOP = example(Loop, Simulation(0.002, 1e-4))


def test_a_run_of_a_batch_is_named() -> None:
    with pytest.raises(ParameterError) as error:
        simulate_batch(LOOP, {"plant.start_position": [0.01, 0.078, 0.08], "plant.mass": [5.0, 6.0, 7.0]})
    assert str(error.value) == "plant.start_position = 0.08: must be at most the stroke, 0.078 [m], in run 2"


def test_a_run_of_a_batch_is_looked_at_as_a_whole() -> None:
    """Each number for itself occurs in a run that is allowed."""
    loop = replace(LOOP, {"plant": example(Cylinder, friction=example(Stribeck))})
    simulate_batch(loop, {"plant.friction.coulomb": [50.0, 70.0], "plant.friction.breakaway": [60.0, 80.0]})
    with pytest.raises(ParameterError, match=r"^plant\.friction\.breakaway = 60\.0: .*, in run 1$"):
        simulate_batch(
            loop, {"plant.friction.coulomb": [50.0, 70.0], "plant.friction.breakaway": [80.0, 60.0]}
        )


def test_a_million_runs_are_looked_at_in_seconds() -> None:
    """Measured 1 s on a core of 2024; the limit leaves room for slow ones."""
    from time import process_time

    from hydroservo.runs.columns import checked_columns

    begin = process_time()
    checked_columns(LOOP, {"plant.mass": np.linspace(4.0, 8.0, 1_000_000)})
    assert process_time() - begin < 20.0


def test_a_controller_of_a_plugin_may_check_itself(tmp_path: Path) -> None:
    plugin = tmp_path / "law.py"
    plugin.write_text(PLUGIN, encoding="utf-8")
    scenario = tmp_path / "law.toml"
    scenario.write_text(on_base('[controller]\ntype = "Held"\nlow = 2.0\n'), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"law\.toml: controller: low = 2\.0: must be below high, 1"):
        load_scenario(scenario, plugins=[plugin])


PLUGIN = '''
from typing import NamedTuple
from tests.support.bases import on_base
from hydroservo import ParameterError

class HeldState(NamedTuple):
    u: float

class Held(NamedTuple):
    """A command between two limits."""

    low: float = -1.0
    high: float = 1.0

    def check(self):
        if not self.low < self.high:
            raise ParameterError("low", self.low, f"must be below high, {self.high:g}")

    def init(self):
        return HeldState(0.0)

    def step(self, s, y, r, dt):
        return HeldState(min(max(r.value, self.low), self.high))
'''
