"""Numbers in Structured Text: literals with a point and a capital E, of sizes that all compilers take."""

import math

from hydroservo.export.single import single_literal

LEAST, MOST = 2.0**-126, 2.0**127  # of a literal's size, also where it stands for an LREAL
BEYOND = 2000  # an exponent of two that is none of a finite number


def literal_of(value: float, real: str) -> str:
    """The literal of a number; empty where it has none of a size that all compilers take."""
    size = abs(value)
    if not (size == 0.0 or LEAST <= size < MOST):
        return ""
    return real_literal(single_literal(value) if real == "REAL" else repr(float(value)))


def parts_of(value: float, real: str) -> tuple[str, str]:
    """The literals of a mantissa and an exponent of two that give a number."""
    if not math.isfinite(value):
        return real_literal(repr(math.copysign(1.0, value))), f"{BEYOND}.0"
    mantissa, exponent = math.frexp(value)
    return literal_of(mantissa, real), f"{exponent}.0"


def real_literal(text: str) -> str:
    """Python's text of a number, as Structured Text asks for it."""
    digits, _, size = text.partition("e")
    return f"{digits if '.' in digits else f'{digits}.0'}{f'E{int(size)}' if size else ''}"
