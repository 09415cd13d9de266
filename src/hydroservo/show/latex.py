"""A table as LaTeX sets it."""

import re

from hydroservo.show.table import Mark, Table, note_of, texts_of

LINES = re.compile(r"\s*\n\s*")

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


def latex_of(table: Table) -> str:
    r"""A table as LaTeX: a ``tabular`` with the rules of the package ``booktabs``, and nothing else.

    A paper puts ``\input{tables/metrics.tex}`` into its own ``table``, with its own caption; what is best is
    bold. Signs that LaTeX reads as commands are escaped.
    """
    texts = texts_of(table)
    rows = [
        [latex_bold(in_one_line(text), cell.mark is Mark.BEST) for text, cell in zip(*pair, strict=True)]
        for pair in zip(texts.rows, table.rows, strict=True)
    ]
    about = [LINES.sub(" ", text) for text in (table.title, note_of(table, "Bold:")) if text]
    lines = [
        *(f"% {text}" for text in about),
        "% needs \\usepackage{booktabs}",
        rf"\begin{{tabular}}{{{''.join('r' if right else 'l' for right in texts.right)}}}",
        r"\toprule",
        latex_line(list(map(in_one_line, texts.headings))),
        r"\midrule",
        *map(latex_line, rows),
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(lines) + "\n"


def latex_line(texts: list[str]) -> str:
    return " & ".join(texts) + r" \\"


def latex_bold(text: str, best: bool) -> str:
    return rf"\textbf{{{text}}}" if best else text


def in_one_line(text: str) -> str:
    """Text that LaTeX sets as it stands, in one line."""
    return latex_escaped(LINES.sub(" ", text.strip()))


def latex_escaped(text: str) -> str:
    """Text that LaTeX sets as it stands."""
    return EACH.sub(lambda sign: SPECIAL[sign[0]], text)


def latex_label(text: str) -> str:
    r"""A text of a figure for LaTeX: maths as it is, all else escaped."""
    parts = MATHS.split(text)
    shown = [latex_escaped(one.replace(r"\$", "$")) for one in parts]
    shown[1::2] = [one.replace(r"\mathdefault", "") for one in parts[1::2]]
    return "".join(shown)
