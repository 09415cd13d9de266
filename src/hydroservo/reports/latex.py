"""A table of a report as LaTeX sets it."""

import re

from hydroservo.figures.latex_text import escaped
from hydroservo.reports.table import Table

LINES = re.compile(r"\s*\n\s*")


def latex_text(table: Table) -> str:
    r"""A table as LaTeX: a ``tabular`` with the rules of the package ``booktabs``, and nothing else.

    A paper puts ``\input{tables/metrics.tex}`` into its own ``table``, with its own caption; what stands out
    is bold. Signs that LaTeX reads as commands are escaped.

    Args:
        table: its title and note become comments.
    """
    texts = [
        [marked(in_one_line(text), (i, j) in table.marked) for j, text in enumerate(row)]
        for i, row in enumerate(table.rows)
    ]
    about = [LINES.sub(" ", text) for text in (table.title, table.note) if text]
    lines = [
        *(f"% {text}" for text in about),
        "% needs \\usepackage{booktabs}",
        rf"\begin{{tabular}}{{{''.join('r' if column.number else 'l' for column in table.columns)}}}",
        r"\toprule",
        line([in_one_line(column.heading) for column in table.columns]),
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


def in_one_line(text: str) -> str:
    """Text that LaTeX sets as it stands, in one line."""
    return escaped(LINES.sub(" ", text.strip()))
