"""A linear law as sections of second order, which keep their digits where a matrix loses them."""

from itertools import zip_longest
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.synthesis.coprime import StateSpace, balanced

__all__ = ["Section", "Weights", "sections"]

Roots = NDArray[np.complex128]

DIGITS = 9  # of a section: LAPACK's last ones differ from processor to processor, by some 1e-13


class Weights(NamedTuple):
    """y_k = b0 u_k + b1 u_(k-1) + b2 u_(k-2) - a1 y_(k-1) - a2 y_(k-2)."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


class Section(NamedTuple):
    """(1 + n1 s + n2 s^2)/(1 + d1 s + d2 s^2), of gain 1 at rest, in seconds."""

    n1: float
    n2: float
    d1: float
    d2: float

    def sampled(self, period: float) -> Weights:
        """By Tustin's rule, s = (2/h) (z - 1)/(z + 1); one of first order stays of first order."""
        c = 2.0 / period
        n1, n2, d1, d2 = c * self.n1, c * c * self.n2, c * self.d1, c * c * self.d2
        if n2 == d2 == 0.0:
            low = 1.0 + d1
            return Weights((1.0 + n1) / low, (1.0 - n1) / low, 0.0, (1.0 - d1) / low, 0.0)
        low = 1.0 + d1 + d2
        b0, b1, b2 = (1.0 + n1 + n2) / low, 2.0 * (1.0 - n2) / low, (1.0 - n1 + n2) / low
        return Weights(b0, b1, b2, 2.0 * (1.0 - d2) / low, (1.0 - d1 + d2) / low)


def sections(law: StateSpace) -> tuple[float, tuple[Section, ...]]:
    """The gain at rest of a law of one input and one output, and the sections that make the rest of it.

    Each number is in nine digits, so that a run has the same bits on every processor; what is sampled from
    them is plain arithmetic.

    Args:
        law: stable, its input felt at once in its output's rate: C B not 0.

    Raises:
        ValueError: the law is not that, or it is out of the reach of floating-point numbers.
    """
    (a, b, c), _, rate = balanced(law)
    with np.errstate(all="ignore"):
        poles, zeros = np.linalg.eigvals(a).astype(complex), zeros_of(StateSpace(a, b, c))
        if poles.real.max() >= 0.0:
            raise ValueError("it is unstable")
        gain = (c @ np.linalg.solve(-a, b)).item()
        pairs = zip_longest(factors(zeros), factors(poles), fillvalue=(0.0, 0.0))
        table = np.array([(n1 / rate, n2 / rate**2, d1 / rate, d2 / rate**2) for (n1, n2), (d1, d2) in pairs])
    if not (np.isfinite(gain) and np.isfinite(table).all()):
        raise ValueError("it is out of the reach of floating-point numbers")
    return rounded(gain), tuple(Section(*map(rounded, row)) for row in table.tolist())


def zeros_of(law: StateSpace) -> Roots:
    """The zeros of a law with C B not 0, of which there is one less than poles."""
    from scipy.linalg import eigvals, null_space

    seen, driven = null_space(law.c), null_space(law.b.T).T
    found: Roots = eigvals(driven @ law.a @ seen, driven @ seen)
    return found


def factors(roots: Roots) -> list[tuple[float, float]]:
    """p and q of 1 + p s + q s^2 for each pair of roots, slow ones first, and q = 0 for one left over.

    Complex ones go with their conjugates. The one left over, the fastest, is last, so that no section has
    more zeros than poles.
    """
    real = sorted((float(one.real) for one in roots if one.imag == 0.0), key=abs)
    single = [(-1.0 / np.float64(real.pop()), 0.0)] if len(real) % 2 else []
    pairs = [(one, one.conjugate()) for one in roots if one.imag > 0.0]
    pairs += zip(real[::2], real[1::2], strict=True)
    found = [(-((x + y) / (x * y)).real, 1.0 / (x * y).real) for x, y in pairs]
    return [*sorted(found, key=lambda one: -abs(one[1])), *single]


def rounded(number: float) -> float:
    """A number in nine digits."""
    return float(f"{number:.{DIGITS}g}")
