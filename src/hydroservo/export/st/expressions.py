"""Writes the expressions of one function as Structured Text.

Where C has an expression and Structured Text has none, for a record from its fields and for a choice of which
one side is computed, statements stand before it.
"""

from collections.abc import Iterator
from functools import cache

from hydroservo.export.layout import INDENT, ST, split_statement
from hydroservo.export.st.names import literal_of, unused_name
from hydroservo.export.st.pou import Declaration, remark
from hydroservo.export.st.primitives import NO_ARGUMENT
from hydroservo.export.st.writer import ATOM, UNARY, STWriter
from hydroservo.language import terms
from hydroservo.language.constants import value_in
from hydroservo.language.scope import TranslationError

PRODUCT, SUM, COMPARED, AND, OR = 5, 4, 3, 2, 1
SIGNS = {
    "*": "*",
    "/": "/",
    "+": "+",
    "-": "-",
    "<": "<",
    "<=": "<=",
    ">": ">",
    ">=": ">=",
    "==": "=",
    "!=": "<>",
}
LOGICAL = {"&&": "AND", "&": "AND", "||": "OR", "|": "OR"}
OPPOSITE = {"&&": "||", "&": "|", "||": "&&", "|": "&"}  # as one compiler has no NOT of AND and OR
LEVELS = {"*": PRODUCT, "/": PRODUCT, "+": SUM, "-": SUM, "AND": AND, "OR": OR}


class ExpressionWriter:
    """The texts of one function's expressions, its variables, and the statements written so far."""

    def __init__(self, writer: STWriter, name: str) -> None:
        self.writer = writer
        self.taken = {*writer.taken, name.casefold(), NO_ARGUMENT}
        self.names: dict[str, str] = {}  # written, by those of the terms
        self.locals: dict[str, str] = {}  # types by the name written
        self.constants: dict[object, Declaration] = {}
        self.lines: list[str] = []
        self.depth = 0

    # names

    def new_name(self, name: str) -> str:
        """The name written for a name of the terms, from now on."""
        self.names[name] = unused_name(name, self.taken)
        return self.names[name]

    def variable(self, name: str, kind: terms.Type) -> str:
        """A variable of a type; one that is there already if it has that type."""
        name_written = self.names.get(name)
        if name_written is None or self.locals.get(name_written) != self.writer.type(kind):
            name_written = self.new_name(name)
            self.locals[name_written] = self.writer.type(kind)
        return name_written

    def temporary(self, kind: terms.Type, name: str) -> str:
        """A variable for a value that takes statements of its own."""
        name_written = unused_name(name, self.taken)
        self.locals[name_written] = self.writer.type(kind)
        return name_written

    def constant_name(self, key: object, constant: Declaration) -> str:
        if key not in self.constants:
            self.constants[key] = constant._replace(name=unused_name(constant.name, self.taken))
        return self.constants[key].name

    # statements that expressions need

    def emit(self, text: str) -> None:
        self.lines += split_statement(text, INDENT * self.depth, ST)

    def assign(self, target: str, value: terms.Expression, fresh: bool = False) -> None:
        """A value for a variable; nothing of it reads one that is fresh."""
        raise NotImplementedError

    def fill(self, target: str, value: terms.Make) -> None:
        """The fields of a record, one after the other."""
        assert isinstance(value.type, terms.Record)
        for name, _ in self.writer.kept(value.type):
            place, part = f"{target}.{self.writer.member(value.type, name)}", value.values[name]
            self.assign(place, part, fresh=True)

    def record_variable(self, value: terms.Make, name: str) -> str:
        """A variable with a record's fields."""
        target = self.temporary(value.type, name)
        self.fill(target, value)
        return target

    # expressions

    def value(self, value: terms.Expression) -> str:
        return self.expression(value)[0]

    def operand(self, value: terms.Expression, level: int) -> str:
        """An operand, in brackets unless it binds more strongly; whole numbers with their type."""
        if isinstance(value, terms.Whole) and value.type == terms.INT:
            return f"LINT#{value.value}" if value.value >= 0 else f"(-LINT#{-value.value})"
        text, binds = self.expression(value)
        return text if binds > level else f"({text})"

    def expression(self, value: terms.Expression) -> tuple[str, int]:
        """The text of an expression and how strongly its last operator binds."""
        match value:
            case terms.Literal(value=number):
                return self.writer.number(number)
            case terms.Whole(value=whole, type=kind):
                text = str(bool(whole)).upper() if kind == terms.BOOL else str(int(whole))
                return text, UNARY if text[0] == "-" else ATOM
            case terms.NamedNumber(name=name) | terms.Computed(name=name):
                return self.constant(value, name)
            case terms.Variable(name=name):
                return self.names[name], ATOM
            case terms.Member(base=base, name=name):
                assert isinstance(base.type, terms.Record)
                return f"{self.value(base)}.{self.writer.member(base.type, name)}", ATOM
            case terms.Element(table=table, index=index):
                position = self.value(index) if isinstance(index, terms.Expression) else str(index.value)
                return f"{self.table(table)}[{position}]", ATOM
            case terms.Unary(operator="!", a=terms.Operation(operator=sign, a=a, b=b)) if sign in LOGICAL:
                return self.operation(terms.Operation(terms.BOOL, OPPOSITE[sign], opposite(a), opposite(b)))
            case terms.Unary(operator=sign, a=a):
                return f"{'NOT ' if sign == '!' else sign}{self.operand(a, UNARY)}", UNARY
            case terms.Conversion(a=a, type=kind):
                real = self.writer.real
                name = f"LINT_TO_{real}" if kind == terms.REAL else self.writer.primitive("truncated")
                return f"{name}({self.value(a)})", ATOM
            case terms.Operation():
                return self.operation(value)
            case terms.Choice():
                return self.choice_value(value), ATOM
            case terms.Call(function=function):
                return f"{self.writer.function_name(function)}({self.arguments(value)})", ATOM
            case terms.Make():
                assert isinstance(value.type, terms.Record)
                return self.record_variable(value, value.type.name), ATOM
        raise AssertionError(value)

    def constant(self, value: terms.NamedNumber | terms.Computed, name: str) -> tuple[str, int]:
        """A named number: a constant of the function, or a call where there is no literal of it."""
        number = self.writer.constant(value)
        if not (text := literal_of(number, self.writer.real)):
            return self.writer.number(number)
        about = value.text if isinstance(value, terms.Computed) else ""
        constant = Declaration(name.upper(), self.writer.real, remark("", about), text)
        return self.constant_name((name, number), constant), ATOM

    def table(self, table: terms.ConstantArray) -> str:
        """A recorded signal's numbers, a constant of the function."""
        numbers = [literal_of(one, self.writer.real) for one in table.array.ravel().tolist()]
        if not all(numbers):
            sizes = "0, or sizes from 1.2e-38 to 1.7e38"
            raise TranslationError(f"{table.name}: a table in Structured Text may hold {sizes}")
        array = Declaration(table.name.upper(), self.writer.real, "", numbers, length=len(numbers))
        return self.constant_name(table, array)

    def operation(self, value: terms.Operation) -> tuple[str, int]:
        """Operands with operators of their own stand in brackets, but for the left one of the same."""
        a, b = value.a, value.b
        sign = (LOGICAL if a.type == terms.BOOL and value.operator in LOGICAL else SIGNS).get(value.operator)
        if sign is None:
            raise TranslationError(f"the operator {value.operator} has no Structured Text")
        if value.operator in ("&&", "||") and may_stop(b):  # AND and OR may compute both sides
            shown = (b, terms.Whole(terms.BOOL, 0)) if sign == "AND" else (terms.Whole(terms.BOOL, 1), b)
            return self.choice_value(terms.Choice(terms.BOOL, a, *shown)), ATOM
        chained = isinstance(a, terms.Operation) and a.operator == value.operator and sign in LEVELS
        left = self.value(a) if chained else self.operand(a, UNARY - 1)
        return f"{left} {sign} {self.operand(b, UNARY)}", LEVELS.get(sign, COMPARED)

    def choice_value(self, value: terms.Choice) -> str:
        """A choice within an expression: SEL of two numbers that Python computes; else a variable."""
        if takes_statements(value):
            target = self.temporary(value.type, "choice")
            self.assign(target, value, fresh=True)
            return target
        return f"SEL({self.value(value.condition)}, {self.operand(value.b, 0)}, {self.operand(value.a, 0)})"

    def arguments(self, call: terms.Call) -> str:
        """What a function takes of a call's arguments."""
        return ", ".join(map(self.value, self.writer.arguments_of(call.function, call.arguments))) or "FALSE"


def opposite(value: terms.Expression) -> terms.Unary:
    """NOT of a truth value."""
    return terms.Unary(terms.BOOL, "!", value)


def takes_statements(value: terms.Choice) -> bool:
    """True for a choice that SEL does not make: Python computes one side, or it is a record."""
    return not value.both or isinstance(value.type, terms.Record)


def is_simple(value: terms.Expression) -> bool:
    """True for an expression that no statements stand before."""
    return not any(
        isinstance(part, terms.Make)
        or (isinstance(part, terms.Choice) and takes_statements(part))
        or (isinstance(part, terms.Operation) and part.operator in ("&&", "||") and may_stop(part.b))
        for part in expressions_in(value)
    )


def expressions_in(value: terms.Expression) -> Iterator[terms.Expression]:
    """An expression and all that it is made of."""
    yield value
    for part in terms.operands(value):
        yield from expressions_in(part)


def may_stop(value: terms.Expression) -> bool:
    """True for an expression that divides or may take long, so that a guard before it must hold."""
    return any(
        (isinstance(part, terms.Operation) and part.operator == "/")
        or (isinstance(part, terms.Choice) and takes_statements(part))
        or (isinstance(part, terms.Call) and function_may_stop(part.function))
        for part in expressions_in(value)
    )


@cache
def function_may_stop(function: terms.Function) -> bool:
    """True for a function that divides or may take long."""
    return any(map(statement_may_stop, function.body))


def statement_may_stop(statement: terms.Statement) -> bool:
    if isinstance(statement, terms.While):
        return True
    value = value_in(statement)
    own = isinstance(value, terms.Expression) and may_stop(value)
    return own or any(statement_may_stop(one) for body in terms.bodies(statement) for one in body)
