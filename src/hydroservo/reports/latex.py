"""A table of a report as LaTeX sets it."""

import re

from hydroservo.reports.table import Table

__all__ = ["latex_text"]

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
LINES = re.compile(r"\s*\n\s*")


def latex_text(table: Table) -> str:
    r"""A table as LaTeX: a ``tabular`` with the rules of the package ``booktabs``, and nothing else.

    A paper puts ``\input{tables/metrics.tex}`` into its own ``table``, with its own caption; what stands out
    is bold. Signs that LaTeX reads as commands are escaped.

    Args:
        table: its title and note become comments.
    """
    texts = [
        [marked(escaped(text), (i, j) in table.marked) for j, text in enumerate(row)]
        for i, row in enumerate(table.rows)
    ]
    about = [LINES.sub(" ", text) for text in (table.title, table.note) if text]
    lines = [
        *(f"% {text}" for text in about),
        "% needs \\usepackage{booktabs}",
        rf"\begin{{tabular}}{{{''.join('r' if column.number else 'l' for column in table.columns)}}}",
        r"\toprule",
        line([escaped(column.heading) for column in table.columns]),
        r"\midrule",
        *map(line, texts),
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(lines) + "\n"


def line(texts: list[str]) -> str:
    return " & ".join(texts) + r" \\"


def marked(text: str, stands_out: bool) -> str:
    return rf"\textbf{{{text}}}" if stands_out else text


def escaped(text: str) -> str:
    """Text that LaTeX sets as it stands, in one line."""
    return EACH.sub(lambda sign: SPECIAL[sign[0]], LINES.sub(" ", text.strip()))
