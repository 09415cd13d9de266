"""Functions of numbers that are no plain text of Python: formats, math.h, binary parts, whole divisions."""

from collections.abc import Sequence
from typing import NamedTuple

from hydroservo.export.c.writer import CWriter
from hydroservo.language.terms import BOOL, INT, REAL, Function, Type

# Functions of math.h that every compiler turns into instructions.
ABSOLUTE = Function("fabs", [("x", REAL)])
COPYSIGN = Function("copysign", [("x", REAL), ("y", REAL)])
FMOD = Function("fmod", [("x", REAL), ("y", REAL)])  # exact, and so the same everywhere
TYPES = {"number": "{f.real}", "bits": "{f.bits}"}
QUOTIENT_TEXT = """\
/* The largest whole number not above a/b, for b > 0. */
static int64_t ops_quotient(int64_t a, int64_t b) {
    return ((a % b) < 0) ? ((a / b) - 1) : (a / b);
}
"""
MODULO_TEXT = """\
/* a - b floor(a/b), for b > 0. */
static int64_t ops_modulo(int64_t a, int64_t b) {
    return ((a % b) < 0) ? ((a % b) + b) : (a % b);
}
"""
PAIR: list[tuple[str, Type]] = [("a", INT), ("b", INT)]
QUOTIENT = Function("ops_quotient", PAIR, returns=INT, written=lambda _: QUOTIENT_TEXT)
MODULO = Function("ops_modulo", PAIR, returns=INT, written=lambda _: MODULO_TEXT)


class NumberFormat(NamedTuple):
    """What the texts of functions need to know of a floating-point format."""

    real: str  # its type
    bits: str  # the type of its bits
    mantissa: int  # the number of bits behind the point
    one: str  # the bits of 1
    least_mantissa: str  # the bits of the largest number below sqrt(1/2), plus one
    bias: int  # of its exponents
    rounder: str  # 1.5 2^mantissa + 2 bias, which leaves n + 2 bias in the lowest bits of n + rounder
    whole: str  # 2^mantissa; from here on every number is whole
    suffix: str  # of its literals and of math.h's functions
    nan: str  # not a number


DOUBLE = NumberFormat(
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
SINGLE = NumberFormat(
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


def number_function(
    name: str,
    text: str,
    parameters: Sequence[str] = ("x",),
    returns: Type = REAL,
    calls: Sequence[Function] = (),
) -> Function:
    """A function of numbers, with the format as ``f`` in its text."""

    def written(writer: CWriter) -> str:
        return text.format(f=SINGLE if writer.real == "float" else DOUBLE)

    return Function(name, [(one, REAL) for one in parameters], returns=returns, written=written, calls=calls)


SQRT = number_function(
    "ops_sqrt",
    """\
/* Square root; nan below zero. */
static {f.real} ops_sqrt({f.real} x) {{
    return (x >= 0.0{f.suffix}) ? sqrt{f.suffix}(x) : {f.nan};
}}
""",
)

FLOOR = number_function(
    "ops_floor",
    """\
/* Largest whole number not above x; C's own is a call on many processors. */
static {f.real} ops_floor({f.real} x) {{
    const {f.real} size = fabs{f.suffix}(x);
    const {f.real} whole = copysign{f.suffix}((size + {f.whole}) - {f.whole}, x);
    const {f.real} below = (whole > x) ? (whole - 1.0{f.suffix}) : whole;
    return (size < {f.whole}) ? below : x;
}}
""",
)

ISNAN = number_function(
    "ops_isnan",
    """\
/* True for not-a-number. */
static bool ops_isnan({f.real} x) {{
    return isnan(x) != 0;
}}
""",
    returns=BOOL,
)

ISFINITE = number_function(
    "ops_isfinite",
    """\
/* True unless infinite or not-a-number. */
static bool ops_isfinite({f.real} x) {{
    return isfinite(x) != 0;
}}
""",
    returns=BOOL,
)


def reinterpretation(said: str, before: str, after: str) -> Function:
    """A function from a number or bits to the other."""
    text = f"""\
/* {said} */
static {TYPES[after]} ops_{after}({TYPES[before]} x) {{{{
    union {{{{
        {TYPES[before]} {before};
        {TYPES[after]} {after};
    }}}} both;
    both.{before} = x;
    return both.{after};
}}}}
"""
    return number_function(f"ops_{after}", text)


BITS = reinterpretation("The bits of a number.", "number", "bits")
NUMBER = reinterpretation("The number that has these bits.", "bits", "number")

EXPONENT = number_function(
    "ops_exponent",
    """\
/* The whole number e for which x = 2^e m with m in [sqrt(1/2), sqrt(2)); for normal x > 0. */
static {f.real} ops_exponent({f.real} x) {{
    const {f.bits} moved = ops_bits(x) + ({f.one} - {f.least_mantissa});
    const int32_t e = (int32_t)(moved >> {f.mantissa}) - {f.bias};
    return ({f.real})e;
}}
""",
    calls=(BITS,),
)

MANTISSA = number_function(
    "ops_mantissa",
    """\
/* The m in [sqrt(1/2), sqrt(2)) for which x = 2^e m; for normal x > 0. */
static {f.real} ops_mantissa({f.real} x) {{
    const {f.bits} moved = ops_bits(x) + ({f.one} - {f.least_mantissa});
    return ops_number((ops_bits(x) + {f.one}) - ((moved >> {f.mantissa}) << {f.mantissa}));
}}
""",
    calls=(BITS, NUMBER),
)

SCALED_NUMBER = number_function(
    "ops_scaled",
    """\
/* x 2^n, rounded once: two factors of half the exponent each, of which the last alone can round. */
static {f.real} ops_scaled({f.real} x, {f.real} n) {{
    const {f.bits} biased = ops_bits(n + {f.rounder});
    const {f.bits} half = biased >> 1;
    return (x * ops_number(half << {f.mantissa})) * ops_number((biased - half) << {f.mantissa});
}}
""",
    parameters=("x", "n"),
    calls=(BITS, NUMBER),
)
