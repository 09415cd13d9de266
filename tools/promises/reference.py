"""A loop followed by hand: machines written anew, by scipy's method of order eight at a tight tolerance."""

import warnings
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import ode

from hydroservo.core.block import Block, leaves, values
from hydroservo.core.states import filled
from tools.promises.by_hand import machine

INSIDE = 4  # steps of a sample period, at least
MOST_STEPS = 500  # of one call; what needs more is too stiff for the method

Vector = NDArray[np.float64]


class Followed(NamedTuple):
    """A loop's machine along its samples, as far as it stayed within reach.

    Attributes:
        states: at each sample, shape (samples, states); fewer where the machine or the law was lost.
        least: of each state, at all of the method's steps.
        most: likewise.
        lost: whether a number stopped being finite, or left physical reach.
    """

    states: Vector
    least: Vector
    most: Vector
    lost: bool


def follow(loop: Block, tolerance: float, reach: Vector, nudge: float = 0.0) -> Followed:
    """Follow a loop that is ready to run; its law runs as it is shipped, once a sample.

    Args:
        loop: a wired loop; a sine, a step or nothing is its load.
        tolerance: of a step, relative to the size of each state.
        reach: how large each state of the machine may become.
        nudge: by which share of its size each state starts off.

    Raises:
        RuntimeError: the method gave up.
    """
    s = loop.init()
    known = np.isfinite(values(s))
    period = loop.simulation.period
    count = round(loop.simulation.duration / period)
    states, before = [(1.0 + nudge) * np.array(values(loop.machine(s)))], 0.0
    s = loop.with_machine(s, filled(loop.machine(s), iter(states[0].tolist())))
    follower = Follower(loop, tolerance, states[0])
    for k in range(count + 1):
        try:
            with np.errstate(all="ignore"):
                s = loop.sample(s, k * period, period)
        except (ArithmeticError, ValueError):  # of a law whose numbers went out of bounds
            return follower.ended(states, True)
        if not np.isfinite(np.array(values(s))[known]).all():
            return follower.ended(states, True)
        if k == count:
            break
        y = follower.across(states[-1], k * period, before, s.controller.u)
        if not (np.isfinite(y).all() and (np.abs(y) <= reach).all()):
            return follower.ended(states, True)
        states.append(y)
        s, before = loop.with_machine(s, filled(follower.like, iter(y.tolist()))), s.controller.u
    return follower.ended(states, False)


class Follower:
    """Follows a machine from sample to sample, and keeps the extremes that it met."""

    def __init__(self, loop: Block, tolerance: float, start: Vector) -> None:
        self.like, self.load = loop.machine(loop.init()), loop.load
        self.period, self.delay = loop.simulation.period, getattr(loop.hold, "delay", 0.0)
        self.least, self.most = start.copy(), start.copy()
        rates, parameters = machine(loop)
        size = self.size = sizes(self.like)
        self.held, self.force = 0.0, 0.0
        self.solver = ode(lambda t, z: rates(t, size * z, self.held, self.force, parameters) / size)
        self.solver.set_integrator(
            "dop853",
            rtol=tolerance,
            atol=1e-4 * tolerance,
            nsteps=MOST_STEPS,
            max_step=self.period / INSIDE,
        )
        self.solver.set_solout(self.met)

    def met(self, _t: float, z: Vector) -> None:
        y = self.size * z
        np.minimum(self.least, y, out=self.least)
        np.maximum(self.most, y, out=self.most)

    def across(self, y: Vector, t: float, before: float, u: float) -> Vector:
        """The states a sample later, with the command of the sample before until the delay is over."""
        jump = getattr(self.load, "time", np.inf)
        ends = sorted({t, t + self.delay, t + self.period, *([jump] if t < jump < t + self.period else [])})
        for begin, end in pairwise(ends):
            middle = 0.5 * (begin + end)
            self.held = u if middle > t + self.delay else before
            self.force = steady_force(self.load, middle)
            self.solver.set_initial_value(y / self.size, begin)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # said by successful()
                y = self.size * self.solver.integrate(end)
            if not self.solver.successful():
                raise RuntimeError("dop853 gave up")
        return y

    def ended(self, states: list[Vector], lost: bool) -> Followed:
        return Followed(np.array(states), self.least, self.most, lost)


def steady_force(load: Block, t: float) -> float:
    """The load at an instant but for a sine [N]."""
    if hasattr(load, "frequency"):
        return float(load.offset)
    return float((load.final if t > load.time else load.initial) if hasattr(load, "time") else load.amplitude)


SIZES = {"pressure": 1e6, "hydraulic_force": 1e3, "velocity": 0.1, "position": 0.1, "deflection": 1e-4}


def sizes(like: Block) -> Vector:
    """How large states usually are."""
    names = [path.rpartition(".")[2] for path, _ in leaves(like)]
    return np.array([SIZES.get(name.removesuffix("_a").removesuffix("_b"), 1e-3) for name in names])
