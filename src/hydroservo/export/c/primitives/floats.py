"""What math.h has, in the form that no compiler calls a library for, but for the square root."""

from hydroservo.export.c.primitives.formats import of_numbers
from hydroservo.language.terms import BOOL, REAL, Function

# Functions of math.h that every compiler turns into instructions.
ABSOLUTE = Function("fabs", [("x", REAL)])
COPYSIGN = Function("copysign", [("x", REAL), ("y", REAL)])
FMOD = Function("fmod", [("x", REAL), ("y", REAL)])  # exact, and so the same everywhere

SQRT = of_numbers(
    "ops_sqrt",
    """\
/* Square root; nan below zero. */
static {f.real} ops_sqrt({f.real} x) {{
    return (x >= 0.0{f.suffix}) ? sqrt{f.suffix}(x) : {f.nan};
}}
""",
)

FLOOR = of_numbers(
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

ISNAN = of_numbers(
    "ops_isnan",
    """\
/* True for not-a-number. */
static bool ops_isnan({f.real} x) {{
    return isnan(x) != 0;
}}
""",
    returns=BOOL,
)

ISFINITE = of_numbers(
    "ops_isfinite",
    """\
/* True unless infinite or not-a-number. */
static bool ops_isfinite({f.real} x) {{
    return isfinite(x) != 0;
}}
""",
    returns=BOOL,
)
