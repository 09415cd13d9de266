"""The steady state of a machine, from which a run may start."""

from collections.abc import Callable, Collection, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import Block, field_at, is_block, leaves, value_at, values
from hydroservo.constants import ATMOSPHERE
from hydroservo.errors import ParameterError
from hydroservo.group import nested
from hydroservo.loop import Loop, MachineState
from hydroservo.runs.rows import machine_rates
from hydroservo.starts import AsBuilt
from hydroservo.states import filled

POSITION, FRICTION = "plant.position", "plant.friction."
Rates = Callable[[NDArray[np.float64]], NDArray[np.float64]]
SETTLED = 1e-9  # largest rate left, as a share of what a state changed by its size causes
SIZES = {"m/s": 0.1, "m": 1e-6, "Pa": 1e6, "N": 1e3}  # of openings and deflections, not of positions
PRECISION = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15}  # of the search: all that there is
SHARES = (1e-3, 1e-2, 0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0)  # of a command, by which it is approached
ROUNDS = 200  # each with a derivative by every number


def started(loop: Loop) -> Loop:
    """The loop with a start that is yet to be found exchanged for one with the states that this has."""
    check_given(loop)
    if not hasattr(loop.start, "found"):
        return loop
    return loop._replace(start=AsBuilt(start_found(loop)))


def start_found(loop: Loop) -> Block:
    """The states in which a start with a method ``found`` has a loop begin; those that are given stay.

    Args:
        loop: the loop, ready to run but for its start.
    """
    start: Block = loop.start
    found = dict(leaves(start.found(partial(steady_state, loop))))
    states = nested({**found, **dict(leaves(start.given))})
    check_given(loop._replace(start=AsBuilt(states)))
    return states


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
    """The state in which all rates of a loop's machine are 0 but that of the position.

    Bristles that hold a piston at rest may be bent by anything, by more than they can bear too. So a state in
    which they are bent as at the start is sought first, then one in which they are not. A state below vacuum,
    where oil is so soft that its pressure hardly changes, is none.

    Args:
        loop: the loop, ready to run but for its start.
        command: under which the machine has settled [V].
    """
    start = loop.machine(loop.init())
    paths = [path for path, _ in leaves(start)]
    fixed = {POSITION, *(path for path, _ in leaves(loop.start.given))}
    bent = {path for path in paths if path.startswith(FRICTION)}
    found = nearest_rest(loop, start, command, fixed | bent)
    if not at_rest(found) and bent - fixed:
        found = nearest_rest(loop, start, command, fixed)
    if not at_rest(found) and command:
        found = approached(loop, start, command, fixed)
    if not at_rest(found):
        force = loop.load.force(0.0)
        cause = f"{found.worst} does not settle" if found.misfit >= SETTLED else "a pressure is below vacuum"
        problem = f"has no steady state under {command:g} V and {force:.4g} N on the rod: {cause}"
        raise ParameterError("start", type(loop.start).__name__, problem)
    return found.state


class Rest(NamedTuple):
    """Where a search ended, how far its number that is least settled is from rest, and which that is."""

    state: MachineState
    misfit: float
    worst: str


def at_rest(found: Rest) -> bool:
    """Whether a search ended in a steady state."""
    pressures = (value for path, value in leaves(found.state) if field_at(found.state, path).unit == "Pa")
    return found.misfit < SETTLED and min(pressures, default=0.0) > -ATMOSPHERE


def approached(loop: Loop, start: MachineState, command: float, fixed: Collection[str]) -> Rest:
    """The steady state under a command by those under smaller ones, each sought from the last."""
    found = nearest_rest(loop, start, 0.0, fixed)
    for share in SHARES:
        found = nearest_rest(loop, found.state, share * command, fixed)
    return found


@np.errstate(over="ignore")  # of the squares of misfits that are far from settled
def nearest_rest(loop: Loop, start: MachineState, command: float, fixed: Collection[str]) -> Rest:
    """The state near another one in which the rates are least, some numbers of it held."""
    from scipy.optimize import least_squares

    paths = [path for path, _ in leaves(start)]
    free = [i for i, path in enumerate(paths) if path not in fixed]
    watched = [i for i, path in enumerate(paths) if path != POSITION]
    first, sizes = np.array(values(start)), np.array([size for _, size in sized(start)])
    move, force = machine_rates(loop, start), loop.load.force(0.0)

    def at(x: NDArray[np.float64]) -> NDArray[np.float64]:
        numbers = first.copy()
        numbers[free] += sizes[free] * x
        return numbers

    def raw(x: NDArray[np.float64]) -> NDArray[np.float64]:
        rates = move(at(x)[np.newaxis], command, force)[0, watched]
        return np.nan_to_num(rates, nan=1e30, posinf=1e30, neginf=-1e30)

    weights = stiffness(raw, len(free), len(watched))

    def weighed(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return raw(x) / weights

    # MINPACK's arithmetic is its own; the last digits of LAPACK's are others on another processor
    none = np.zeros(len(free))
    found = least_squares(weighed, none, max_nfev=ROUNDS, method="lm", x_scale=1.0, **PRECISION)
    misfits = np.abs(found.fun)
    state: MachineState = filled(start, iter(at(found.x).tolist()))
    return Rest(state, float(misfits.max()), paths[watched[int(misfits.argmax())]])


def stiffness(rates: Rates, free: int, watched: int) -> NDArray[np.float64]:
    """By how much each rate changes, at most, with one of the states by its size."""
    base = rates(np.zeros(free))
    table = [np.abs(rates(1e-3 * row) - base) for row in np.eye(free)]
    largest = 1e3 * np.max(table, axis=0) if table else np.zeros(watched)
    return np.where(largest > 0.0, largest, 1.0)


def sized(state: Block) -> Iterator[tuple[str, float]]:
    """The size of each number of a machine's state, from its value or its unit."""
    for path, value in leaves(state):
        yield path, max(abs(value), SIZES.get(field_at(state, path).unit, 1.0))
