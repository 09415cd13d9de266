"""The prefix of an export's names and files."""

import re
from pathlib import PurePath

from hydroservo.errors import ParameterError
from hydroservo.export.names import is_identifier

__all__ = ["checked_prefix", "default_prefix"]

HEADERS = re.compile(
    "assert|complex|ctype|errno|fenv|float|inttypes|iso646|limits|locale|math|setjmp|signal|stdarg|stdbool|"
    "stddef|stdint|stdio|stdlib|string|tgmath|time|wchar|wctype"
)  # of C itself


def default_prefix(scenario: str) -> str:
    """A prefix from a scenario's name or file: ``sine_tsmc`` from ``paper/sine-tsmc``."""
    name = PurePath(scenario).name.removesuffix(".toml")
    word = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_").lower()
    return word if usable(word) else f"law_{word}".rstrip("_")


def checked_prefix(prefix: str) -> str:
    """The prefix, if C names and files may begin with it.

    Raises:
        ParameterError: it is no C identifier, is reserved, or its header would be one of C's own.
    """
    if not usable(prefix):
        wanted = "must be letters, digits and underscores, a letter first, and no name that C has taken"
        raise ParameterError("prefix", prefix, wanted)
    return prefix


def usable(prefix: str) -> bool:
    return is_identifier(prefix) and prefix[0] != "_" and HEADERS.fullmatch(prefix.lower()) is None
