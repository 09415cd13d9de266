"""The steady states of machines, from which runs may start, by least squares."""

from collections.abc import Callable, Iterator, Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop, MachineState
from hydroservo.core.block import Block, field_at, is_block, leaves, value_at, values
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.errors import ParameterError
from hydroservo.core.group import nested
from hydroservo.core.states import filled
from hydroservo.machine.starts import AsBuilt
from hydroservo.runs.evaluation import machine_rates

Numbers = NDArray[np.float64]
Which = NDArray[np.intp]
ResidualFunction = Callable[[Numbers, Which], Numbers]

NUDGE = 2.0**-30  # of a number, or of 1: short enough for orifices that bend near a vanishing drop
FIRST_DAMPING, LEAST_DAMPING = 1e-2, 1e-14  # relative to the slopes
WORSE = 16.0  # how much more after a step that is of no use
IDLE = 1e-8  # change of the cost by a step, relative: a search ends that does not get on
ROUNDS = 300


class Iterate(NamedTuple):
    """Where problems stand; all arrays have them along their last axis."""

    x: Numbers  # numbers that are sought
    residuals: Numbers  # there
    slopes: Numbers  # of each residual, by each number
    cost: Numbers  # sum of the squares of the residuals


@np.errstate(all="ignore")  # a step that is not finite is of no use
def least_squares(residuals: ResidualFunction, count: int, problems: int, settled: float) -> Iterate:
    """Points near x = 0 at which the sums of the squares of residuals are least.

    By Levenberg and Marquardt: (J'J + d diag(J'J)) step = -J'r. The damping d falls after a step that keeps
    what it promised, and rises after others. A number with no slopes stays 0.

    Source: Marquardt, An algorithm for least-squares estimation of nonlinear parameters, J. SIAM 11, 1963.
    """
    going, damping = np.arange(problems), np.full(problems, FIRST_DAMPING)
    at = iterate_at(residuals, np.zeros((count, problems)), going)
    for _ in range(ROUNDS):
        here = Iterate(*(part[..., going] for part in at))
        step, promised = damped_step(here, damping[going])
        new = iterate_at(residuals, here.x + step, going)
        gain = (here.cost - new.cost) / promised
        better = new.cost < here.cost
        for part, found in zip(at, new, strict=True):
            part[..., going[better]] = found[..., better]
        kept = np.where(gain > 0.75, 0.1, np.where(gain > 0.25, 1.0, 4.0))
        damping[going] = np.maximum(damping[going] * np.where(better, kept, WORSE), LEAST_DAMPING)
        near = np.abs(at.residuals[:, going]).max(axis=0, initial=0.0) < settled
        idle = np.abs(new.cost - here.cost) < IDLE * here.cost
        going = going[~(idle | near & ~better)]
        if not going.size:
            break
    return at


def iterate_at(residuals: ResidualFunction, x: Numbers, which: Which) -> Iterate:
    """The residuals at x and their slopes, from forward differences."""
    nudges, count = NUDGE * np.maximum(np.abs(x), 1.0), len(x)
    points = np.repeat(x[:, np.newaxis], count + 1, axis=1)
    points[range(count), range(1, count + 1)] += nudges
    found = residuals(points, which)
    base = found[:, 0]
    return Iterate(x, base, (found[:, 1:] - found[:, :1]) / nudges, ordered_sum(base * base))


def damped_step(at: Iterate, damping: Numbers) -> tuple[Numbers, Numbers]:
    """A step from a point, and by how much the cost falls with it if the slopes stay.

    The matrix is positive definite, so that elimination needs no pivots.
    """
    slopes, n = at.slopes, range(len(at.x))
    table = np.empty((len(n), len(n) + 1, len(damping)))
    table[:, :-1] = ordered_sum(slopes[:, :, np.newaxis] * slopes[:, np.newaxis])
    table[:, -1] = pull = -ordered_sum(slopes * at.residuals[:, np.newaxis])
    added = damping * np.where(table[n, n] > 0.0, table[n, n], 1.0)
    table[n, n] += added
    for k in n:
        row = table[k] / table[k, k]
        table -= table[:, k, np.newaxis] * row
        table[k] = row
    step = table[:, -1]
    return step, ordered_sum(step * (added * step + pull))


def ordered_sum(terms: Numbers) -> Numbers:
    """The sum over the first axis, one term after the other."""
    return reduce(np.add, terms, np.zeros(terms.shape[1:]))


POSITION, VELOCITY, FRICTION = "plant.position", "plant.velocity", "plant.friction."
SteadyResult = MachineState | ParameterError  # why there is none
SETTLED = 1e-9  # largest rate left, as a share of what a state changed by its size causes
SIZES = {"m/s": 0.1, "m": 1e-6, "Pa": 1e6, "N": 1e3, "m^3/s": 1e-5}  # openings and deflections, not positions
OWN = (1.0,)
SHARES = (0.0, 1e-3, 1e-2, 0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0)  # of a command, by which it is approached
BEYOND = 1e30  # misfit of a rate that is not finite, and of all where a pressure is below vacuum
SLOW = 1e-9  # [m/s]: of a piston that is moved to see whether its bristles hold
START = 1e-2  # [m/s]: of a piston from which a rest is sought that none is found for at rest
NEARLY = 0.9  # of a vacuum: where a search ends that would go on to less
TOGETHER = 1000  # machines in one search; more do not stay in cache


def with_found_start(loop: Loop) -> Loop:
    """The loop with a start that is yet to be found exchanged for one with the states that this has."""
    check_given(loop)
    if not hasattr(loop.start, "found"):
        return loop
    begun = loop._replace(start=AsBuilt(require_found(starts_found([loop])[0])))
    check_given(begun)
    return begun


def starts_found(loops: Sequence[Loop]) -> list[Block | ParameterError]:
    """The states in which starts with a method ``found`` have loops begin, or why there are none.

    The steady states under the commands of the starts are found together, one under another command once a
    start asks for it.
    """
    commands = [getattr(loop.start, "command", 0.0) for loop in loops]
    return [*map(found_start, loops, commands, steady_states(loops, commands))]


def found_start(loop: Loop, usual: float, settled: SteadyResult) -> Block | ParameterError:
    """The states in which a start has a loop begin; those that are given stay."""

    def steady(command: float) -> MachineState:
        return require_found(settled) if command == usual else steady_state(loop, command)

    start: Block = loop.start
    try:
        return nested(dict(leaves(start.found(steady))) | dict(leaves(start.given)))
    except ParameterError as error:
        return error


def require_found(found: Block | ParameterError) -> Block:
    """What was found; raises why it was not."""
    if isinstance(found, ParameterError):
        raise found
    return found


def check_given(loop: Loop) -> None:
    """Refuse states that are given and that the loop does not have."""
    if not loop.start.given._fields:
        return
    state = loop.blocks_begin()
    for path, value in leaves(loop.start.given):
        try:
            there = value_at(state, path)
        except ParameterError as error:
            raise ParameterError(f"start.given.{path}", value, error.allowed) from None
        if is_block(there):
            raise ParameterError(
                f"start.given.{path}", value, "is not a number of the state but a group of them"
            )


def steady_state(loop: Loop, command: float) -> MachineState:
    """The state in which all rates of a loop's machine are 0 but that of the position."""
    found: MachineState = require_found(steady_states([loop], [command])[0])
    return found


def steady_states(loops: Sequence[Loop], commands: Sequence[float]) -> list[SteadyResult]:
    """The states in which all rates of loops' machines are 0 but those of the positions.

    Bristles that hold a piston at rest may be bent by anything, by more than they can bear too. So a state in
    which they are bent as at the start is sought first, then one in which they are not. A state below vacuum,
    where oil is so soft that its pressure hardly changes, is none. A command is approached by smaller ones
    where nothing else helps. No machine changes a bit of another's state.
    """
    found: list[SteadyResult] = []
    for first in range(0, len(loops), TOGETHER):
        some = slice(first, first + TOGETHER)
        found += Machines(loops[some], commands[some]).steady_states()
    return found


class Machines:
    """Machines, alike but for their floats, under commands and under the forces of their loads at t = 0.

    Rests of some of them are the states where searches ended, and how far each number is from rest there: an
    array of shape (2, machines, numbers).
    """

    def __init__(self, loops: Sequence[Loop], commands: Sequence[float]) -> None:
        starts = [loop.machine(loop.init()) for loop in loops]
        self.loops, self.like, self.rates = loops, starts[0], machine_rates(loops, starts[0])
        self.starts = np.array([*map(values, starts)])
        forces = [loop.load.force(0.0) for loop in loops]
        self.outside = np.array([*zip(commands, forces, strict=True)], dtype=np.float64)
        self.paths = [path for path, _ in leaves(self.like)]
        units = [field_at(self.like, path).unit for path in self.paths]
        self.sizes = np.array([SIZES.get(unit, 1.0) for unit in units])
        self.pressures = [i for i, unit in enumerate(units) if unit == "Pa"]
        self.bent = [i for i, path in enumerate(self.paths) if path.startswith(FRICTION)]
        self.counted = np.array([float(path != POSITION) for path in self.paths])

    def steady_states(self) -> list[SteadyResult]:
        given = {POSITION, *(path for path, _ in leaves(self.loops[0].start.given))}
        free = np.array([float(path not in given) for path in self.paths])
        stiff, commands = free.copy(), self.outside[:, 0]
        stiff[self.bent] = 0.0
        every, found = np.arange(len(self.loops)), np.zeros((2, *self.starts.shape))
        worth = np.zeros_like(every)
        searches = (
            (OWN, stiff, 0.0, True),
            (OWN, free, 0.0, True),
            (SHARES, free, 0.0, commands != 0.0),
            (SHARES, free, START, True),
            (SHARES, free, -START, True),
        )
        for shares, sought, speed, of_use in searches:
            left = every[(worth < 2) & of_use]
            if left.size:
                new = self.approached(left, shares, sought, speed)
                of_new = self.worth(left, new)
                kept = of_new >= worth[left]
                found[:, left[kept]], worth[left[kept]] = new[:, kept], of_new[kept]
        return [self.outcome(i, found[:, i], settled) for i, settled in enumerate(worth > 0)]

    def approached(self, which: Which, shares: Sequence[float], free: Numbers, speed: float) -> Numbers:
        """The rests of some machines under shares of their commands, each sought from the last."""
        found = self.starts[np.newaxis, which].copy()
        found[0, :, self.paths.index(VELOCITY)] += speed
        for share in shares:
            found = self.rests(which, found[0], self.outside[which] * (share, 1.0), free)
        return found

    def rests(self, which: Which, states: Numbers, outside: Numbers, free: Numbers) -> Numbers:
        """The rests near other states, with 1 for each number that is free and 0 for others."""
        every, count, sizes = np.arange(len(which)), len(free), free * np.maximum(np.abs(states), self.sizes)
        weights = np.ones(states.shape)

        def at(x: Numbers, some: Which) -> Numbers:
            moved: Numbers = states[some, np.newaxis] + sizes[some, np.newaxis] * x.T
            return moved

        def misfits(x: Numbers, some: Which) -> Numbers:
            there = at(x, some)
            found = self.rates(there, outside[some], which[some]) / weights[some, np.newaxis]
            above = there[:, :, self.pressures].min(axis=2, initial=0.0, keepdims=True) > -ATMOSPHERE
            weighed: Numbers = self.counted * np.where(above & np.isfinite(found), found, BEYOND)
            return weighed.T

        nudged = np.repeat(1e-3 * np.eye(count, count + 1, 1)[:, :, np.newaxis], len(which), axis=2)
        moved = misfits(nudged, every).T
        weights = 1e3 * np.abs(moved - moved[:, :1]).max(axis=1)  # of each rate, by what moves it most
        weights = np.where(weights > 0.0, weights, 1.0)
        found = least_squares(misfits, count, len(which), SETTLED)
        return np.stack([at(found.x[:, np.newaxis], every)[:, 0], np.abs(found.residuals).T])

    def worth(self, which: Which, rests: Numbers) -> Which:
        """2 for a rest, 1 for one whose bristles let go once the piston moves, 0 for none."""
        settled = rests[1].max(axis=1, initial=0.0) < SETTLED
        if not self.bent:
            return np.where(settled, 2, 0)
        speeds, moving = np.array([SLOW, -SLOW]), np.repeat(rests[0, :, np.newaxis], 2, axis=1)
        moving[:, :, self.paths.index(VELOCITY)] = speeds
        bending = self.rates(moving, self.outside[which], which)[:, :, self.bent] / speeds[:, np.newaxis]
        return np.where(settled, 1 + (bending > -1e-6).all(axis=(1, 2)), 0)

    def outcome(self, i: int, rest: Numbers, settled: bool) -> SteadyResult:
        """The steady state of a machine, or why it has none."""
        if settled:
            state: MachineState = filled(self.like, iter(rest[0].tolist()))
            return state
        below = rest[0, self.pressures].min(initial=0.0) < -NEARLY * ATMOSPHERE
        cause = "a pressure is below vacuum" if below else f"{self.paths[rest[1].argmax()]} does not settle"
        command, force = self.outside[i]
        problem = f"has no steady state under {command:g} V and {force:.4g} N on the rod: {cause}"
        return ParameterError("start", type(self.loops[i].start).__name__, problem)


def state_sizes(state: Block) -> Iterator[tuple[str, float]]:
    """The size of each number of a machine's state, from its value or its unit."""
    for path, value in leaves(state):
        yield path, max(abs(value), SIZES.get(field_at(state, path).unit, 1.0))
