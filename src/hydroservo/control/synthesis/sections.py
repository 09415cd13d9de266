"""A sampled linear law as sections of second order, which keep their digits where a matrix loses them."""

from itertools import zip_longest
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.synthesis.coprime import StateMatrices
from hydroservo.control.synthesis.gains import nine_digits
from hydroservo.control.synthesis.matrix import Matrix

Roots = NDArray[np.complex128]

LEAST = 1e-9  # of a section's numbers beside 1; what is less is rounding


class SectionWeights(NamedTuple):
    """y_k = b0 u_k + b1 u_(k-1) + b2 u_(k-2) - a1 y_(k-1) - a2 y_(k-2)."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


class Section(NamedTuple):
    """(1 + n1 v + n2 v^2)/(1 + d1 v + d2 v^2) with v = (z - 1)/(z + 1), of gain 1 at rest."""

    n1: float
    n2: float
    d1: float
    d2: float

    def weights(self) -> SectionWeights:
        """By plain arithmetic; what is of first order stays so."""
        n1, n2, d1, d2 = self
        if n2 == d2 == 0.0:
            low = 1.0 + d1
            return SectionWeights((1.0 + n1) / low, (1.0 - n1) / low, 0.0, (1.0 - d1) / low, 0.0)
        low = 1.0 + d1 + d2
        b0, b1, b2 = (1.0 + n1 + n2) / low, 2.0 * (1.0 - n2) / low, (1.0 - n1 + n2) / low
        return SectionWeights(b0, b1, b2, 2.0 * (1.0 - d2) / low, (1.0 - d1 + d2) / low)


def sections(law: StateMatrices) -> tuple[float, tuple[Section, ...]]:
    """The gain at rest of a law of one input and one output, and the sections that make the rest of it.

    Each number is in nine digits, so that a run has the same bits on every processor; the weights of the
    sections are plain arithmetic on them.

    Args:
        law: sampled, stable, and answering its input at once: D not 0.

    Raises:
        ValueError: the law is not that, or it is beyond the range of floating-point numbers.
    """
    a, b, c, d = law
    try:
        with np.errstate(all="ignore"):
            poles, zeros = roots_of(a), roots_of(a - b @ c / d)
            gain = (d + c @ np.linalg.solve(np.eye(len(a)) - a, b)).item()
            pairs = zip_longest(factors(zeros), factors(poles), fillvalue=(0.0, 0.0))
            table = np.array([(*top, *low) for top, low in pairs])
    except np.linalg.LinAlgError:
        raise ValueError("it is beyond the range of floating-point numbers") from None
    if not (np.isfinite(gain) and np.isfinite(table).all()):
        raise ValueError("it is beyond the range of floating-point numbers")
    if np.abs(poles).max() >= 1.0:
        raise ValueError("it is unstable")
    return nine_digits(gain), tuple(Section(*map(cleared, row)) for row in table.tolist())


def roots_of(a: Matrix) -> Roots:
    return np.linalg.eigvals(a).astype(complex)


def factors(roots: Roots) -> list[tuple[float, float]]:
    """p and q of 1 + p v + q v^2 for each pair of roots z, slow ones first, and q = 0 for one left over.

    Complex ones go with their conjugates. The one left over, the fastest, is last, so that it meets its like.
    """
    times = [1.0 / ((one - 1.0) / (one + 1.0)) if one != -1.0 else 0.0j for one in roots]
    real = sorted((one.real for one in times if one.imag == 0.0), key=abs, reverse=True)
    single = [(-real.pop(), 0.0)] if len(real) % 2 else []
    pairs = [(one, one.conjugate()) for one in times if one.imag > 0.0]
    pairs += zip(real[::2], real[1::2], strict=True)
    found = [(-(x + y).real, (x * y).real) for x, y in pairs]
    return [*sorted(found, key=lambda one: -abs(one[1])), *single]


def cleared(number: float) -> float:
    """A number in nine digits, or 0 where it is rounding beside 1."""
    return nine_digits(number) if abs(number) > LEAST else 0.0
