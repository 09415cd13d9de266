"""What every designed gain has in common: its digits, and what is said where there is none."""

from collections.abc import Callable, Sequence

import numpy as np

from hydroservo.control.synthesis.matrix import Matrix
from hydroservo.core.block import Block
from hydroservo.core.errors import ParameterError


def nine_digits(number: float) -> float:
    """A designed number as a run has it: LAPACK's last digits are others on another processor, by some 1e-13.

    A run is to have the same bits there.
    """
    return float(f"{number:.9g}")


def computed(design: Callable[[], Sequence[Matrix]], refusal: ParameterError) -> list[Matrix]:
    """The matrices that a design comes to, each number in nine digits.

    Args:
        design: computes them, each of shape (m, n).
        refusal: of :func:`no_gain`, for where there are none.

    Raises:
        ParameterError: there are none, or they are beyond the range of floating-point numbers.
    """
    try:
        with np.errstate(all="ignore"):
            found = design()
    except (ArithmeticError, np.linalg.LinAlgError, ValueError):
        raise refusal from None
    if not all(np.isfinite(gain).all() for gain in found):
        raise refusal
    return [np.array([[nine_digits(one) for one in row] for row in gain]) for gain in found]


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
        f"{cause} beyond the range of floating-point numbers",
    )
