"""The layout of code: C is indented by its braces, and long statements of any language are parted."""

import re
from collections.abc import Iterator, Sequence
from itertools import accumulate, groupby
from typing import NamedTuple

from hydroservo.export.texts import WIDTH

INDENT = "    "
KEPT = ("/*", " *", "#")  # what lines of comments and of the preprocessor begin with
COMMA = re.compile(r"(?<=,) ")


class Syntax(NamedTuple):
    """Where statements of a language may be parted."""

    operator: re.Pattern[str]  # the blank before an operator
    value: re.Pattern[str]  # the blank behind the sign of an assignment
    noted: re.Pattern[str]  # a line and the comment behind it
    begin: str  # of such a comment


C = Syntax(
    re.compile(r" (?=([-+*/%<>?:&|^]|[<>=!]=|<<|>>|&&|\|\|) )"),  # a pointer's * has no blank behind it
    re.compile(r"(?<= =) "),
    re.compile(r"(.*[;,]) (/\* .* \*/)"),
    " /* ",
)
ST = Syntax(
    re.compile(r" (?=([-+*/<>=]|[<>]=|<>|AND|OR|MOD) )"),
    re.compile(r"(?<= :=) "),
    re.compile(r"(.*[;,]) (\(\* .* \*\))"),
    " (* ",
)


def lay_out(text: str) -> str:
    """A text of C, each line of which is a statement as far as its end or the brace that it opens."""
    depth, lines = 0, []
    for line in text.split("\n"):
        if line.startswith(KEPT):
            lines.append(line)
            continue
        statement = line.strip()
        depth -= statement.startswith("}")
        lines += split_statement(statement, INDENT * depth)
        depth += statement.endswith("{")
    return "\n".join(align_comments(lines))


def split_statement(text: str, indent: str, syntax: Syntax = C) -> list[str]:
    """A statement, or a part of one, in as many lines as it takes.

    It is parted behind its =, before its outer operators or, where it has none, in its last brackets.
    """
    if len(indent) + len(text) <= WIDTH or syntax.noted.fullmatch(text):
        return [(indent + text).rstrip()]
    deeper = indent + INDENT
    name, *value = outer_parts(text, syntax.value)
    if value and len(deeper) + len(value[0]) <= WIDTH:
        return [indent + name, deeper + value[0]]
    first, *operands = outer_parts(text, syntax.operator)
    if value and operands and len(indent) + len(first) > WIDTH:
        first, operands = name, outer_parts(value[0], syntax.operator)
    if operands:
        return [
            *split_statement(first, indent, syntax),
            *(line for one in operands for line in split_statement(one, deeper, syntax)),
        ]
    before, inside, after = brackets(text)
    return (
        [indent + before, *lay_out_brackets(inside, deeper, syntax), indent + after]
        if inside
        else [indent + text]
    )


def lay_out_brackets(inside: str, indent: str, syntax: Syntax) -> list[str]:
    """What stands in brackets: in one line, or parted behind each comma, or before each operator."""
    if len(indent) + len(inside) <= WIDTH:
        return [indent + inside]
    parts = outer_parts(inside, COMMA)
    parts = parts if len(parts) > 1 else outer_parts(inside, syntax.operator)
    return [line for one in parts for line in split_statement(one, indent, syntax)]


def outer_parts(text: str, between: re.Pattern[str]) -> list[str]:
    """The parts of a text between these blanks, but for blanks in brackets."""
    found = [i for i, depth in enumerate(depths(text)) if depth == 0 and i > 0 and between.match(text, i)]
    starts, ends = [0, *(i + 1 for i in found)], [*found, len(text)]
    return [text[start:end] for start, end in zip(starts, ends, strict=True)]


def brackets(text: str) -> tuple[str, str, str]:
    """What stands before the last outer brackets, in them, and from their end on."""
    outer = [i for i, depth in enumerate(depths(text)) if depth == 0]
    end = max((i for i in outer if text[i] in ")]}"), default=0)
    start = max((i for i in outer if i < end), default=-1) + 1
    return text[: start + 1], text[start + 1 : end], text[end:]


def depths(text: str) -> list[int]:
    """In how many brackets each sign of a text stands; the end of brackets is outside of them."""
    return list(accumulate((sign in "([{") - (sign in ")]}") for sign in text))


def align_comments(lines: Sequence[str], syntax: Syntax = C) -> Iterator[str]:
    """Lines whose comments begin in one column where lines that follow each other have one behind them."""
    for noted, group in groupby(lines, lambda line: syntax.noted.fullmatch(line) is not None):
        pairs = [line.rpartition(syntax.begin) if noted else (line, "", "") for line in group]
        width = max(len(code) for code, _, _ in pairs)
        yield from (f"{code:<{width}}{sign}{rest}" if noted else code for code, sign, rest in pairs)
