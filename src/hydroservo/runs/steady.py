"""The steady state of a machine, from which a run may start."""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import Block, is_block, leaves, value_at, values
from hydroservo.errors import ParameterError
from hydroservo.group import nested
from hydroservo.loop import Loop, MachineState
from hydroservo.starts import AsBuilt, Steady
from hydroservo.states import filled

__all__ = ["sized", "started", "steady_state"]

POSITION = "plant.position"
Rates = Callable[[NDArray[np.float64]], NDArray[np.float64]]
SETTLED = 1e-9  # of the rates that a tenth of each state's size, once a second, would be
SIZES = {"velocity": 0.1, "position": 0.1, "pressure": 1e6, "opening": 1e-3, "load_force": 1e3}
ROUNDS = 200


def started(loop: Loop) -> Loop:
    """The loop with a start that asks for a steady state exchanged for one with the states that this has.

    Raises:
        ParameterError: there is none.
    """
    check_given(loop)
    if not isinstance(loop.start, Steady):
        return loop
    found = steady_state(loop, loop.start.command)
    given = dict(leaves(loop.start.given))
    return loop._replace(start=AsBuilt(nested({**dict(leaves(found)), **given})))


def check_given(loop: Loop) -> None:
    """Refuse states that are given and that the loop does not have.

    Raises:
        ParameterError: there is one.
    """
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
                f"start.given.{path}", value, "is no number of the state but a group of them"
            )


def steady_state(loop: Loop, command: float) -> MachineState:
    """The state in which all rates of a loop's machine are 0 but that of the position.

    Args:
        loop: the loop, ready to run but for its start.
        command: under which the machine has settled [V].

    Raises:
        ParameterError: none is found.
    """
    from scipy.optimize import least_squares

    start = loop.machine(loop.init())
    fixed = {POSITION, *(path for path, _ in leaves(loop.start.given))}
    free = [i for i, (path, _) in enumerate(leaves(start)) if path not in fixed]
    watched = [i for i, (path, _) in enumerate(leaves(start)) if path != POSITION]
    first, sizes = np.array(values(start)), np.array([size for _, size in sized(start)])
    force = loop.load.force(0.0)

    def rates(x: NDArray[np.float64]) -> NDArray[np.float64]:
        numbers = first.copy()
        numbers[free] += sizes[free] * x
        rate = np.array(values(loop.rates(filled(start, iter(numbers.tolist())), command, force)))
        return np.nan_to_num(rate[watched] / weights, nan=1e30, posinf=1e30, neginf=-1e30)

    weights = np.ones(len(watched))
    weights = stiffness(rates, len(free), len(watched))
    found = least_squares(rates, np.zeros(len(free)), xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=ROUNDS)
    if not np.abs(found.fun).max() < SETTLED:
        worst = list(leaves(start))[watched[int(np.abs(found.fun).argmax())]][0]
        problem = (
            f"has no steady state under {command:g} V and {force:.4g} N on the rod: {worst} does not settle"
        )
        raise ParameterError("start", "Steady", problem)
    numbers = first.copy()
    numbers[free] += sizes[free] * found.x
    state: MachineState = filled(start, iter(numbers.tolist()))
    return state


def stiffness(rates: Rates, free: int, watched: int) -> NDArray[np.float64]:
    """By how much each rate changes, at most, with one of the states by its size."""
    base = rates(np.zeros(free))
    table = [np.abs(rates(1e-3 * row) - base) for row in np.eye(free)]
    largest = 1e3 * np.max(table, axis=0) if table else np.zeros(watched)
    return np.where(largest > 0.0, largest, 1.0)


def sized(state: Block) -> Iterator[tuple[str, float]]:
    """The size of each number of a machine's state, from its value or its name."""
    for path, value in leaves(state):
        name = path.rpartition(".")[2]
        usual = next((size for key, size in SIZES.items() if name.startswith(key)), 1.0)
        yield path, max(abs(value), usual)
