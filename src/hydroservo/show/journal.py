"""Figures and tables as a journal of two columns, or a spreadsheet, takes them."""

import csv
import io
import re
import shutil
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from hydroservo.core.errors import ParameterError
from hydroservo.core.formatting import MINUS, TIMES
from hydroservo.core.outputs import write_text

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot

FIGURE_FORMATS = ("svg", "pdf", "pgf", "png")
USUAL = ("svg", "pdf")
TEX = ("xelatex", "lualatex", "pdflatex")  # which measure the text of a PGF

NUMBER = re.compile(rf"[+\-{MINUS}]?\d+\.\d+(?:e[+-]?\d+| {TIMES} 10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?")


class FigureWidth(StrEnum):
    """How wide a figure is.

    Source: IEEE Author Center, Resolution and Size: one column is 3.5 inch wide, two are 7.16 inch.
    """

    ONE_COLUMN = "one-column"
    TWO_COLUMN = "two-column"

    @property
    def width(self) -> float:
        """In inch."""
        return 3.5 if self is FigureWidth.ONE_COLUMN else 7.16


class Journal(NamedTuple):
    """What figures a journal is to have, and what decimals tables have."""

    formats: Sequence[str] = ()  # endings of their files; none are written if empty
    # how wide they are; as the report's if None. One with three panels side by side is as wide as two
    # columns all the same
    size: FigureWidth | None = None
    decimal_comma: bool = False  # whether CSV has decimal commas, and semicolons between its cells

    def csv(self, text: str) -> str:
        """A CSV table, with the decimals that are wanted."""
        return decimal_commas(text) if self.decimal_comma else text

    def save(self, figure: "Plot", stem: Path, origin: str) -> None:
        """Write a figure in each format; the figure keeps the size that it then has."""
        for form in self.formats:
            figure.save(stem.with_name(f"{stem.name}.{form}"), width=self.size, origin=origin)


NO_JOURNAL = Journal()


def journal_of(
    formats: str | None, size: FigureWidth | None, folder: Path | None, decimal_comma: bool = False
) -> Journal:
    """What is asked for: nothing, or figures of a size in some formats, SVG and PDF if none is named."""
    if folder is None and (formats is not None or size):
        name, value = ("--figure-size", str(size)) if size else ("--figure-format", formats)
        raise ParameterError(name, value, "is of figures in a folder; add --out DIR")
    if formats is None:
        return Journal(USUAL if size else (), size, decimal_comma)
    names = tuple(dict.fromkeys(name.strip() for name in formats.split(",")))
    if not set(names) <= set(FIGURE_FORMATS):
        allowed = f"must be of {', '.join(FIGURE_FORMATS)}, with commas between them"
        raise ParameterError("--figure-format", formats, allowed)
    if "pgf" in names:
        check_latex(formats)
    return Journal(names, size, decimal_comma)


def check_latex(formats: str) -> None:
    """Refuse PGF where there is no LaTeX."""
    if not any(map(shutil.which, TEX)):
        needed = f"needs one of {', '.join(TEX)} for pgf, to measure text; none is installed"
        raise ParameterError("--figure-format", formats, needed)


def decimal_commas(text: str) -> str:
    """CSV with semicolons in place of commas, and commas in place of the points of its numbers."""
    out = io.StringIO()
    writer = csv.writer(out, delimiter=";", lineterminator="\n")
    for row in csv.reader(io.StringIO(text, newline="")):
        writer.writerow([cell.replace(".", ",") if NUMBER.fullmatch(cell) else cell for cell in row])
    return out.getvalue()


def with_decimal_commas(folder: Path) -> None:
    """Write each CSV file of a folder, and of those below it, with decimal commas."""
    for file in folder.rglob("*.csv"):
        write_text(file, decimal_commas(file.read_text(encoding="utf-8")))
