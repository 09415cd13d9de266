"""A law that uses what nothing measures is told so in one line; one that does not use it runs."""

import math
from collections.abc import Callable
from typing import Annotated, Any, NamedTuple, get_type_hints

import pytest

from hydroservo import Field, Loop, LoopError, Simulation, ops, simulate, simulate_batch
from hydroservo.control.controllers import DAC, PI, TSMC, AntiWindup, Backstepping, Saturation
from hydroservo.core.block import Block
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.sensors import (
    DelayedSensors,
    Difference,
    Dropout,
    ExactDifferentiator,
    IdealSensors,
    LoadCell,
    NoisySensors,
    NoPosition,
    NoPressure,
    RigSensors,
    VelocitySensor,
)
from hydroservo.machine.sensors.missing import (
    MEASURING,
    MissingSignalError,
    Unmeasured,
    missing_signals,
    sensors_for,
)
from hydroservo.scenario.registry import names_in_role, shipped_classes
from hydroservo.testing.examples import example

SHORT = Simulation(0.005, 1e-3, 8)
BLIND = example(RigSensors, pressure_b=NoPressure())
THING: Any = Unmeasured("hydraulic_force")

USES: dict[str, Callable[[Any], object]] = {
    "add": lambda x: x + 1.0,
    "add to": lambda x: 1.0 + x,
    "subtract": lambda x: x - 1.0,
    "subtract from": lambda x: 1.0 - x,
    "multiply": lambda x: 2.0 * x,
    "divide": lambda x: x / 2.0,
    "divide by": lambda x: 2.0 / x,
    "whole quotient": lambda x: x // 2.0,
    "remainder": lambda x: 2.0 % x,
    "both": lambda x: divmod(x, 2.0),
    "power": lambda x: x**2.0,
    "exponent": lambda x: 2.0**x,
    "negative": lambda x: -x,
    "abs": abs,
    "round": round,
    "float": float,
    "int": int,
    "true": bool,
    "less": lambda x: x < 1.0,
    "at least": lambda x: x >= 1.0,
    "equal": lambda x: x == 1.0,
    "other": lambda x: x != 1.0,
    "largest": lambda x: max(1.0, x),
    "text": lambda x: f"{x:.1f}",
    "C": math.sin,
    "floor": math.floor,
    "ops.absolute": ops.absolute,
    "ops.copysign": lambda x: ops.copysign(1.0, x),
    "ops.copysign of": lambda x: ops.copysign(x, 1.0),
    "ops.sign": ops.sign,
    "ops.sqrt": ops.sqrt,
    "ops.nearest": ops.nearest,
    "ops.clip": lambda x: ops.clip(x, -1.0, 1.0),
    "ops.minimum": lambda x: ops.minimum(x, 1.0),
    "ops.power": lambda x: ops.power(x, 0.5),
    "ops.signed_power": lambda x: ops.signed_power(x, 0.5),
    "ops.tanh": ops.tanh,
    "ops.sin": ops.sin,
    "ops.where": lambda x: ops.where(x, 1.0, 0.0),
}


@pytest.mark.parametrize("use", USES.values(), ids=USES)
def test_any_use_is_refused_by_name(use: Callable[[Any], object]) -> None:
    with pytest.raises(MissingSignalError, match=r"^hydraulic_force \(x2 = A_p p_L\)$"):
        use(THING)


def test_passing_it_on_and_asking_whether_it_is_there_are_no_use() -> None:
    assert ops.where(True, THING, 1.0) is THING
    assert ops.where(False, THING, 1.0) == 1.0
    assert ops.isnan(THING)
    assert not ops.isfinite(THING)
    assert "hydraulic_force" in repr(THING)


@pytest.mark.parametrize(
    ("sensors", "names"),
    [
        (IdealSensors(), ()),
        (example(NoisySensors), ()),
        (example(RigSensors, force=example(LoadCell)), ()),
        (example(RigSensors, pressure_a=NoPressure()), ("hydraulic_force", "pressure_a", "force")),
        (BLIND, ("hydraulic_force", "pressure_b", "force")),
        (example(RigSensors, NoPosition(), VelocitySensor()), ("position", "force")),
        (example(RigSensors, NoPosition(), Difference()), ("velocity", "position", "force")),
        (example(RigSensors, NoPosition(), example(ExactDifferentiator)), ("velocity", "position", "force")),
        (DelayedSensors(Dropout(0.1, BLIND)), ("hydraulic_force", "pressure_b", "force")),
        (DelayedSensors(IdealSensors()), ()),
    ],
    ids=str,
)
def test_what_sensors_lack(sensors: Block, names: tuple[str, ...]) -> None:
    assert missing_signals(sensors) == names


@pytest.mark.parametrize("run", [simulate, lambda loop: simulate_batch(loop, {"plant.mass": [5.0, 6.0]})])
@pytest.mark.parametrize("law", [example(TSMC), example(Backstepping)], ids=lambda law: type(law).__name__)
def test_a_law_that_needs_the_hydraulic_force_is_refused_without_it(
    law: Block, run: Callable[[Loop], object]
) -> None:
    with pytest.raises(LoopError) as error:
        run(example(Loop, SHORT, sensors=BLIND, controller=law))
    assert str(error.value) == (
        f"{type(law).__name__} needs hydraulic_force (x2 = A_p p_L), which RigSensors does not measure; "
        "add sensors.pressure_b.type = PressureTransducer, or use a law that does not need it"
    )


@pytest.mark.parametrize(
    ("sensors", "signal", "says"),
    [
        (RigSensors(NoPosition()), "velocity", "sensors.position.type = Encoder or IdealPosition"),
        (DelayedSensors(Dropout(0.1, BLIND)), "force", "sensors.sensors.sensors.force.type = LoadCell"),
        (
            RigSensors(NoPosition()),
            "hydraulic_force",
            "sensors.pressure_a.type = PressureTransducer and sensors.pressure_b.type = PressureTransducer",
        ),
        (BLIND, "pressure_a", "a sensor for it"),
    ],
    ids=str,
)
def test_what_gives_a_missing_signal_is_named(sensors: Block, signal: str, says: str) -> None:
    assert sensors_for(sensors, signal) == says


def test_all_types_that_measure_are_named() -> None:
    hints = get_type_hints(RigSensors)
    shipped = {cls.__name__ for cls in shipped_classes() if not cls.__name__.startswith("No")}
    for field, types in MEASURING.items():
        assert shipped.intersection(names_in_role(hints[field])) == set(types)


def test_wrappers_pass_on_what_is_missing_and_their_names() -> None:
    sensors, law = DelayedSensors(Dropout(0.1, BLIND)), DAC(AntiWindup(example(TSMC), 100.0, Saturation(5.0)))
    with pytest.raises(
        LoopError, match=r"TSMC in AntiWindup in DAC needs hydraulic_force .* RigSensors in Dropout in"
    ):
        simulate(example(Loop, SHORT, sensors=sensors, controller=law))


def test_a_velocity_from_a_position_that_is_not_there_is_missing_too() -> None:
    with pytest.raises(LoopError, match="PI needs velocity"):
        simulate(example(Loop, SHORT, sensors=RigSensors(NoPosition()), controller=PI(0.3, 100.0)))


class HeldState(NamedTuple):
    u: Annotated[float, Field("V", "command")]
    seen: Annotated[float, Field("N", "hydraulic force as it came")]


class Keeping(NamedTuple):
    """A law that stores what it does not use, and asks whether it is there."""

    def init(self) -> HeldState:
        return HeldState(0.0, math.nan)

    def step(self, s: HeldState, y: Measurement, r: Demand, dt: float) -> HeldState:
        return HeldState(
            ops.where(ops.isnan(y.hydraulic_force), r.value - y.velocity, 0.0), y.hydraulic_force
        )


@pytest.mark.parametrize("law", [PI(0.3, 100.0), Keeping()], ids=lambda law: type(law).__name__)
def test_a_law_that_does_without_runs(law: Block) -> None:
    sensors = RigSensors(NoPosition(), VelocitySensor(), NoPressure(), NoPressure())
    run = simulate(example(Loop, SHORT, sensors=sensors, controller=law))
    assert not run["diverged"]
    assert run["controller.u"].values[-1] != 0.0
