"""The texts of an export that depend on what it holds, from this package's templates."""

import math
import re
import textwrap
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from hydroservo.errors import one_line
from hydroservo.export.comments import in_comment
from hydroservo.export.unit import Signal

if TYPE_CHECKING:
    import jinja2

PLAIN = frozenset(range(32, 127)) - frozenset(b'"\\?')  # of a string in C; ?? may begin a trigraph


def rendered(template: str, context: Mapping[str, Any]) -> str:
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
        "cell": cell,
        "labelled": labelled,
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


def labelled(signal: Signal) -> str:
    """Such as ``controller.u [V]``."""
    return f"{signal.path} [{signal.unit}]" if signal.unit else signal.path


def cell(text: str) -> str:
    """Text as it stands in a cell of a table in Markdown."""
    return re.sub(r"([\\|*<\[])", r"\\\1", one_line(" ".join(text.split())))
