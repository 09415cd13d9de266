"""Numbers in cells, with a decimal point or a decimal comma."""

import math
import re

from hydroservo.errors import ScenarioError, short
from hydroservo.scenario.records.rows import COMMA

MARKS = re.compile(r"[.,]")
WORDS = {".": "point", ",": "comma"}
GROUPED = re.compile(r"[+-]?[1-9][0-9]{0,2}(?:[.,' \u00a0\u2009\u202f\u2019][0-9]{3})+(?:[.,][0-9]*)?")
CLOCK = re.compile(r"[0-9]:[0-9]{2}")
MISSING = ("", "nan", "na", "n/a", "null", "none", "-", "--", "#n/a", "#div/0!", "#num!", "#value!", "#ref!")


class Decimals:
    """Reads the numbers of one file, and sees to it that they have one decimal mark.

    Where commas separate cells, the mark is a point. Elsewhere it is what the cells have. That "1,234" is not
    1234 is known from any other cell that has the mark and cannot be a number with its thousands separated,
    such as "0,5".

    Args:
        delimiter: what separates the cells of the file.
        name: the file that an error names.
    """

    def __init__(self, delimiter: str, name: str) -> None:
        self.either, self.name = delimiter != COMMA, name
        self.mark, self.first, self.sure = "", ("", 0, ""), False

    def number(self, text: str, line: int, column: str) -> float:
        """The finite number that a cell says."""
        marks = MARKS.findall(text) if self.either else ()
        value = number(text.replace(",", ".") if len(marks) == 1 else text)
        if value is None:
            raise self.error(line, column, self.problem(text))
        if marks:
            self.see(marks[0], text, line, column)
        return value

    def see(self, mark: str, text: str, line: int, column: str) -> None:
        """Take note of a decimal mark."""
        if not self.mark:
            self.mark, self.first = mark, (text, line, column)
        elif mark != self.mark:
            before = f"{short(self.first[0])} in line {self.first[1]} a decimal {WORDS[self.mark]}"
            raise self.error(line, column, f"{short(text)} has a decimal {WORDS[mark]}, and {before}")
        self.sure = self.sure or not GROUPED.fullmatch(text.strip())

    def check(self) -> None:
        """Refuse numbers whose marks may all separate thousands."""
        if self.mark and not self.sure:
            text, line, column = self.first
            word = WORDS[self.mark]
            problem = (
                f"{short(text)} may have a decimal {word} or a {word} between thousands, as all numbers here"
            )
            raise self.error(
                line, column, f"{problem}; write more or fewer than three decimals, or no {word}"
            )

    def problem(self, text: str) -> str:
        """What is wrong with a cell that says no number."""
        if not text.strip():
            return "is empty; it must be a number"
        if CLOCK.search(text):
            return f"{short(text)} is a time of day; it must be a number"
        if "," in text and not self.either:
            return (
                f"{short(text)} has a comma, and commas separate the cells; decimals must have a point here"
            )
        if GROUPED.fullmatch(text.strip()):
            return f"{short(text)} has its thousands separated; write numbers without"
        return f"{short(text)} must be a finite number"

    def error(self, line: int, column: str, problem: str) -> ScenarioError:
        return ScenarioError(self.name, f"line {line}, column {column}", problem)


def number(text: str) -> float | None:
    """The finite number with a decimal point, or none, that a text says; None if it says no such number."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text else None


def is_missing(text: str) -> bool:
    """True for a cell that says that there is no number."""
    return text.strip().lower() in MISSING
