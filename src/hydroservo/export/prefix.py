"""What names an export: the prefix of its names and files, and its title."""

import re
from pathlib import PurePath

from hydroservo.errors import ParameterError
from hydroservo.export.comments import in_comment
from hydroservo.export.unit import Part
from hydroservo.language.names import is_identifier

TAKEN = re.compile(
    # headers of C itself
    "assert|complex|ctype|errno|fenv|float|inttypes|iso646|limits|locale|math|setjmp|signal|stdarg|stdbool|"
    "stddef|stdint|stdio|stdlib|string|tgmath|time|wchar|wctype|"
    # sources of an FMU, and the headers of FMI
    "instance|model|samples|steps|ticks|equations|fmi2.*|fmi3.*"
)


def default_prefix(scenario: str, part: Part) -> str:
    """A prefix from a scenario's name or file: ``sine_tsmc`` from ``paper/sine-tsmc``, for its controller.

    Those of other parts begin with the word for the part, so that all can be linked together.
    """
    name = PurePath(scenario).name.removesuffix(".toml")
    word = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_").lower()
    if part is Part.CONTROLLER:
        return word if usable(word) else f"law_{word}".rstrip("_")
    return f"{part}_{word}".rstrip("_")


def checked_prefix(prefix: str) -> str:
    """The prefix, if names in C and files of an export, as C or an FMU, may begin with it."""
    if not isinstance(prefix, str) or not usable(prefix):
        wanted = "must be letters, digits and underscores, first a letter, and not a name that C or FMI uses"
        raise ParameterError("prefix", prefix, wanted)
    return prefix


def usable(prefix: str) -> bool:
    return is_identifier(prefix) and prefix[0] != "_" and TAKEN.fullmatch(prefix.casefold()) is None


def plain_title(title: str) -> str:
    """A title in one line, which may stand in a comment of C."""
    return in_comment(title)
