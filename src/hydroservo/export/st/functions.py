"""Writes a translated function as Structured Text.

Where C has an expression and Structured Text has none, for a record from its fields and for a choice of which
one side is computed, statements stand before it.
"""

import inspect
from collections.abc import Callable, Sequence
from itertools import starmap

import numpy as np

from hydroservo.export.layout import INDENT, ST, split_statement
from hydroservo.export.st.names import unused_name
from hydroservo.export.st.numbers import literal_of
from hydroservo.export.st.pou import Declaration, Pou, note
from hydroservo.export.st.primitives import NO_ARGUMENT
from hydroservo.export.st.writer import ATOM, UNARY, STWriter
from hydroservo.language.liveness import matters
from hydroservo.language.scope import TranslationError
from hydroservo.language.terms import (
    BOOL,
    INT,
    REAL,
    Assign,
    Break,
    Call,
    Choice,
    Computed,
    ConstantArray,
    Continue,
    Conversion,
    Element,
    Expression,
    For,
    Function,
    If,
    Let,
    Literal,
    Make,
    Member,
    NamedNumber,
    Operation,
    Record,
    Return,
    Statement,
    Type,
    Unary,
    Variable,
    While,
    Whole,
)

PRODUCT, SUM, COMPARED, AND, OR = 5, 4, 3, 2, 1
SIGNS = {"&&": "AND", "||": "OR", "&": "AND", "|": "OR", "==": "=", "!=": "<>"}
LEVELS = {"*": PRODUCT, "/": PRODUCT, "+": SUM, "-": SUM, "AND": AND, "OR": OR}


def function_of(writer: STWriter, function: Function) -> Pou | None:
    """The definition of a function; none of a primitive, which is written once it is known to be used."""
    if not function.body:
        writer.primitive(function.name)
        return None
    return FunctionText(writer, function).pou()


class FunctionText:
    """The text of one function."""

    def __init__(self, writer: STWriter, function: Function) -> None:
        self.writer, self.function = writer, function
        self.name = writer.function_name(function)
        self.taken = {*writer.taken, self.name.casefold()}
        self.names: dict[str, str] = {}
        self.inputs: dict[str, str] = {}  # types by the name written
        self.locals: dict[str, str] = {}
        self.constants: dict[object, Declaration] = {}
        self.lines: list[str] = []
        self.depth = 0

    def pou(self) -> Pou:
        """The function's definition."""
        function, writer = self.function, self.writer
        for name, kind in writer.needed.takes(function):
            self.inputs[self.new(name)] = writer.type(kind)
        live = writer.needed.locals[function]
        for name, kind in function.locals.items():
            if name in live:
                self.local(name, kind)
        self.statements(function.body, last=True)
        about = (inspect.getdoc(function.origin) or "").partition("\n\n")[0] if function.origin else ""
        sections = {
            "VAR_INPUT": list(starmap(Declaration, (self.inputs or {NO_ARGUMENT: "BOOL"}).items())),
            "VAR": list(starmap(Declaration, self.locals.items())),
            "VAR CONSTANT": list(
                self.constants.values()
            ),  # last: a compiler takes all behind them for constants
        }
        return Pou(self.name, writer.type(function.returns), about, sections, self.lines)

    # names

    def new(self, name: str) -> str:
        """The name written for a name of the terms, from now on."""
        self.names[name] = unused_name(name, self.taken)
        return self.names[name]

    def local(self, name: str, kind: Type) -> str:
        """A variable of a type; one that is there already if it has that type."""
        written = self.names.get(name)
        if written is None or self.locals.get(written) != self.writer.type(kind):
            written = self.new(name)
            self.locals[written] = self.writer.type(kind)
        return written

    def temporary(self, kind: Type, name: str) -> str:
        """A variable for a value that takes statements of its own."""
        written = unused_name(name, self.taken)
        self.locals[written] = self.writer.type(kind)
        return written

    def named(self, key: object, constant: Declaration) -> str:
        """The name of a constant of the function."""
        if key not in self.constants:
            self.constants[key] = constant._replace(name=unused_name(constant.name, self.taken))
        return self.constants[key].name

    # statements

    def emit(self, text: str) -> None:
        self.lines += split_statement(text, INDENT * self.depth, ST)

    def nested(self, body: Sequence[Statement], last: bool = False) -> None:
        self.depth += 1
        self.statements(body, last)
        self.depth -= 1

    def statements(self, body: Sequence[Statement], last: bool = False) -> None:
        """Statements; the function ends behind the last of them where they are its own."""
        written = self.written(body)
        for one in written:
            self.statement(one, last and one is written[-1])

    def written(self, body: Sequence[Statement]) -> list[Statement]:
        """The statements that matter."""
        live = self.writer.needed.locals[self.function]
        return [one for one in body if matters(one, live)]

    def statement(self, one: Statement, last: bool) -> None:
        match one:
            case Let(name=name, value=value):
                target = self.local(name, value.type)
                self.assign(target, value, fresh=True)
            case Assign(name=name, value=value):
                self.assign(self.names[name], value)
            case Return(value=value):
                self.returned(value, last)
            case If():
                self.branches(one, last)
            case While(condition=condition, body=body):
                self.loop(condition, body)
            case For():
                self.counted(one)
            case Break():
                self.emit("EXIT;")
            case Continue():
                self.emit("CONTINUE;")
            case _:
                raise AssertionError(one)

    def returned(self, value: Expression, last: bool) -> None:
        """The end of a function; its value's fields go through a variable, as some compilers ask for."""
        if isinstance(value, Choice):
            self.choice(value, lambda one: self.returned(one, last))
            return
        if isinstance(value, Make):
            value = Variable(value.type, self.made(value, "result"))
            self.names[value.name] = value.name
        self.emit(f"{self.name} := {self.value(value)};")
        if not last:
            self.emit("RETURN;")

    def branches(self, one: If, last: bool, word: str = "IF") -> None:
        """Statements under conditions; one alone in an ELSE makes it ELSIF."""
        self.emit(f"{word} {self.value(one.condition)} THEN")
        self.nested(one.body, last)
        otherwise = self.written(one.otherwise)
        match otherwise:
            case [If() as only] if self.is_simple(only.condition):
                self.branches(only, last, "ELSIF")
                return
            case [_, *_]:
                self.emit("ELSE")
                self.nested(otherwise, last)
        self.emit("END_IF;")

    def loop(self, condition: Expression, body: Sequence[Statement]) -> None:
        """A loop; what its condition takes of statements is done again at each turn."""
        before, self.lines = self.lines, []
        self.depth += 1
        test = self.value(condition)
        self.depth -= 1
        computed, self.lines = self.lines, before
        self.emit(f"WHILE {'TRUE' if computed else test} DO")
        if computed:
            self.lines += computed
            self.depth += 1
            self.emit(f"IF NOT ({test}) THEN")
            self.emit(f"{INDENT}EXIT;")
            self.emit("END_IF;")
            self.depth -= 1
        self.nested(body)
        self.emit("END_WHILE;")

    def counted(self, loop: For) -> None:
        """A loop over whole numbers, whose end is part of it."""
        name, by = self.local(loop.name, INT), loop.step.value
        start, stop = (self.whole(end) for end in (loop.start, loop.stop))
        known = stop.lstrip("-").isdigit()
        end = str(int(stop) - (1 if by > 0 else -1)) if known else f"{stop} {'-' if by > 0 else '+'} 1"
        step = "" if by == 1 else f" BY {by}"
        self.emit(f"FOR {name} := {start} TO {end}{step} DO")
        self.nested(loop.body)
        self.emit("END_FOR;")

    def whole(self, end: object) -> str:
        return self.inner(end, UNARY) if isinstance(end, Expression) else str(end.value)  # type: ignore[attr-defined]

    def assign(self, target: str, value: Expression, fresh: bool = False) -> None:
        """A value for a variable; nothing of it reads one that is fresh."""
        if isinstance(value, Choice):
            self.choice(value, lambda one: self.assign(target, one, fresh))
        elif isinstance(value, Make) and fresh:
            self.fill(target, value)
        else:
            self.emit(f"{target} := {self.value(value)};")

    def fill(self, target: str, value: Make) -> None:
        """The fields of a record, one after the other."""
        assert isinstance(value.type, Record)
        for name, _ in self.writer.kept(value.type):
            place, part = f"{target}.{self.writer.member(value.type, name)}", value.values[name]
            self.assign(place, part, fresh=True)

    def choice(self, value: Choice, use: Callable[[Expression], None]) -> None:
        """One of several values, of which only that one is computed."""
        word, other = "IF", value
        while isinstance(other, Choice) and (word == "IF" or self.is_simple(other.condition)):
            self.emit(f"{word} {self.value(other.condition)} THEN")
            self.depth += 1
            use(other.a)
            self.depth -= 1
            word, other = "ELSIF", other.b  # type: ignore[assignment]
        self.emit("ELSE")
        self.depth += 1
        use(other)
        self.depth -= 1
        self.emit("END_IF;")

    def is_simple(self, value: Expression) -> bool:
        """True for what takes no statements of its own."""
        before, depth = self.lines, self.depth
        names, locals_, taken = dict(self.names), dict(self.locals), set(self.taken)
        self.lines = []
        self.value(value)
        simple = not self.lines
        self.lines, self.depth = before, depth
        if not simple:
            self.names, self.locals, self.taken = names, locals_, taken
        return simple

    def made(self, value: Make, name: str) -> str:
        """A variable with a record's fields."""
        target = self.temporary(value.type, name)
        self.fill(target, value)
        return target

    # expressions

    def value(self, value: Expression) -> str:
        return self.expression(value)[0]

    def inner(self, value: Expression, level: int) -> str:
        text, binds = self.expression(value)
        return text if binds > level else f"({text})"

    def expression(self, value: Expression) -> tuple[str, int]:
        """The text of an expression and how strongly its last operator binds."""
        match value:
            case Literal(value=number):
                return self.writer.number(number)
            case Whole(value=whole, type=kind):
                text = str(bool(whole)).upper() if kind == BOOL else str(int(whole))
                return text, UNARY if text[0] == "-" else ATOM
            case NamedNumber(name=name) | Computed(name=name):
                return self.constant(value, name)
            case Variable(name=name):
                return self.names[name], ATOM
            case Member(base=base, name=name):
                assert isinstance(base.type, Record)
                return f"{self.value(base)}.{self.writer.member(base.type, name)}", ATOM
            case Element(table=table, index=index):
                position = self.value(index) if isinstance(index, Expression) else str(index.value)
                return f"{self.table(table)}[{position}]", ATOM
            case Unary(operator=sign, a=a):
                return f"{'NOT ' if sign == '!' else sign}{self.inner(a, UNARY)}", UNARY
            case Conversion(a=a, type=kind):
                return self.conversion(a, kind), ATOM
            case Operation(operator=sign, a=a, b=b):
                return self.operation(SIGNS.get(sign, sign), a, b)
            case Choice():
                return self.chosen(value), ATOM
            case Call(function=function, arguments=arguments):
                return self.call(function, arguments), ATOM
            case Make():
                assert isinstance(value.type, Record)
                return self.made(value, value.type.name), ATOM
        raise AssertionError(value)

    def constant(self, value: NamedNumber | Computed, name: str) -> tuple[str, int]:
        """A named number: a constant of the function, or what it takes where there is no literal of it."""
        number = self.writer.constant(value)
        text, binds = self.writer.number(number)
        if text.endswith(")"):  # no literal
            return text, binds
        said = value.text if isinstance(value, Computed) else ""
        constant = Declaration(name.upper(), self.writer.real, note("", said), text)
        return self.named((name, number), constant), ATOM

    def table(self, table: ConstantArray) -> str:
        """A recorded signal's numbers, a constant of the function."""
        numbers = [self.writer.number(float(one))[0] for one in np.ravel(table.array)]
        if not all(literal_of(one, self.writer.real) for one in np.ravel(table.array).tolist()):
            raise TranslationError(f"{table.name}: a table of Structured Text holds numbers of 1e-37 to 1e38")
        return self.named(
            table, Declaration(table.name.upper(), self.writer.real, "", numbers, length=len(numbers))
        )

    def conversion(self, a: Expression, kind: Type) -> str:
        """A whole number as a real one, or the other way round."""
        if kind == INT and a.type == REAL:
            return f"{self.writer.primitive('truncated')}({self.value(a)})"
        if a.type == BOOL:
            one, none = ("1.0", "0.0") if kind == REAL else ("1", "0")
            return f"SEL({self.value(a)}, {none}, {one})"
        return f"LINT_TO_{self.writer.real}({self.value(a)})" if kind == REAL else self.value(a)

    def operation(self, sign: str, a: Expression, b: Expression) -> tuple[str, int]:
        """Operands with operators of their own stand in brackets, but for the left one of the same."""
        level = LEVELS.get(sign, COMPARED)
        left, binds = self.expression(a)
        chained = isinstance(a, Operation) and SIGNS.get(a.operator, a.operator) == sign and sign in LEVELS
        left = left if binds >= UNARY or chained else f"({left})"
        return f"{left} {sign} {self.inner(b, UNARY)}", level

    def chosen(self, value: Choice) -> str:
        """A choice within an expression: SEL of two numbers that Python computes; else a variable."""
        if value.both and not isinstance(value.type, Record):
            condition, a, b = (self.value(one) for one in (value.condition, value.a, value.b))
            return f"SEL({condition}, {b}, {a})"
        target = self.temporary(value.type, "choice")
        self.assign(target, value, fresh=True)
        return target

    def call(self, function: Function, arguments: Sequence[Expression]) -> str:
        taken = {name for name, _ in self.writer.needed.takes(function)}
        pairs = zip(function.parameters, arguments, strict=True)
        texts = [self.value(one) for (name, _), one in pairs if name in taken]
        return f"{self.writer.function_name(function)}({', '.join(texts) or 'FALSE'})"
