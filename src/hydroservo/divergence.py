"""Which number of a run's state stopped being finite."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from hydroservo.block import Block, leaves

__all__ = ["NOTHING", "Loss", "diverged_by", "first_loss", "watched_paths"]

ORDER = ("reference", "sensors", "controller", "hold", "load")  # of a sample; then the machine moves


class Loss(NamedTuple):
    """The path of the number that a run lost, and when."""

    path: str
    time: float  # instant of the sample [s]


NOTHING = Loss("nothing", math.nan)


def diverged_by(loss: Loss, diverged: bool) -> str:
    """What a run diverged by: the number that it lost, else the error, or nothing if it did not."""
    return "the error" if diverged and loss is NOTHING else loss.path


def watched_paths(state: Block) -> tuple[str, ...]:
    """The numbers of a loop's state that must stay finite, from its first state.

    One that is nan there says that nothing is known yet, as of a signal that nothing measures, and may be so
    again. The lumped disturbances act on nothing: they only compare the machine with a model.
    """
    return tuple(
        path for path, value in leaves(state) if math.isfinite(value) and not path.startswith("disturbance.")
    )


def first_loss(state: Block, watched: Sequence[str], numbers: Sequence[float], time: float) -> Loss:
    """The first watched number of a state that is not finite, in the order in which a sample computes them.

    Args:
        state: a state of the loop, for its paths.
        watched: as :func:`watched_paths` has them.
        numbers: the numbers of the state in which something was lost, in the order of its paths.
        time: instant of the sample [s].
    """
    paths = [path for path, _ in leaves(state)]
    lost = [
        path
        for path, number in zip(paths, numbers, strict=True)
        if not math.isfinite(number) and path in watched
    ]
    return Loss(min(lost, key=place_in_sample), time)


def place_in_sample(path: str) -> int:
    """When in a sample a number is computed."""
    part = path.partition(".")[0]
    return ORDER.index(part) if part in ORDER else len(ORDER)
