"""The texts of an FMU that depend on what it holds."""

import math
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from hydroservo.errors import one_line

if TYPE_CHECKING:
    import jinja2

__all__ = ["rendered"]


def rendered(template: str, context: Mapping[str, Any]) -> str:
    """A template of this package, filled; what it puts into XML and HTML is escaped."""
    return environment().get_template(f"{template}.j2").render(context)


@cache
def environment() -> "jinja2.Environment":
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("hydroservo.export.fmu"),
        autoescape=jinja2.select_autoescape(["xml.j2", "html.j2"]),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["one_line"] = one_line
    environment.filters["xml_double"] = xml_double
    environment.filters["c_double"] = c_double
    environment.globals["infinity"] = math.inf
    return environment


def c_double(value: float) -> str:
    """A number as C has it, with all its digits."""
    if math.isinf(value):
        return "(double)INFINITY" if value > 0.0 else "-(double)INFINITY"
    return repr(float(value))


def xml_double(value: float) -> str:
    """A number as XML has it, with all its digits."""
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "INF" if value > 0.0 else "-INF"
    return repr(float(value))
