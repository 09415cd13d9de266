"""The rows of a text of cells, and the numbers and instants in these."""

import csv
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from datetime import datetime
from io import StringIO

from hydroservo.core.errors import ScenarioError, short

LONGEST_LINE = 1 << 16  # characters
COMMA = ","
BLANKS = " "
DELIMITERS = {COMMA: "commas", ";": "semicolons", "\t": "tabs", BLANKS: "blanks"}
WORD = re.compile(r'"([^"]*)"|(\S+(?:[ ]?(?:\[[^]]*\]|\([^)]*\)))?)')  # a unit belongs to the word before it
NUMBER = re.compile(r"\s*[-+]?[.,]?[0-9]")
COMMENTS = ("#", "%", "//", "!", "sep=", "SEP=")  # "sep=;" is a hint to spreadsheets
MARKS = re.compile(r"[.,]")
WORDS = {".": "point", ",": "comma"}
GROUPED = re.compile(r"[+-]?[1-9][0-9]{0,2}(?:[.,' \u00a0\u2009\u202f\u2019][0-9]{3})+(?:[.,][0-9]*)?")
CLOCK = re.compile(r"[0-9]:[0-9]{2}")
MISSING = ("", "nan", "na", "n/a", "null", "none", "-", "--", "#n/a", "#div/0!", "#num!", "#value!", "#ref!")
SECOND = 10**9  # ns
DAY = 86400 * SECOND
TIME_OF_DAY = re.compile(
    r"(?:(?P<date>\S.*?)[ T]\s*)?"
    r"(?:(?P<hours>[0-9]{1,3}):)?(?P<minutes>[0-9]{1,2}):(?P<seconds>[0-9]{2}(?:[.,:][0-9]+)?)"
    r"\s*(?P<half>[AaPp][Mm])?\s*(?P<zone>Z|UTC|[+-][0-9]{2}:?[0-9]{2})?"
)
DATE = re.compile(r"[0-9]{1,4}[-./][0-9A-Za-z]{1,3}[-./][0-9]{1,4}|[0-9]+ days?|[A-Za-z0-9 ,]*[0-9]{4}")


def numbered_lines(text: str, name: str) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(StringIO(text.rstrip("\r\n"), newline=""), 1):
        if len(line) > LONGEST_LINE:
            raise ScenarioError(name, f"line {number}", f"is longer than {LONGEST_LINE} characters")
        yield number, line


def is_comment(line: str) -> bool:
    """True for a line that holds no cells, with a sign in front that says so."""
    return line.lstrip().startswith(COMMENTS)


def split_line(line: str, delimiter: str) -> list[str]:
    if delimiter == BLANKS:
        return [quoted or word for quoted, word in WORD.findall(line)]
    with suppress(csv.Error):
        return next(csv.reader([line], delimiter=delimiter, strict=True), [])
    return []


def filled_cells(row: Sequence[str]) -> int:
    """How many cells a row has, but for empty ones at its end, which spreadsheets write."""
    return max((i for i, cell in enumerate(row, 1) if cell.strip()), default=0)


def numbered_rows(
    lines: Iterable[tuple[int, str]], delimiter: str, columns: int, fewest: int, name: str
) -> Iterator[tuple[int, list[str]]]:
    """The rows with the number of their line, each with as many cells as there are columns."""
    number = 0

    def cells() -> Iterator[str]:
        nonlocal number
        for number, line in lines:  # noqa: B007 - it is the place of an error
            if not is_comment(line) or filled_cells(split_line(line, delimiter)) >= columns:
                yield line

    reader: Iterator[list[str]] = (
        (split_line(line, BLANKS) for line in cells())
        if delimiter == BLANKS
        else csv.reader(cells(), delimiter=delimiter, strict=True)
    )
    try:
        for row in reader:
            filled = filled_cells(row)
            fits = filled <= columns if len(row) >= columns else len(row) >= fewest
            if filled and not fits:
                raise ScenarioError(name, f"line {number}", row_problem(row, columns, delimiter))
            yield number, [*row[:columns], *[""] * (columns - len(row))]
    except csv.Error as error:
        raise ScenarioError(name, f"line {number}", f"is not CSV: {error}") from None


def row_problem(row: Sequence[str], columns: int, delimiter: str) -> str:
    """What is wrong with a row of another length than the header."""
    if len(row) == 1 and len(row[0].split()) == columns and NUMBER.match(row[0]):
        return f"is separated by blanks, and the header by {DELIMITERS[delimiter]}; separate all lines alike"
    commas = delimiter == COMMA and len(row) > columns
    advice = "; with decimal commas, semicolons must separate them" if commas else ""
    return f"has {len(row)} cell{'s' * (len(row) > 1)}; the header has {columns}{advice}"


class Decimals:
    """Reads the numbers of one file, and sees to it that they have one decimal mark.

    Where commas separate cells, the mark is a point. Elsewhere it is what the cells have. That "1,234" is not
    1234 is known from any other cell that has the mark and cannot be a number with its thousands separated,
    such as "0,5".
    """

    def __init__(self, delimiter: str, name: str) -> None:
        self.either, self.name = delimiter != COMMA, name
        self.mark, self.first, self.sure = "", ("", 0, ""), False

    def number(self, text: str, line: int, column: str) -> float:
        """The finite number that a cell says."""
        marks = MARKS.findall(text) if self.either else ()
        value = parse_number(text.replace(",", ".") if len(marks) == 1 else text)
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


def parse_number(text: str) -> float | None:
    """The finite number with a decimal point, or none, that a text says; None if it says no such number."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text else None


def is_missing(text: str) -> bool:
    """True for a cell that says that there is no number."""
    return text.strip().lower() in MISSING


class Clock:
    """Reads the instants of one column, in seconds from the first.

    What follows the date may be "08:00:00.010", "08:00:00,010", "8:00:00.01 PM" or "00:01.5", of minutes. ISO
    8601 dates are days of the calendar. In any other form (05/01 may be in May or in January) a change of
    date counts as one day, so a gap of several days is read as one. Without a date the day changes where an
    instant is half a day or more before the one in front of it.
    """

    def __init__(self) -> None:
        self.first: int | None = None
        self.days, self.date, self.before = 0, "", 0

    def seconds(self, text: str) -> float | None:
        """The instant that a cell says [s]; None if it says none."""
        match = TIME_OF_DAY.fullmatch(text.strip())
        date = (match["date"] or "").strip() if match else ""
        if match is None or (date and not DATE.fullmatch(date)):
            return None
        hours, minutes = int(match["hours"] or 0), int(match["minutes"])
        if match["half"]:
            hours = hours % 12 + 12 * (match["half"].lower() == "pm")
        seconds = float(re.sub("[,:]", ".", match["seconds"]))
        time = (hours * 3600 + minutes * 60) * SECOND + round(seconds * SECOND)
        instant = self.day(date, time) * DAY + time - zone_of(match["zone"] or "")
        self.first = instant if self.first is None else self.first
        return (instant - self.first) / SECOND

    def day(self, date: str, time: int) -> int:
        """The number of an instant's day."""
        with suppress(ValueError):
            return datetime.fromisoformat(date).toordinal()
        new_day = date != self.date if date and self.date else time < self.before - DAY // 2
        self.days, self.date, self.before = self.days + new_day, date, time
        return self.days


def zone_of(text: str) -> int:
    """How far the clock of a zone such as "+02:00" is ahead [ns]."""
    digits = re.sub("[^0-9]", "", text)
    if not digits:
        return 0
    ahead = (int(digits[:2]) * 60 + int(digits[2:])) * 60 * SECOND
    return -ahead if text.startswith("-") else ahead


def is_instant(text: str) -> bool:
    """True for a cell that holds a time of day, with or without a date."""
    return Clock().seconds(text) is not None
