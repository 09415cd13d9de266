"""A delayed command on an integrator and on a slow valve, against closed forms, early and late in time.

Between its jumps a drive is constant: the integrator moves by drive times time, and a first-order lag decays
to the drive. Whoever lets it jump early is off by that time, in each sample period anew.
"""

import math
from itertools import pairwise
from typing import Annotated, NamedTuple

import pytest

from hydroservo import ops
from hydroservo.control.holds import DelayedHold
from hydroservo.control.holds.delayed import DelayedHoldState, HeldTwice
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Integrator
from hydroservo.engine.compiling import compiled_function
from hydroservo.machine.integrators import RK4, Rosenbrock, Tsit5
from hydroservo.machine.loads import Sine, Square, Step

PERIOD, LAG = 1e-3, 1e-2  # [s]
SAMPLES = 200
STARTS = (0, 3_000, 1_000_000)  # samples: at 0 s, 3 s and 1000 s
INTEGRATORS = (RK4(), Rosenbrock(), Tsit5(1e-12))


class Motion(NamedTuple):
    integral: Annotated[float, Field("V s", "integral of the drive")]
    lagged: Annotated[float, Field("V", "drive behind a first-order lag")]


class Machine(NamedTuple):
    """What is driven by a held command and a load, both in V."""

    hold: DelayedHold
    load: Block

    def deriv(self, t: float, x: Motion, u: HeldTwice) -> Motion:
        drive = self.hold.at(u, t) + self.load.force(t)
        return Motion(drive, (drive - x.lagged) / LAG)

    def next_jump(self, t: float, u: HeldTwice) -> float:
        return ops.minimum(self.load.next_jump(t), self.hold.next_jump(u, t))


def command(k: int) -> float:
    return 1.0 + math.cos(1.7 * k)


ADVANCE = {cls: compiled_function(vars(cls)["advance"]) for cls in (RK4, Rosenbrock, Tsit5)}


def simulated(integrator: Integrator, machine: Machine, first: int, substeps: int) -> Motion:
    """After some samples from a first one on, the command that is replaced there being 0."""
    x, s = Motion(0.0, 0.0), DelayedHoldState(0.0, 0.0)
    for k in range(first, first + SAMPLES):
        t = k * PERIOD
        s = machine.hold.step(s, command(k - 1 - first) if k > first else 0.0, t)
        held = machine.hold.held(s, command(k - first))
        x = ADVANCE[type(integrator)](integrator, machine, t, x, held, PERIOD, substeps)
    return x


def exact(delay: float, load: list[tuple[float, float]]) -> Motion:
    """The closed form: commands from their instants on, and a load that is so much from an instant on.

    Time counts from the first sample.
    """
    end = SAMPLES * PERIOD
    jumps = sorted({0.0, end, *(k * PERIOD + delay for k in range(SAMPLES)), *(at for at, _ in load)})
    x = Motion(0.0, 0.0)
    for start, stop in pairwise(jumps):
        middle = 0.5 * (start + stop)
        k = math.floor((middle - delay) / PERIOD)
        drive = (command(k) if k >= 0 else 0.0) + [size for at, size in load if at <= middle][-1]
        x = Motion(
            x.integral + drive * (stop - start),
            drive + (x.lagged - drive) * math.exp(-(stop - start) / LAG),
        )
    return x


def rounding(first: int) -> float:
    """Each instant is known to the spacing of numbers there; so much can a jump be off, times its size."""
    return 4.0 * SAMPLES * math.ulp((first + SAMPLES) * PERIOD) + 1e-13


@pytest.mark.parametrize("first", STARTS)
@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda one: type(one).__name__)
def test_a_command_comes_when_it_is_due_early_and_late(integrator: Integrator, first: int) -> None:
    """The load jumps on a sample, so that fixed steps end there."""
    machine = Machine(DelayedHold(0.5 * PERIOD), Step(0.0, 5.0, (first + 7) * PERIOD))
    found = simulated(integrator, machine, first, 4)
    wanted = exact(0.5 * PERIOD, [(0.0, 0.0), (7 * PERIOD, 5.0)])
    assert abs(found.integral - wanted.integral) < rounding(first)
    order = 1e-10 if isinstance(integrator, Tsit5) else 1e-6  # four fixed steps in a tenth of the lag
    assert abs(found.lagged - wanted.lagged) < order + rounding(first) / LAG


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda one: type(one).__name__)
def test_the_error_does_not_grow_with_time(integrator: Integrator) -> None:
    """Under a load that is the same at each start; its rates are asked close to jumps, not before them."""
    machine = Machine(DelayedHold(0.75 * PERIOD), Sine(5.0, 10.0))
    early = simulated(integrator, machine, 0, 4)
    for first in STARTS[1:]:
        late = simulated(integrator, machine, first, 4)
        assert abs(late.integral - early.integral) < rounding(first)
        assert abs(late.lagged - early.lagged) < rounding(first) / LAG


@pytest.mark.parametrize("first", STARTS)
def test_an_adaptive_method_sees_jumps_anywhere(first: int) -> None:
    delay, at = 0.314159e-3, 7.3 * PERIOD
    machine = Machine(DelayedHold(delay), Step(0.0, 5.0, first * PERIOD + at))
    found, wanted = simulated(Tsit5(1e-12), machine, first, 1), exact(delay, [(0.0, 0.0), (at, 5.0)])
    assert abs(found.integral - wanted.integral) < rounding(first)
    assert abs(found.lagged - wanted.lagged) < 1e-10 + rounding(first) / LAG


@pytest.mark.parametrize("first", STARTS)
def test_a_square_load_jumps_when_it_is_due(first: int) -> None:
    half = 6.4e-3  # [s], of which each start holds a whole and even number
    machine = Machine(DelayedHold(0.0), Square(3.0, 2.0 * half))
    found = simulated(Tsit5(1e-12), machine, first // 64 * 64, 1)
    jumps = [(i * half, 3.0 * (-1.0) ** i) for i in range(math.ceil(SAMPLES * PERIOD / half))]
    assert abs(found.integral - exact(0.0, jumps).integral) < rounding(first)
