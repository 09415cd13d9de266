"""Text as LaTeX sets it: alone, and in a figure that LaTeX draws."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal

from matplotlib.figure import Figure
from matplotlib.text import Text

__all__ = ["SPECIAL", "drawn_by_latex", "escaped", "label"]

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
MEASURED: Literal["center_baseline"] = "center_baseline"  # of numbers at an axis
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


@contextmanager
def drawn_by_latex(fig: Figure) -> Iterator[None]:
    """Inside, a figure that is saved as PGF needs nothing of LaTeX but ``pgf``.

    Matplotlib's own PGF needs commands of its own and the package ``underscore`` in the paper, leaves &, #
    and signs like a superscript five to LaTeX, which refuses them, and sets the numbers at an axis where they
    would end in the font that they were measured in, whatever the paper's.
    """
    from matplotlib.backends import backend_pgf

    usual = backend_pgf.RendererPgf

    class Renderer(usual):  # type: ignore[misc, valid-type]
        """Draws with text that LaTeX takes."""

        def draw_text(self, gc: Any, x: float, y: float, s: str, *more: Any, **options: Any) -> None:
            usual.draw_text(self, gc, x, y, label(s), *more, **options)  # type: ignore[no-untyped-call]

        def get_text_width_height_descent(self, s: str, *more: Any) -> Any:
            return usual.get_text_width_height_descent(self, label(s), *more)  # type: ignore[no-untyped-call]

    fig.draw_without_rendering()  # ticks are there only then
    measured = [one for one in fig.findobj(Text) if by_its_size(one)]
    for one in measured:
        one.set_verticalalignment("center")
    backend_pgf.RendererPgf = Renderer  # type: ignore[misc]
    try:
        yield
    finally:
        backend_pgf.RendererPgf = usual  # type: ignore[misc]
        for one in measured:
            one.set_verticalalignment(MEASURED)


def by_its_size(text: Any) -> bool:
    """Whether a text is placed by its measured size and not by its anchor."""
    return bool(text.get_verticalalignment() == MEASURED)
