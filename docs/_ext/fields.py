"""Adds to each documented block, constructor and state the table of its declared numbers and nested blocks.

Docstrings write an absolute value as it is read, ``|s|``; reStructuredText would take it for a substitution.
"""

import inspect
import re
from collections.abc import Callable, Iterator, Sequence
from itertools import compress
from typing import Any, ForwardRef, NamedTuple

from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

from hydroservo.core.field import declared_fields
from hydroservo.core.roles.saying import is_role
from hydroservo.scenario.descriptions import Key, keys_of, range_text


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
    for key in keys_of(maker):
        if key.field is None or key.nests:
            yield Row(key.name, key.shown, "", "", nested(key), "")
        else:
            field = key.field
            yield Row(key.name, key.shown, field.unit, range_text(field), field.meaning, field.source)


def nested(key: Key) -> str:
    """What is under a key that is no number: most often a block of some role, given or by default."""
    known = is_role(key.kind) or is_record(key.kind)
    return f"nested block, {article(key.kind.__name__)} {key.kind.__name__}" if known else "nested"


def article(name: str) -> str:
    return "an" if name[0] in "AEIOU" else "a"


def table(maker: Callable[..., Any]) -> list[str]:
    """The rows of a class or constructor as a reStructuredText list-table; nothing where there are none."""
    if not declares(maker):
        return []
    found = list(rows(maker))
    if not found:
        return []
    if is_state(maker):
        header, lines = STATE, [tuple(getattr(row, name) for name in STATE) for row in found]
    else:
        header, lines = filled(PARAMETERS, found)
    body = [cell for line in (header, *lines) for cell in listed(line)]
    return ["", ".. list-table::", "   :header-rows: 1", "   :class: fields", "", *body, ""]


def declares(maker: Callable[..., Any]) -> bool:
    """Whether all annotations can be looked at: a record of what type checkers alone import has none."""
    kinds = getattr(maker, "__annotations__", {}).values()
    return not any(isinstance(kind, str | ForwardRef) for kind in kinds)


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
