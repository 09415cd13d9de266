"""Blocks of a user's own in a run: one that fits, and what is said of one that does not."""

import math
import random
import re
import traceback
from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest

from hydroservo import HydroservoError, LoopError, ops, simulate
from hydroservo.control.holds import ZeroOrderHoldState
from hydroservo.control.references import Step
from hydroservo.core.block import Block, Field
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.valves import Orifice
from hydroservo.testing.examples import example
from tests.support.runs import EVERY_SAMPLE, LOOP, PATHS


class UserState(NamedTuple):
    u: Annotated[float, Field("V", "command")]


class OtherState(NamedTuple):
    voltage: float


class LongState(NamedTuple):
    u: float
    more: float


START = UserState(0.0)


class User(NamedTuple):
    """What a user might write in a file of their own."""

    gain: Annotated[float, Field("V s/m", "gain", "this test")] = 10.0

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(self.gain * (r.value - y.velocity))


class Misspelt(User):
    """A law that reads a parameter it does not have."""

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(self.gian * r.value)  # type: ignore[attr-defined]


def twice(x: float) -> float:
    return 2.0 * x


class Helped(NamedTuple):
    """A law that calls a function of its module, and reads a property."""

    helped: bool = True

    @property
    def gain(self) -> float:
        return 2.0

    def init(self) -> UserState:
        return START

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(twice(r.value))


class Read(Helped):
    """The same, with the property alone."""

    def init(self) -> UserState:
        return START

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(self.gain * r.value)


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (
            Helped(),
            "twice(r.value) is a function of a module; make it a method of the block",
        ),
        (Read(), "gain of Read is not a method of its own (inherited)"),
    ],
)
def test_what_compiled_code_cannot_reach_is_said_in_plain_words(law: Block, says: str) -> None:
    with pytest.raises(LoopError, match=f"cannot be compiled: .*{re.escape(says)}"):
        simulate(LOOP._replace(controller=law))


class Odd(NamedTuple):
    """A load, a demand and a supply that return what their roles do not."""

    def force(self, t: float) -> Any:
        return None

    def next_jump(self, t: float) -> float:
        return math.inf

    def at(self, t: float) -> Any:
        return 1.0

    def init(self) -> Any:
        return 0.0

    def deriv(self, s: Any, drawn: float) -> Any:
        return s

    def pressures(self, s: Any) -> Any:
        return START


@pytest.mark.parametrize(
    ("place", "says"),
    [
        ("load", "the load Odd: force returns None; it must return a float ("),
        ("reference", "the reference Odd: at returns 1.0; it must return a Demand ("),
        (
            "supply",
            "the supply Odd: init returns 0.0; it must return the first state, a NamedTuple of floats (",
        ),
    ],
)
def test_what_a_method_must_return_is_said_with_its_file(place: str, says: str) -> None:
    with pytest.raises(LoopError, match=re.escape(says) + r".*test_own_laws.py, line \d+\)$"):
        simulate(LOOP._replace(**{place: Odd()}))


class Short(User):
    """A law that forgot the sample period."""

    def step(self, s: UserState, y: Measurement, r: Demand) -> UserState:  # type: ignore[override]
        return s


def user_with(law: Callable[[Measurement], Any], start: Any) -> Block:
    """A user's controller that starts so and returns this."""

    class Law(NamedTuple):
        def init(self) -> Any:
            return start

        def step(self, s: Any, y: Measurement, r: Demand, dt: float) -> Any:
            return law(y)

    return Law()


def test_a_controller_of_the_users_own_runs() -> None:
    result = simulate(LOOP._replace(controller=User()), strict=True)
    assert result["controller.u"].attrs == {"units": "V", "long_name": "command"}
    assert result.identical(simulate(LOOP._replace(controller=User()), compiled=False))


@pytest.mark.parametrize(
    ("controller", "says"),
    [
        (Misspelt(), "'gian'"),
        (Short(), "takes 4 positional arguments but 5 were given"),
        (user_with(lambda y: UserState(y.temperature), START), "'temperature'"),
        (user_with(lambda _: UserState(gain), START), "'gain' is not defined"),  # noqa: F821
        (
            user_with(lambda _: UserState(1), START),
            "state controller.u is of type int: must be a float in init and after each step; write 1.0",
        ),
        (
            user_with(lambda _: UserState(np.zeros(2)), START),
            "state controller.u is of type ndarray: must be a float in init and after each step; "
            "hydroservo.core.vectors.vector makes a record",
        ),
        (
            user_with(lambda _: START, UserState(0)),
            "state controller.u is of type int: must be a float in init and after each step; write 1.0",
        ),
        (
            user_with(lambda _: UserState(None), START),
            "step returns UserState(u=None), whose u is not a number (",
        ),
        (user_with(lambda _: OtherState(1.0), START), "it must return a UserState, as init does: a step ret"),
        (
            user_with(lambda _: START, OtherState(1.0)),
            "init returns OtherState(voltage=1.0); it must have u (",
        ),
        (user_with(lambda _: LongState(1.0, 2.0), START), "a step returns its state's type"),
        (user_with(lambda _: 1.0, START), "the controller Law: step returns 1.0; it must return a UserState"),
        (user_with(lambda _: None, START), "test_own_laws.py, line "),
    ],
)
@pytest.mark.parametrize("compiled", [True, False])
def test_a_controller_that_does_not_fit_is_told_so_in_one_line(
    controller: Block, says: str, compiled: bool
) -> None:
    with pytest.raises(LoopError) as error:
        simulate(LOOP._replace(controller=controller), compiled=compiled)
    assert says in str(error.value)
    assert "\n" not in str(error.value)


class Lost(NamedTuple):
    """A law whose command overflows once the piston has moved a little."""

    not_a_number: bool = False
    huge: float = 1e300

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        infinity = self.huge * self.huge
        lost = ops.where(self.not_a_number, infinity - infinity, infinity)
        return UserState(ops.where(y.position > 0.0391, lost, 0.1))


def test_a_command_that_is_not_a_number_loses_the_machine() -> None:
    """The sample at which it comes is recorded, the rest is nan."""
    loop = EVERY_SAMPLE._replace(controller=Lost(not_a_number=True), reference=Step(0.0, 0.1, 0.0))
    result = simulate(loop, record=PATHS)
    assert float(result.max_error) < 0.2  # so that it is not the error that tells
    assert bool(result.diverged)
    velocity, command = result["plant.velocity"].values, result["controller.u"].values
    last = int(np.isfinite(velocity).sum()) - 1
    assert 0 < last < velocity.size - 1
    assert np.isnan(velocity[last + 1 :]).all()
    assert np.isfinite(command[:last]).all()
    assert np.isnan(command[last:]).all()


def test_an_infinite_command_is_a_divergence() -> None:
    loop = EVERY_SAMPLE._replace(controller=Lost())
    result = simulate(loop, strict=True)
    assert float(result.control_max) == math.inf
    assert bool(result.diverged)
    assert result.attrs["diverged_by"] == "controller.u"
    before = round(float(result.diverged_at) / loop.simulation.period) + 1
    assert np.isfinite(result["plant.velocity"].values[:before]).all()
    assert result.identical(simulate(loop, compiled=False))


class Stumbling(NamedTuple):
    """A law that raises at its first sample, or once the piston has moved, or calls itself for ever."""

    later: bool = False
    endless: bool = False

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        if self.endless:
            return self.step(s, y, r, dt)
        if not self.later or y.position > 0.0391:
            raise RuntimeError("one\ntwo")
        return UserState(0.1)


class Reciprocal(NamedTuple):
    """A law that divides by a velocity that is 0 at the start."""

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(1e-3 / y.velocity)


class Sketch(NamedTuple):
    """A valve and a plant that lack what a loop asks of them, or stumble over it."""

    gain: float = 1.0
    orifice: Orifice = example(Orifice)
    stroke: float = 1.0

    def init(self) -> ZeroOrderHoldState:
        return ZeroOrderHoldState()

    def opening(self, s: ZeroOrderHoldState, u: float) -> float:
        return u + math.sqrt(-1.0)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"plant": 3}, "plant = 3: must be a block: a NamedTuple with the methods of its role"),
        ({"valve": 3.0}, "valve = 3.0: must be a block: a NamedTuple with the methods of its role"),
        ({"plant": Sketch()}, "the plant Sketch: init returns ZeroOrderHoldState(); it must have velocity ("),
        ({"valve": Sketch()}, "the valve Sketch does not fit this loop: math domain error"),
        (
            {"controller": Reciprocal()},
            "the controller Reciprocal does not fit this loop: it divides by zero at the start",
        ),
        (
            {"load": example(Orifice)},
            "the load Orifice does not fit this loop: 'Orifice' object has no attribute",
        ),
    ],
)
def test_what_does_not_fit_is_named(changes: dict[str, object], says: str) -> None:
    with pytest.raises(HydroservoError) as error:
        simulate(EVERY_SAMPLE._replace(**changes), compiled=False)  # type: ignore[arg-type]
    assert str(error.value).startswith(says)


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (
            Stumbling(),
            r"the controller Stumbling does not fit this loop: one\\ntwo \(.*test_own_laws.py, line \d+\)",
        ),
        (
            Stumbling(endless=True),
            "the controller Stumbling does not fit this loop: maximum recursion depth exceeded .*",
        ),
        (
            Stumbling(later=True),
            r".*Stumbling stopped: RuntimeError: one\\ntwo \(.*test_own_laws.py, line \d+\)",
        ),
    ],
)
def test_whatever_a_law_raises_is_one_line(law: Stumbling, says: str) -> None:
    with pytest.raises(LoopError) as error:
        simulate(EVERY_SAMPLE._replace(controller=law), compiled=False)
    assert re.fullmatch(says, str(error.value))
    assert "\n" not in str(error.value)


class Sorting(NamedTuple):
    """A law that plain Python runs and no compiler takes."""

    def init(self) -> UserState:
        return UserState(0.0)

    def least(self, x: float) -> float:
        return sorted({"x": x}.values())[0]

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(self.least(y.velocity))


class Drawing(NamedTuple):
    """One that draws random numbers of Python's."""

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(random.uniform(0.0, 1.0))


class Rounding(NamedTuple):
    """One that rounds to hundredths."""

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(round(y.velocity, 2))


class Tabulated(NamedTuple):
    """One with a table."""

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(float(np.interp(y.velocity, (0.0, 1.0), (1.0, 2.0))))


class Writing(NamedTuple):
    """Another, of which the compiler names no line."""

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(float(f"{y.velocity}"))


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (
            Sorting(),
            r"Sorting.least \(.*test_own_laws.py, line \d+\): sorted\(.* is not supported",
        ),
        (
            Drawing(),
            r"Drawing.step \(.*, line \d+\): random.uniform\(0.0, 1.0\) is not supported; use ops.uniform\(",
        ),
        (Rounding(), r"Rounding.step \(.*, line \d+\): round\(.*, 2\) .*; use ops.nearest"),
        (Tabulated(), r"Tabulated.step \(.*, line \d+\): np.interp\(.*; keep the table in .*Curve"),
        (Writing(), r"Writing.step \(.*_laws.py, line \d+\): .*; methods call only ops"),
    ],
)
def test_a_law_that_cannot_be_compiled_is_named_with_its_line_and_nothing_of_the_compiler(
    law: Block, says: str
) -> None:
    with pytest.raises(LoopError, match=f"cannot be compiled: {says}") as error:
        simulate(LOOP._replace(controller=law))
    lines = "".join(traceback.format_exception(error.value)).splitlines()
    assert len(lines) < 30
    assert not any("numba" in line for line in lines)
