"""Text as LaTeX sets it."""

import re

SPECIAL = {
    "\\": r"\textbackslash{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\textquotedbl{}",
    **{sign: rf"\{sign}" for sign in "&%$#_{}"},
    "-": "{-}",  # two of them are no dash
    "[": "{[}",  # no option of the row's end before it
    "*": "{*}",  # nor its star
    "\N{MINUS SIGN}": r"\ensuremath{-}",
    "\N{EN DASH}": "--",
    "\N{NO-BREAK SPACE}": "~",
    "\N{MULTIPLICATION SIGN}": r"\ensuremath{\times}",
    "\N{MIDDLE DOT}": r"\ensuremath{\cdot}",
    "\N{PLUS-MINUS SIGN}": r"\ensuremath{\pm}",
    "\N{INFINITY}": r"\ensuremath{\infty}",
    "\N{LESS-THAN OR EQUAL TO}": r"\ensuremath{\le}",
    "\N{GREATER-THAN OR EQUAL TO}": r"\ensuremath{\ge}",
    "\N{DEGREE SIGN}": r"\ensuremath{^\circ}",
    "\N{MICRO SIGN}": r"\ensuremath{\mu}",
    **{sign: rf"\ensuremath{{^{digit}}}" for sign, digit in zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-", strict=True)},
}
EACH = re.compile("|".join(map(re.escape, SPECIAL)))
MATHS = re.compile(r"(?<!\\)(\$(?:\\.|[^$\\])*\$)")  # between two signs of a dollar that are none


def escaped(text: str) -> str:
    """Text that LaTeX sets as it stands."""
    return EACH.sub(lambda sign: SPECIAL[sign[0]], text)


def label(text: str) -> str:
    r"""A text of a figure for LaTeX: maths as it is, all else escaped.

    Args:
        text: as matplotlib has it, where \$ is the sign of a dollar, and ``\mathdefault`` is its own.
    """
    parts = MATHS.split(text)
    shown = [escaped(one.replace(r"\$", "$")) for one in parts]
    shown[1::2] = [one.replace(r"\mathdefault", "") for one in parts[1::2]]
    return "".join(shown)
