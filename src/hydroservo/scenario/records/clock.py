"""Instants as dates and times of day."""

import re
from contextlib import suppress
from datetime import datetime

SECOND = 10**9  # ns
DAY = 86400 * SECOND
TIME_OF_DAY = re.compile(
    r"(?:(?P<date>\S.*?)[ T]\s*)?"
    r"(?:(?P<hours>[0-9]{1,3}):)?(?P<minutes>[0-9]{1,2}):(?P<seconds>[0-9]{2}(?:[.,:][0-9]+)?)"
    r"\s*(?P<half>[AaPp][Mm])?\s*(?P<zone>Z|UTC|[+-][0-9]{2}:?[0-9]{2})?"
)
DATE = re.compile(r"[0-9]{1,4}[-./][0-9A-Za-z]{1,3}[-./][0-9]{1,4}|[0-9]+ days?|[A-Za-z0-9 ,]*[0-9]{4}")


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
