"""Writes translated functions and records as C99."""

import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from hydroservo.core.field import Field
from hydroservo.export.single import SINGLE, single_literal
from hydroservo.export.texts import comment, in_comment
from hydroservo.export.translation import UnitWriter, about_record, first_paragraph
from hydroservo.language import terms
from hydroservo.language.liveness import Liveness, matters
from hydroservo.language.names import free_name, identifier
from hydroservo.language.ranges import LARGEST

ATOM, UNARY, PRODUCT, SUM, COMPARED, AND, OR, CHOICE = 8, 7, 6, 5, 4, 3, 2, 1
LEVELS = {"*": PRODUCT, "/": PRODUCT, "+": SUM, "-": SUM, "&&": AND, "||": OR}
PLAIN = {terms.INT: "int64_t", terms.BOOL: "bool"}
SHORT = 2**31  # whole numbers below need no suffix, and loops up to here a short counter


class FunctionEnds(NamedTuple):
    """What a function begins and ends with besides its own statements."""

    first: Sequence[str]
    last: Sequence[str]


class NamedConstant(NamedTuple):
    """A number that has a name in C, and what it was computed from."""

    name: str
    number: str
    text: str = ""


class CWriter(UnitWriter):
    """The C text of functions and records; numbers are of type double or float."""

    def __init__(
        self, prefix: str, real: str, needed: Liveness, signals: Mapping[terms.Record, Sequence[Field | None]]
    ) -> None:
        super().__init__(prefix, real, needed, signals)
        self.constants: dict[tuple[str, str, float], NamedConstant] = {}
        self.pointers: dict[str, bool] = {}  # of the function at hand: whether a name is a pointer
        self.renamed: dict[str, str] = {}

    # types

    def type(self, kind: terms.Type) -> str:
        """A type's name in C."""
        if isinstance(kind, terms.Record):
            return f"{self.prefix}_{kind.name}"
        return self.real if kind == terms.REAL else PLAIN[kind]  # type: ignore[index]

    def record(self, record: terms.Record) -> str:
        """The definition of a record's type."""
        body = []
        for name, kind, field in self.declared(record):
            remark = in_comment(f"{f'[{field.unit}] ' if field.unit else ''}{field.meaning}")
            body.append(f"{self.type(kind)} {identifier(name)};" + (f" /* {remark} */" if remark else ""))
        about = about_record(record)
        lines = ["typedef struct {", *body, f"}} {self.type(record)};", ""]
        return (comment(about) if about else "") + "\n".join(lines)

    # functions

    def function(self, function: terms.Function) -> str:
        """The definition of a function."""
        if not function.body:
            return str(function.written(self)) if function.written else ""
        taken = self.needed.takes(function)
        self.begin(function)
        head = f"static {self.type(function.returns)} {function.name}({self.signature(taken)}) {{"
        body = self.statements(function.body, function, "return ")
        declared = self.declarations(function)
        return "\n".join([*self.said(function), head, *declared, *body, "}", ""])

    def entry(
        self,
        function: terms.Function,
        head: str,
        renamed: dict[str, str],
        own: dict[str, bool],
        ends: FunctionEnds,
    ) -> str:
        """A function that is called from outside; its value goes to ``*state``."""
        self.begin(function)
        self.renamed, self.pointers = renamed, self.pointers | own
        body = self.statements(function.body, function, "*state = ")
        lines = [*self.declarations(function), *ends.first, *body, *ends.last]
        return "\n".join([f"{head} {{", *lines, "}", ""])

    def begin(self, function: terms.Function) -> None:
        self.renamed = {}
        self.pointers = {name: isinstance(kind, terms.Record) for name, kind in function.parameters}

    def signature(self, taken: Sequence[tuple[str, terms.Type]]) -> str:
        return ", ".join(self.parameter(name, kind) for name, kind in taken) or "void"

    def parameter(self, name: str, kind: terms.Type) -> str:
        pointer = isinstance(kind, terms.Record)
        return f"const {self.type(kind)} *{name}" if pointer else f"{self.type(kind)} {name}"

    def declarations(self, function: terms.Function) -> list[str]:
        live = self.needed.locals[function]
        return [f"{self.type(kind)} {name};" for name, kind in function.locals.items() if name in live]

    def said(self, function: terms.Function) -> list[str]:
        text = first_paragraph(function.origin)
        return [comment(text).rstrip()] if text else []

    def statements(
        self, body: Sequence[terms.Statement], function: terms.Function, returned: str
    ) -> list[str]:
        lines: list[str] = []
        for one in body:
            if matters(one, self.needed.locals[function]):
                lines += self.statement(one, function, returned)
        return lines

    def statement(self, one: terms.Statement, function: terms.Function, returned: str) -> list[str]:
        def inner(body: Sequence[terms.Statement]) -> list[str]:
            return self.statements(body, function, returned)

        match one:
            case terms.Let(name=name, value=value):
                return [f"{self.let(name, value)};"]
            case terms.Assign(name=name, value=value):
                return [f"{name} = {self.value(value)};"]
            case terms.Return(value=value):
                return [f"{returned}{self.value(value)};"]
            case terms.If(condition=condition, body=body, otherwise=otherwise):
                lines, rest = [f"if ({self.value(condition)}) {{", *inner(body)], inner(otherwise)
                return [*lines, "} else {", *rest, "}"] if rest else [*lines, "}"]
            case terms.While(condition=condition, body=body):
                return [f"while ({self.value(condition)}) {{", *inner(body), "}"]
            case terms.For(body=body):
                return [f"{self.loop(one, one.name in self.needed.locals[function])} {{", *inner(body), "}"]
            case terms.Break():
                return ["break;"]
            case terms.Continue():
                return ["continue;"]
        raise AssertionError(one)

    def loop(self, loop: terms.For, read: bool) -> str:
        """The head of a loop; a number that nothing reads may be a short one."""
        ends = (loop.start, loop.stop)
        short = not read and all(isinstance(end, terms.Known) and abs(end.value) < SHORT for end in ends)
        start, stop = (
            self.value(end) if isinstance(end, terms.Expression) else whole_literal(end.value) for end in ends
        )
        name, by = loop.name, loop.step.value
        step = {1: f"{name}++", -1: f"{name}--"}.get(by, f"{name} {'+' if by > 0 else '-'}= {abs(by)}")
        kind = "int32_t" if short else "int64_t"
        return f"for ({kind} {name} = {start}; {name} {'<' if by > 0 else '>'} {stop}; {step})"

    def let(self, name: str, value: terms.Expression) -> str:
        """A local that never changes; of a record that stays where it is, only its address."""
        kind = self.type(value.type)
        if isinstance(value.type, terms.Record) and self.stays(value):
            self.pointers[name] = True
            return f"const {kind} *const {name} = {self.address(value)}"
        self.pointers[name] = False
        return f"const {kind} {name} = {self.value(value)}"

    def stays(self, value: terms.Expression) -> bool:
        """True for a record's place in one that does not change."""
        while isinstance(value, terms.Member):
            value = value.base
        return isinstance(value, terms.Variable) and not value.mutable

    # expressions

    def value(self, value: terms.Expression) -> str:
        return self.text(value)[0]

    def text(self, value: terms.Expression) -> tuple[str, int]:
        """The text of an expression and how strongly its last operator binds."""
        match value:
            case terms.Literal(value=number):
                return self.number(number)
            case terms.Whole(value=whole, type=kind):
                text = str(bool(whole)).lower() if kind == terms.BOOL else whole_literal(whole)
                return text, UNARY if text[0] == "-" else ATOM
            case terms.NamedNumber():
                return self.constant(value), ATOM
            case terms.Computed():
                return self.computed(value), ATOM
            case terms.Variable():
                name = self.renamed.get(value.name, value.name)
                return (f"*{name}", UNARY) if self.pointers.get(value.name) else (name, ATOM)
            case terms.Member():
                return self.place(value), ATOM
            case terms.Element(table=table, index=index):
                position = self.value(index) if isinstance(index, terms.Expression) else str(index.value)
                return f"{self.prefix}_{table.name}[{position}]", ATOM
            case terms.Unary(operator=sign, a=a):
                return f"{sign}{self.inner(a, UNARY)}", UNARY
            case terms.Conversion(a=a):
                return f"({self.real}){self.inner(a, UNARY)}", UNARY
            case terms.Operation(operator=sign, a=a, b=b):
                return self.operation(sign, a, b)
            case terms.Choice(condition=condition, a=a, b=b):
                parts = [self.inner(part, UNARY) for part in (condition, a, b)]
                return f"{parts[0]} ? {parts[1]} : {parts[2]}", CHOICE
            case terms.Call(function=function, arguments=arguments):
                return self.call(
                    function, list(map(self.argument, self.arguments_of(function, arguments)))
                ), ATOM
            case terms.Make(values=values):
                return self.made(value.type, values), ATOM  # type: ignore[arg-type]
        raise AssertionError(value)

    def inner(self, value: terms.Expression, level: int) -> str:
        text, binds = self.text(value)
        return text if binds > level or (binds == level == UNARY and text[0] == "*") else f"({text})"

    def operation(self, sign: str, a: terms.Expression, b: terms.Expression) -> tuple[str, int]:
        """Operands with operators of their own stand in brackets, but for the left one of the same."""
        sign = {"&": "&&", "|": "||"}.get(sign, sign)
        level = LEVELS.get(sign, COMPARED)
        left, binds = self.text(a)
        if a.type == terms.INT and is_short_whole(a) and is_short_whole(b):
            left, binds = f"(int64_t){self.inner(a, UNARY)}", UNARY
        chained = isinstance(a, terms.Operation) and a.operator == sign and sign in LEVELS
        left = left if binds >= UNARY or chained else f"({left})"
        right, binds = self.text(b)
        right = right if binds >= UNARY else f"({right})"
        return f"{left} {sign} {right}", level

    def call(self, function: terms.Function, arguments: Sequence[str]) -> str:
        library = not function.body and function.written is None
        name = f"{function.name}f" if library and self.real == "float" else function.name
        return f"{name}({', '.join(arguments)})"

    def argument(self, value: terms.Expression) -> str:
        return self.address(value) if isinstance(value.type, terms.Record) else self.value(value)

    def made(self, record: terms.Record, values: dict[str, terms.Expression]) -> str:
        return f"({self.type(record)}){{{', '.join(self.fields(record, values))}}}"

    def fields(self, record: terms.Record, values: dict[str, terms.Expression]) -> list[str]:
        return [f".{identifier(name)} = {self.value(values[name])}" for name, _ in self.kept(record)]

    def place(self, value: terms.Expression) -> str:
        """Where a record or a number of it is."""
        if isinstance(value, terms.Variable):
            return self.renamed.get(value.name, value.name)
        assert isinstance(value, terms.Member)
        direct = isinstance(value.base, terms.Variable) and self.pointers.get(value.base.name)
        return f"{self.place(value.base)}{'->' if direct else '.'}{identifier(value.name)}"

    def address(self, value: terms.Expression) -> str:
        if isinstance(value, terms.Variable) and self.pointers.get(value.name):
            return self.place(value)
        return f"&{self.place(value)}"

    # numbers

    def number(self, value: float) -> tuple[str, int]:
        """A literal that gives the very number."""
        if not math.isfinite(value):
            name = "NAN" if math.isnan(value) else "INFINITY"  # which C has as floats
            text = name if self.real == "float" else f"(double){name}"
            return f"-{text}" if math.copysign(1.0, value) < 0.0 else text, UNARY
        text = repr(float(value)) if self.real == "double" else f"{single_literal(value)}f"
        return text, UNARY if text[0] == "-" else ATOM

    def constant(self, value: terms.NamedNumber) -> str:
        """The name of a module's constant."""
        number = SINGLE.get((value.module, value.name), value.value) if self.real == "float" else value.value
        return self.named((value.module, value.name, value.value), module_file(value.module), number, "")

    def computed(self, value: terms.Computed) -> str:
        """The name of a number that was computed in place of a call."""
        return self.named(("", value.name, value.value), "", value.value, value.text)

    def named(self, key: tuple[str, str, float], file: str, number: float, text: str) -> str:
        """The name of a constant, which is given when it is first seen."""
        if key not in self.constants:
            wish = identifier("_".join(filter(None, (self.prefix, file, key[1])))).upper()
            given = {one.name for one in self.constants.values()}
            name = free_name(wish, given.__contains__)
            self.constants[key] = NamedConstant(name, self.number(number)[0], text)
        return self.constants[key].name


def is_short_whole(value: terms.Expression) -> bool:
    """True for a whole number that C computes with 32 bits, as it is made of short literals alone."""
    match value:
        case terms.Whole(value=whole):
            return abs(whole) < SHORT
        case terms.Unary(a=a):
            return is_short_whole(a)
        case terms.Choice(a=a, b=b):
            return is_short_whole(a) and is_short_whole(b)
    return False


def module_file(module: str) -> str:
    """The name of a module's file, as a plug-in's module has another one; else that of the module."""
    file = Path(getattr(sys.modules[module], "__file__", None) or "")
    own = file.suffix == ".py" and file.stem != "__init__"
    return file.stem if own else module.rpartition(".")[2]


def whole_literal(value: int) -> str:
    if abs(value) < SHORT:
        return str(int(value))
    return "INT64_MIN" if value < -LARGEST else f"INT64_C({value})"  # C has no literal of -2^63
