"""Adds to each documented block, constructor and state the table of its declared numbers and nested blocks.

Docstrings write an absolute value as it is read, ``|s|``; reStructuredText would take it for a substitution.
"""

import inspect
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import compress
from typing import Any, NamedTuple, get_type_hints

import numpy as np
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

from hydroservo.block import is_block
from hydroservo.field import Field, declared_fields


class Row(NamedTuple):
    """What one key of a scenario table, or one number of a state, is."""

    name: str
    default: str
    unit: str
    allowed: str
    meaning: str
    source: str


Line = tuple[str, ...]
PARAMETERS: Line = Row("key", "default", "unit", "range", "meaning", "source")
STATE: Line = ("name", "unit", "meaning")
CODE_OR_BAR = re.compile(r"``.*?``|\|")


def rows(maker: Callable[..., Any]) -> Iterator[Row]:
    """One row for each field of a block or state class, or argument of a constructor, in declared order."""
    fields, known = declared_fields(maker), defaults(maker)
    for name in inspect.signature(maker).parameters:
        default, field = known.get(name), fields.get(name)
        if is_block(default):
            yield Row(name, type(default).__name__, "", "", nested(maker, name), "")
        elif field is None:
            yield Row(name, written(default), "", "", nested(maker, name), "")
        else:
            automatic = isinstance(default, float | int) and default == field.auto
            value = '"auto"' if automatic else written(default)
            yield Row(name, value, field.unit, bounds(field), field.meaning, field.source)


def defaults(maker: Callable[..., Any]) -> Mapping[str, Any]:
    """The defaults of fields or arguments; autodoc has replaced those in a signature by their text."""
    if is_record(maker):
        return maker._field_defaults  # type: ignore[attr-defined, no-any-return]
    names, values = [*inspect.signature(maker).parameters], maker.__defaults__ or ()  # type: ignore[attr-defined]
    return dict(zip(names[len(names) - len(values) :], values, strict=True))


def nested(maker: Callable[..., Any], name: str) -> str:
    """What is under a key that is no number: most often a block of some role, given or by default."""
    hint = get_type_hints(maker)[name]
    known = getattr(hint, "_is_protocol", False) or is_record(hint)
    return f"nested block, {article(hint.__name__)} {hint.__name__}" if known else "nested"


def article(name: str) -> str:
    return "an" if name[0] in "AEIOU" else "a"


def written(default: Any) -> str:
    if isinstance(default, bool):
        return str(default).lower()
    if isinstance(default, np.ndarray):
        return "from a file"
    return f"{default:g}" if isinstance(default, (int, float)) else ""


def bounds(field: Field) -> str:
    limits = ((">", field.above), ("≥", field.at_least), ("<", field.below), ("≤", field.at_most))
    found = [f"{sign} {limit:g}" for sign, limit in limits if limit is not None]
    return ", ".join(found if field.auto is None else [*found, 'or "auto"'])


def table(maker: Callable[..., Any]) -> list[str]:
    """The rows of a class or constructor as a reStructuredText list-table; nothing where there are none."""
    found = list(rows(maker))
    if not found:
        return []
    if is_state(maker):
        header, lines = STATE, [tuple(getattr(row, name) for name in STATE) for row in found]
    else:
        header, lines = filled(PARAMETERS, found)
    body = [cell for line in (header, *lines) for cell in listed(line)]
    return ["", ".. list-table::", "   :header-rows: 1", "   :class: fields", "", *body, ""]


def filled(header: Line, lines: Sequence[Line]) -> tuple[Line, list[Line]]:
    """A header and lines without the columns that are empty in all lines."""
    keep = [any(column) for column in zip(*lines, strict=True)]
    header, *rest = (tuple(compress(line, keep)) for line in (header, *lines))
    return header, rest


def listed(line: Line) -> Iterator[str]:
    first, *rest = (linked(re.sub(r"([*_|])", r"\\\1", cell)) for cell in line)
    yield f"   * - {first}"
    yield from (f"     - {cell}" for cell in rest)


def linked(text: str) -> str:
    """A text with its DOIs as short links."""
    return re.sub(r"doi:(10\.[^\s,;]+)", r"`doi <https://doi.org/\1>`__", text)


def is_record(thing: Any) -> bool:
    return isinstance(thing, type) and issubclass(thing, tuple) and hasattr(thing, "_fields")


def is_state(thing: Any) -> bool:
    """True for a record that is no block: it has neither defaults nor methods."""
    return is_record(thing) and not thing._field_defaults and not any(map(inspect.isfunction, own(thing)))


def own(cls: type) -> Iterator[Any]:
    return (value for name, value in vars(cls).items() if not name.startswith("_"))


def is_constructor(thing: Any) -> bool:
    """True for a classmethod whose arguments are declared as a block's fields."""
    return inspect.ismethod(thing) and is_record(thing.__self__) and bool(declared_fields(thing))


def escaped(lines: list[str]) -> Iterator[str]:
    """The lines with the bars of absolute values escaped, but for literal blocks and code."""
    literal = None
    for line in lines:
        if line.startswith("Fails "):  # on a line of its own in the text, so in a paragraph of its own here
            yield ""
        indent = len(line) - len(line.lstrip())
        if line.strip() and literal is not None and indent <= literal:
            literal = None
        yield (
            line
            if literal is not None
            else CODE_OR_BAR.sub(lambda found: r"\|" if found[0] == "|" else found[0], line)
        )
        if literal is None and line.endswith("::"):
            literal = indent


def complete(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    lines[:] = escaped(lines)
    if is_record(thing) or is_constructor(thing):
        lines += table(thing)


def drop_signature(
    app: Sphinx, what: str, name: str, thing: Any, options: Any, signature: str, returns: str
) -> tuple[str, str] | None:
    """The table says what a block takes, and nobody calls a role."""
    told = is_record(thing) or is_constructor(thing) or getattr(thing, "_is_protocol", False)
    return ("", "") if told else None


def skip_fields(app: Sphinx, what: str, name: str, thing: Any, skip: bool, options: Any) -> bool | None:
    return True if type(thing).__name__ == "_tuplegetter" else None


def setup(app: Sphinx) -> ExtensionMetadata:
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", complete)
    app.connect("autodoc-process-signature", drop_signature)
    app.connect("autodoc-skip-member", skip_fields)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
