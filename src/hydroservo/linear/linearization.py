"""What a unit of a loop is for small motions, with names and units."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.errors import ParameterError, one_of
from hydroservo.core.field import Field
from hydroservo.core.validation import checked_number
from hydroservo.linear.finding import linearization_finding
from hydroservo.linear.system import System, frequency_response
from hydroservo.show import Finding
from hydroservo.show.html import html_of

Matrix = NDArray[np.float64]
AT_ORIGIN = 1e-9  # of the largest pole: below it a pole is at rest
AT_ONE = 3e-8  # likewise of a sampled one, from z = 1: what rounding moves a double one by
SLOW = 1e-4  # of the slowest pole, at which a gain counts as steady


class Quantity(NamedTuple):
    """A state, an input or an output."""

    name: str
    unit: str


class InexactSlope(NamedTuple):
    """A derivative that is not exact, but from differences: at a kink, or of a text that has no slopes."""

    of: str
    by: str
    value: float
    error: float


class Linearization(NamedTuple):
    """A unit of a loop about a point: dx/dt = A x + B u, y = C x + D u, and sampled x_(k+1) = A x_k + B u_k.

    All numbers are SI, and deviations from the point. Names are those under which a run records the states.
    """

    unit: Annotated[str, Field("", "machine, controller or loop")]
    states: Annotated[tuple[Quantity, ...], Field("", "names and units of x")]
    inputs: Annotated[tuple[Quantity, ...], Field("", "names and units of u")]
    outputs: Annotated[tuple[Quantity, ...], Field("", "names and units of y")]
    A: Annotated[Matrix, Field("", "shape (states, states)")]
    B: Annotated[Matrix, Field("", "shape (states, inputs)")]
    C: Annotated[Matrix, Field("", "shape (outputs, states)")]
    D: Annotated[Matrix, Field("", "shape (outputs, inputs)")]
    period: Annotated[float, Field("s", "of the samples; 0 in continuous time")]
    inexact: Annotated[tuple[InexactSlope, ...], Field("", "derivatives that are from differences")] = ()
    loop: Annotated[Loop | None, Field("", "that it is a unit of")] = None

    def finding(self) -> Finding:
        """What it says, as commands and notebooks show it."""
        return linearization_finding(self)

    def _repr_html_(self) -> str:
        return html_of(self.finding())

    @property
    def poles(self) -> NDArray[np.complex128]:
        """The eigenvalues of A, slowest first, s [1/s], or z where it is sampled."""
        found = np.linalg.eigvals(self.A).astype(complex) if len(self.A) else np.zeros(0, complex)
        at_rest = 1.0 if self.period else 0.0
        near = AT_ONE if self.period else AT_ORIGIN * np.abs(found).max(initial=0.0)
        found[np.abs(found - at_rest) < near] = at_rest
        return found[np.lexsort((found.imag, np.round(np.abs(continuous_rates(found, self.period)), 9)))]

    @property
    def rates(self) -> NDArray[np.complex128]:
        """The poles as s [1/s], that of z by ln(z)/h; minus infinity for a pole at z = 0."""
        return continuous_rates(self.poles, self.period)

    @property
    def frequencies(self) -> Matrix:
        """The natural frequency |s| of each pole [rad/s]."""
        return np.abs(self.rates)

    @property
    def damping(self) -> Matrix:
        """The damping ratio -Re s/|s| of each pole; nan at s = 0, and 1 at z = 0."""
        rates = self.rates
        with np.errstate(all="ignore"):
            found = -rates.real / np.abs(rates)
        return np.where(np.isinf(rates.real), 1.0, found)

    def response(self, frequencies: ArrayLike, output: str, input_: str) -> NDArray[np.complex128]:
        """An output by an input at some frequencies [rad/s], in their SI units.

        Raises:
            ParameterError: there is no such output or input, or a frequency is below 0, above Nyquist's or no
                number.
        """
        w = checked_frequencies(frequencies, self.period)
        row = signal_index("output", output, self.outputs)
        column = signal_index("input", input_, self.inputs)
        return frequency_response(self.system.part([column], [row]), w)[:, 0, 0]

    def steady_gain(self, output: str, input_: str) -> float:
        """The gain of slow motions; inf where an output integrates an input, 0 where it differentiates it."""
        moving = [w for w in self.frequencies if 0.0 < w < math.inf]
        slow = SLOW * min(moving, default=1.0)
        near, slower = self.response([slow, 0.1 * slow], output, input_)
        if abs(slower) > 2.0 * abs(near):
            return math.inf
        return 0.0 if abs(slower) < 0.5 * abs(near) else float(slower.real)

    @property
    def system(self) -> System:
        """The matrices alone."""
        return System(self.A, self.B, self.C, self.D, self.period)


def continuous_rates(poles: NDArray[np.complex128], period: float) -> NDArray[np.complex128]:
    """The poles as s [1/s]."""
    if not period:
        return poles
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.log(poles) / period
    return np.where(poles == 0.0, complex(-math.inf, 0.0), found)


def signal_index(what: str, name: str, there: Sequence[Quantity]) -> int:
    names = [one.name for one in there]
    if name not in names:
        raise ParameterError(what, name, one_of(str(name), names))
    return names.index(name)


def checked_frequencies(frequencies: ArrayLike, period: float) -> Matrix:
    """Frequencies [rad/s] at which a response is asked for."""
    highest = math.pi / period if period else math.inf
    try:
        w = np.atleast_1d(np.asarray(frequencies, dtype=np.float64))
    except (TypeError, ValueError):
        raise ParameterError("frequencies", frequencies, "must be numbers [rad/s]") from None
    for one in w.ravel().tolist():
        checked_number(one, "frequencies", Field("rad/s", "", at_least=0), float)
        if one > highest * (1.0 + 1e-9):
            allowed = f"must be at most {highest:.6g} [rad/s], Nyquist's frequency"
            raise ParameterError("frequencies", one, allowed)
    return w
