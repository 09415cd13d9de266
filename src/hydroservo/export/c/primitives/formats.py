"""Floating-point formats, and functions of numbers whose text depends on them."""

from collections.abc import Sequence
from typing import NamedTuple

from hydroservo.export.c.writer import Writer
from hydroservo.language.terms import REAL, Function, Type


class Format(NamedTuple):
    """What the texts of functions need to know of a floating-point format.

    Attributes:
        real: its type.
        bits: the type of its bits.
        mantissa: the number of bits behind the point.
        one: the bits of 1.
        least_mantissa: the bits of the largest number below sqrt(1/2), plus one.
        bias: of its exponents.
        rounder: 1.5 2^mantissa + 2 bias, which leaves n + 2 bias in the lowest bits of n + rounder.
        whole: 2^mantissa; from here on every number is whole.
        suffix: of its literals and of math.h's functions.
        nan: not a number.
    """

    real: str
    bits: str
    mantissa: int
    one: str
    least_mantissa: str
    bias: int
    rounder: str
    whole: str
    suffix: str
    nan: str


DOUBLE = Format(
    real="double",
    bits="uint64_t",
    mantissa=52,
    one="UINT64_C(0x3FF0000000000000)",
    least_mantissa="UINT64_C(0x3FE6A09E667F3BCD)",
    bias=1023,
    rounder="6755399441057790.0",
    whole="4503599627370496.0",
    suffix="",
    nan="(double)NAN",
)
SINGLE = Format(
    real="float",
    bits="uint32_t",
    mantissa=23,
    one="UINT32_C(0x3F800000)",
    least_mantissa="UINT32_C(0x3F3504F3)",
    bias=127,
    rounder="12583166.0f",
    whole="8388608.0f",
    suffix="f",
    nan="NAN",
)


def of_numbers(
    name: str,
    text: str,
    parameters: Sequence[str] = ("x",),
    returns: Type = REAL,
    calls: Sequence[Function] = (),
) -> Function:
    """A function of numbers, with the format as ``f`` in its text."""

    def written(writer: Writer) -> str:
        return text.format(f=SINGLE if writer.real == "float" else DOUBLE)

    return Function(name, [(one, REAL) for one in parameters], returns=returns, written=written, calls=calls)
