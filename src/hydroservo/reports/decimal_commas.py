"""CSV as spreadsheets read it where decimals have a comma: semicolons between the cells."""

import csv
import io
import re
from pathlib import Path

from hydroservo.formatting import MINUS, TIMES
from hydroservo.outputs import write_text

NUMBER = re.compile(rf"[+\-{MINUS}]?\d+\.\d+(?:e[+-]?\d+| {TIMES} 10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?")


def decimal_commas(text: str) -> str:
    """CSV with semicolons in place of commas, and commas in place of the points of its numbers.

    Args:
        text: CSV with commas, its decimals with points.
    """
    out = io.StringIO()
    writer = csv.writer(out, delimiter=";", lineterminator="\n")
    for row in csv.reader(io.StringIO(text, newline="")):
        writer.writerow([cell.replace(".", ",") if NUMBER.fullmatch(cell) else cell for cell in row])
    return out.getvalue()


def with_decimal_commas(folder: Path) -> None:
    """Write each CSV file of a folder, and of those below it, with decimal commas.

    Raises:
        HydroservoError: one cannot be written.
    """
    for file in folder.rglob("*.csv"):
        write_text(file, decimal_commas(file.read_text(encoding="utf-8")))
