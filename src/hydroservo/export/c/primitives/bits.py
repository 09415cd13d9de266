"""The binary parts of a number, as in ``ops.binary``."""

from hydroservo.export.c.primitives.formats import of_numbers
from hydroservo.language.terms import Function

TYPES = {"number": "{f.real}", "bits": "{f.bits}"}


def reinterpreted(said: str, before: str, after: str) -> Function:
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
    return of_numbers(f"ops_{after}", text)


BITS = reinterpreted("The bits of a number.", "number", "bits")
NUMBER = reinterpreted("The number that has these bits.", "bits", "number")

EXPONENT = of_numbers(
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

MANTISSA = of_numbers(
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

SCALED_NUMBER = of_numbers(
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
