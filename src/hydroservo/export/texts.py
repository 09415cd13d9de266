"""The texts of an export: what names it, its comments, and what depends on its content, from templates."""

import math
import re
import textwrap
from collections.abc import Mapping
from functools import cache
from itertools import islice
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from hydroservo.core.errors import HydroservoError, ParameterError, one_line
from hydroservo.export.unit import Part, Signal
from hydroservo.language.names import is_identifier

if TYPE_CHECKING:
    import jinja2

WIDTH = 110  # of the longest line, as of the docstrings that comments come from
OURS = "Written by hydroservo"
OWN = re.compile(rf"{OURS}|\(scenario hash \w+, hydroservo ")  # the latter as vectors once began
FIRST_LINES = 8
MARKUP = re.compile(r"``|(?<=:):$|:\w+:(?=`)|`~?", re.MULTILINE)
TAKEN = re.compile(
    # headers of C itself
    "assert|complex|ctype|errno|fenv|float|inttypes|iso646|limits|locale|math|setjmp|signal|stdarg|stdbool|"
    "stddef|stdint|stdio|stdlib|string|tgmath|time|wchar|wctype|"
    # sources of an FMU, and the headers of FMI
    "instance|model|samples|steps|ticks|equations|fmi2.*|fmi3.*"
)
PLAIN = frozenset(range(32, 127)) - frozenset(b'"\\?')  # of a string in C; ?? may begin a trigraph


def comment(text: str, begin: str = "/*", end: str = "*/") -> str:
    """A comment of one or more lines, from a text that may be marked up as docstrings are."""
    printable = map(one_line, MARKUP.sub("", text).expandtabs().split("\n"))
    plain = unended("\n".join(printable), begin, end).rstrip()
    lines = plain.split("\n")
    if len(lines) == 1 and len(plain) + 6 <= WIDTH:
        return f"{begin} {plain} {end}\n"
    return "\n".join([begin, *(f" * {line}".rstrip() for line in lines), f" {end}", ""])


def unended(text: str, begin: str = "/*", end: str = "*/") -> str:
    """A text that neither begins nor ends a comment, whatever its lines end with.

    In C a backslash at the end of a line joins it with the next one before comments are found; ??/ is one.
    """
    whole = re.sub(r"\\[ \t\\]*$", "", text.replace("??", "? ?"), flags=re.MULTILINE)
    return whole.replace(end, " ".join(end)).replace(begin, " ".join(begin))


def in_comment(text: str, begin: str = "/*", end: str = "*/") -> str:
    """A text of one line for the inside of a comment."""
    return unended(one_line(" ".join(text.split())), begin, end).strip()


def default_prefix(scenario: str, part: Part) -> str:
    """A prefix from a scenario's name or file: ``sine_tsmc`` from ``paper/sine-tsmc``, for its controller.

    Those of other parts begin with the word for the part, so that all can be linked together.
    """
    name = PurePath(scenario).name.removesuffix(".toml")
    word = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_").lower()
    if part is Part.CONTROLLER:
        return word if is_usable(word) else f"law_{word}".rstrip("_")
    return f"{part}_{word}".rstrip("_")


def checked_prefix(prefix: str) -> str:
    """The prefix, if names in C and files of an export, as C or an FMU, may begin with it."""
    if not isinstance(prefix, str) or not is_usable(prefix):
        wanted = "must be letters, digits and underscores, first a letter, and not a name that C or FMI uses"
        raise ParameterError("prefix", prefix, wanted)
    return prefix


def is_usable(prefix: str) -> bool:
    return is_identifier(prefix) and prefix[0] != "_" and TAKEN.fullmatch(prefix.casefold()) is None


def plain_title(title: str) -> str:
    """A title in one line, which may stand in a comment of C."""
    return in_comment(title)


def check_ours(path: Path) -> None:
    """Refuse to replace a file that is not of an earlier export, as its first lines say."""
    try:
        if not path.exists():
            return
        with path.open(encoding="utf-8", errors="replace") as file:
            if any(OWN.search(line) for line in islice(file, FIRST_LINES)):
                return
    except OSError as error:
        raise HydroservoError(f"{path}: cannot be read: {error.strerror}") from None
    raise HydroservoError(f"{path}: not written by hydroservo, and not replaced; choose another folder")


def render(template: str, context: Mapping[str, Any]) -> str:
    """A template, filled; what it puts into XML and HTML is escaped."""
    return environment().get_template(f"{template}.j2").render(context)


@cache
def environment() -> "jinja2.Environment":
    import jinja2

    found = jinja2.Environment(
        loader=jinja2.PackageLoader("hydroservo.export"),
        autoescape=jinja2.select_autoescape(["xml.j2", "html.j2"]),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    found.filters |= {
        "c_comment": in_comment,
        "c_double": c_double,
        "c_string": c_string,
        "cell": markdown_cell,
        "labelled": label_with_unit,
        "number": repr,
        "one_line": one_line,
        "in_rows": lambda numbers: textwrap.fill(", ".join(numbers), 100, break_on_hyphens=False),
        "wrapped": lambda text: textwrap.wrap(text, 100),
        "xml_double": xml_double,
    }
    found.tests["bound"] = is_bound
    return found


def c_double(value: float) -> str:
    """A number as a C99 constant that holds every bit."""
    if math.isfinite(value):
        return float(value).hex()
    return "NAN" if math.isnan(value) else "INFINITY" if value > 0.0 else "-INFINITY"


def c_string(text: str) -> str:
    """Text as it stands between the quotes of a string in C."""
    return "".join(chr(byte) if byte in PLAIN else f"\\{byte:03o}" for byte in text.encode())


def xml_double(value: float) -> str:
    """A number as XML has it, with all its digits."""
    if math.isfinite(value):
        return repr(float(value))
    return "NaN" if math.isnan(value) else "INF" if value > 0.0 else "-INF"


def is_bound(value: float) -> bool:
    """True for the end of a range that can be declared, as FMI takes it to belong to the range.

    What must lie above 0 has the least number above 0, whose text is longer than that of 0: a tool that takes
    it for the end would show it, and one that is told 0 would set it.
    """
    beside = (math.nextafter(value, -math.inf), math.nextafter(value, math.inf))
    return math.isfinite(value) and all(len(repr(value)) <= len(repr(one)) for one in beside)


def label_with_unit(signal: Signal) -> str:
    """Such as ``controller.u [V]``."""
    return f"{signal.path} [{signal.unit}]" if signal.unit else signal.path


def markdown_cell(text: str) -> str:
    """Text as it stands in a cell of a table in Markdown."""
    return re.sub(r"([\\|*<\[])", r"\\\1", one_line(" ".join(text.split())))
