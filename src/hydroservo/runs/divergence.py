"""Which number of a run's state was lost: it stopped being finite, or left physical reach."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from hydroservo.core.block import Block, leaves

BEYOND = "left physical reach, beyond"
ORDER = ("reference", "sensors", "controller", "hold", "load")  # of a sample; then the machine moves
REACH: Mapping[
    str, tuple[float, str]
] = {  # the largest size of numbers of a machine, far beyond any that is built
    "plant.velocity": (100.0, "100 m/s"),
    "plant.pressure_a": (1e9, "10,000 bar"),
    "plant.pressure_b": (1e9, "10,000 bar"),
}


class Loss(NamedTuple):
    """The number that a run lost, and when."""

    path: str  # and, where it was finite, what it went beyond
    time: float  # instant of the sample [s]


NOTHING = Loss("nothing", math.nan)


def watched_paths(state: Block) -> tuple[str, ...]:
    """The numbers of a loop's state that must stay finite, from its first state.

    One that is nan there says that nothing is known yet, as of a signal that nothing measures, and may be so
    again.
    """
    return tuple(path for path, value in leaves(state) if math.isfinite(value))


def reach_of(state: Block) -> tuple[tuple[str, float], ...]:
    """How large some numbers of a loop's state may be, by path: velocity [m/s] and pressures [Pa]."""
    known = {path for path, _ in leaves(state)}
    return tuple((path, most) for path, (most, _) in REACH.items() if path in known)


def first_loss(state: Block, watched: Sequence[str], numbers: Sequence[float], time: float) -> Loss:
    """The first number of a state that is lost, in the order in which a sample computes them.

    Args:
        state: a state of the loop, for its paths.
        watched: as :func:`watched_paths` has them.
        numbers: the numbers of the state in which something was lost, in the order of its paths.
        time: instant of the sample [s].
    """
    values = dict(zip((path for path, _ in leaves(state)), numbers, strict=True))
    lost = [path for path in watched if not math.isfinite(values[path])]
    if lost:
        return Loss(min(lost, key=place_in_sample), time)
    path = next(path for path, most in reach_of(state) if abs(values[path]) > most)
    return Loss(f"{path} {BEYOND} {REACH[path][1]}", time)


def place_in_sample(path: str) -> int:
    """When in a sample a number is computed."""
    part = path.partition(".")[0]
    return ORDER.index(part) if part in ORDER else len(ORDER)
