"""What every designed gain has in common: its digits, and what is said where there is none."""

from collections.abc import Sequence

import numpy as np

from hydroservo.block import Block
from hydroservo.errors import ParameterError
from hydroservo.synthesis.matrix import Matrix

__all__ = ["no_gain", "rounded"]

DIGITS = 9  # of a gain: LAPACK's last ones differ from processor to processor, by some 1e-13


def rounded(gain: Matrix) -> Matrix:
    """A gain in nine digits: LAPACK's last ones are others on another processor.

    A run is to have the same bits there.

    Args:
        gain: of shape (m, n).
    """
    return np.array([[float(f"{one:.{DIGITS}g}") for one in row] for row in gain])


def no_gain(block: Block, names: Sequence[str], period: float, cause: str) -> ParameterError:
    """What to say where no gain is found.

    Args:
        block: that which was to be designed.
        names: of its numbers that rule the design, at least one.
        period: sample period [s].
        cause: what is out of reach, such as "disturbance over noise is".
    """
    first, *others = names
    beside = "".join(f"{name} = {getattr(block, name):g}, " for name in others)
    beside = f"{beside.removesuffix(', ')} and " if beside else ""
    return ParameterError(
        f"{type(block).__name__}.{first}",
        getattr(block, first),
        f"with {beside}a sample period of {period:g} s no gain is found: "
        f"{cause} out of the reach of floating-point numbers",
    )
