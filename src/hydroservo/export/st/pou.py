"""Structures, functions and function blocks of Structured Text, and their text."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from hydroservo.export.layout import INDENT, ST, align_comments
from hydroservo.export.texts import WIDTH, comment, in_comment

Value = str | Sequence[str]  # of a number or an array


class Declaration(NamedTuple):
    """A variable or a field."""

    name: str
    kind: str  # its type
    note: str = ""  # what it is, with its unit
    value: Value | None = None  # the first one; None is that of the type
    length: int = 0  # of an array; 0 for all else

    @property
    def type(self) -> str:
        """Its type, an array's too."""
        return f"ARRAY[0..{self.length - 1}] OF {self.kind}" if self.length else self.kind


class Structure(NamedTuple):
    """A structure's type."""

    name: str
    about: str
    fields: Sequence[Declaration]

    @property
    def text(self) -> str:
        """Its definition."""
        fields = map(declaration_line, self.fields)
        lines = [
            f"{block_comment(self.about)}TYPE {self.name} :",
            "STRUCT",
            *fields,
            "END_STRUCT;",
            "END_TYPE",
            "",
        ]
        return "\n".join(align_comments(lines, ST))


class Pou(NamedTuple):
    """A program organisation unit: a function or a function block."""

    name: str
    returns: str  # the type of a function's value; empty for a function block
    about: str  # what it is
    sections: Mapping[str, Sequence[Declaration]]  # its declarations, by what stands at the head of each
    body: Sequence[str]  # its statements, line by line

    @property
    def keyword(self) -> str:
        """FUNCTION or FUNCTION_BLOCK."""
        return "FUNCTION" if self.returns else "FUNCTION_BLOCK"

    @property
    def declaration(self) -> str:
        """All before its statements."""
        value = f" : {self.returns}" if self.returns else ""
        lines = [f"{block_comment(self.about)}{self.keyword} {self.name}{value}"]
        for head, declared in self.sections.items():
            if declared:
                lines += [head, *map(declaration_line, declared), "END_VAR"]
        return "\n".join(align_comments("\n".join(lines).split("\n"), ST))

    @property
    def text(self) -> str:
        """Its definition."""
        return "\n".join([self.declaration, *self.body, f"END_{self.keyword}", ""])


def declaration_line(declared: Declaration) -> str:
    """A declaration: in one line, but for an array's."""
    value = declared.value
    if value is not None and not isinstance(value, str):
        rows = textwrap.fill(", ".join(value), WIDTH, initial_indent=2 * INDENT, subsequent_indent=2 * INDENT)
        remark = f"{INDENT}(* {declared.note} *)\n" if declared.note else ""
        return f"{remark}{INDENT}{declared.name} : {declared.type} := [\n{rows}\n{INDENT}];"
    first = "" if value is None else f" := {value}"
    remark = f" (* {declared.note} *)" if declared.note else ""
    return f"{INDENT}{declared.name} : {declared.type}{first};{remark}"


def block_comment(about: str) -> str:
    """A comment of one or more lines above a definition."""
    return comment(about, "(*", "*)") if about else ""


def remark(unit: str, meaning: str) -> str:
    """What is said behind a declaration."""
    return in_comment(f"{f'[{unit}] ' if unit else ''}{meaning}", "(*", "*)")
