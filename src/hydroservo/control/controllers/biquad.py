"""A filter of second order."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import Filter, role

COMPUTED = "the law around it"


class BiquadState(NamedTuple):
    """What comes out, and what is kept for the next two samples, all in the unit of the input."""

    value: Annotated[float, Field("", "what comes out")]
    next: Annotated[float, Field("", "what is kept for the next sample")]
    after_next: Annotated[float, Field("", "what is kept for the sample after that")]


@role(Filter)
class Biquad(NamedTuple):
    """A linear filter of second order, one of the sections of which laws of higher order are made.

    v_k = b_0 u_k + b_1 u_(k-1) + b_2 u_(k-2) - a_1 v_(k-1) - a_2 v_(k-2)

    Its numbers are computed by the law that holds it; it starts at rest. The realisation is direct form II
    transposed, which keeps two numbers.

    Source: Oppenheim, Schafer, Discrete-Time Signal Processing, 1999, sec. 6.3.
    Fails to forget a sample that was not a number.
    """

    now: Annotated[float, Field("", "weight of the input", COMPUTED, derived=True)] = 1.0
    before: Annotated[float, Field("", "weight of the input a sample ago", COMPUTED, derived=True)] = 0.0
    earlier: Annotated[float, Field("", "weight of the input two samples ago", COMPUTED, derived=True)] = 0.0
    fed_back: Annotated[
        float, Field("", "weight, subtracted, of the output a sample ago", COMPUTED, derived=True)
    ] = 0.0
    fed_back_earlier: Annotated[
        float, Field("", "weight, subtracted, of the output two samples ago", COMPUTED, derived=True)
    ] = 0.0

    def init(self) -> BiquadState:
        return BiquadState(0.0, 0.0, 0.0)

    def step(self, s: BiquadState, value: float) -> BiquadState:
        out = self.now * value + s.next
        return BiquadState(
            out,
            self.before * value - self.fed_back * out + s.after_next,
            self.earlier * value - self.fed_back_earlier * out,
        )
