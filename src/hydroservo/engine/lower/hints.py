"""Advice on functions that neither compiled code nor C has."""

from typing import Any

from hydroservo import ops

UNIFORM, NORMAL = "uniform(seed, stream, index)", "normal(seed, stream, index)"
SAME = {  # functions of Python and numpy, by the name of their equal in ops
    "abs": "absolute",
    "amax": "maximum",
    "amin": "minimum",
    "ceil": "floor",
    "exp": "power(math.e, x)",
    "fabs": "absolute",
    "fmod": "floor",
    "gauss": NORMAL,
    "max": "maximum",
    "min": "minimum",
    "normal": NORMAL,
    "normalvariate": NORMAL,
    "pow": "power",
    "rand": UNIFORM,
    "randn": NORMAL,
    "random": UNIFORM,
    "rint": "nearest",
    "round": "nearest",
    "standard_normal": NORMAL,
    "uniform": UNIFORM,
}
TABLE = "keep the table in a field that is a hydroservo.curve.Curve, and call its value(x)"
VECTOR = "make a record of as many floats with hydroservo.vectors.vector"
OTHERS = {"interp": TABLE} | dict.fromkeys(
    ("array", "asarray", "dot", "empty", "eye", "matmul", "ones", "roll", "zeros"), VECTOR
)


def hint_for(called: Any) -> str:
    """What to write instead of a function; "" where nothing serves."""
    name = str(getattr(called, "__name__", ""))
    same = SAME.get(name, name)
    if same.partition("(")[0] in ops.__all__:
        return f"use ops.{same}"
    return OTHERS.get(name, "")
