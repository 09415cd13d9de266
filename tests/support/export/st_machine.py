"""Runs Structured Text in Python: an evaluator of blark's trees, which knows nothing of what wrote the text.

Structures are copied wherever they are assigned or handed over, names have no case, divisions by zero give
what IEEE 754 says, and whole numbers that leave their 64 bits are errors.
"""

import copy
import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from typing import Any

import numpy as np
from blark import transform as tree
from blark.parse import parse_source_code

INDENT = "    "
OPERATORS = {"=": "==", "<>": "!="}
PYTHON = {"/": "divide", "MOD": "rest"}
ZEROS = {"LREAL": "0.0", "REAL": "np.float32(0.0)", "LINT": "0", "DINT": "0", "BOOL": "False"}
CONVERSIONS = {"LREAL": "float", "REAL": "np.float32", "LINT": "whole", "DINT": "whole", "BOOL": "truth"}
WHOLE = 2**63
Declared = tuple[str, str, str]  # name, type and first value


class Structure:
    """A structure's fields, as attributes."""


def divide(a: Any, b: Any) -> Any:
    if type(a) is int and type(b) is int:
        return whole(abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1))
    if b != 0.0:
        return a / b
    sign = math.copysign(1.0, a) * math.copysign(1.0, b)
    return type(a)(math.nan if a == 0.0 or math.isnan(a) else sign * math.inf)


def rest(a: int, b: int) -> int:
    return whole(a - b * divide(a, b))


def whole(value: Any) -> int:
    assert type(value) is int, f"{value!r} is not a whole number"
    assert -WHOLE <= value < WHOLE, f"{value} has more than 64 bits"
    return value


def truth(value: Any) -> bool:
    assert isinstance(value, bool | np.bool_), f"{value!r} is not a truth value"
    return bool(value)


def root(x: Any) -> Any:
    return np.sqrt(x) if isinstance(x, np.float32) else math.sqrt(x)


STANDARD = {
    "abs": abs,
    "sqrt": root,
    "sel": lambda g, a, b: b if g else a,
    "lint_to_lreal": float,
    "lint_to_real": np.float32,
    "lreal_to_lint": round,
    "real_to_lint": lambda x: round(float(x)),
    "divide": divide,
    "rest": rest,
    "whole": whole,
    "truth": truth,
    "np": np,
    "copied": copy.deepcopy,
    "Structure": Structure,
}


@cache
def parsed(text: str) -> Sequence[Any]:
    """The types, functions and function blocks of a text."""
    items: Sequence[Any] = parse_source_code(text).transform().items
    return items


class Machine:
    """The functions and function blocks of some texts."""

    def __init__(self, texts: Iterable[str]) -> None:
        items = [one for text in texts for one in parsed(text)]
        self.types = {
            str(one.declaration.name).casefold(): one.declaration
            for one in items
            if isinstance(one, tree.DataTypeDeclaration)
        }
        self.space: dict[str, Any] = dict(STANDARD)
        units = [one for one in items if isinstance(one, tree.Function | tree.FunctionBlock)]
        self.functions = {str(one.name).casefold() for one in units if isinstance(one, tree.Function)}
        self.blocks = {str(one.name).casefold() for one in units if isinstance(one, tree.FunctionBlock)}
        self.space |= {"space": self.space, "Block": Block}
        self.source = "\n".join(self.unit(one) for one in units)
        exec(compile(self.source, "<Structured Text>", "exec"), self.space)

    def block(self, name: str) -> "Block":
        """An instance of a function block."""
        return Block(self.space, f"{name.casefold()}_")

    def call(self, name: str, *given: Any) -> Any:
        """The value of a function."""
        return self.space[f"{name.casefold()}_"](*given)

    # declarations

    def unit(self, unit: Any) -> str:
        """A function, or the start and the body of a function block, as Python."""
        name = f"{str(unit.name).casefold()}_"
        inputs: list[Declared] = []
        variables: list[Declared] = []
        for section in unit.declarations:
            into = inputs if isinstance(section, tree.InputDeclarations) else variables
            into += [pair for item in section.items for pair in self.declared(item)]
        body = [f"{INDENT}{line}" for line in self.statements(unit.body.statements, returned=name)]
        if isinstance(unit, tree.Function):
            kind = str(unit.return_type.type.type).upper()
            head = f"def {name}({', '.join(own for own, _, _ in inputs)}):"
            given = [f"{INDENT}{own} = {self.converted(own, kind)}" for own, kind, _ in inputs]
            result = f"{INDENT}{name} = {self.zero(kind)}"
            own = [f"{INDENT}{one} = {start}" for one, _, start in variables]
            last = f"{INDENT}return {self.converted(name, kind)}"
            return "\n".join([head, *given, result, *own, *body, last, ""])
        names = [one for one, _, _ in (*inputs, *variables)]
        start = [f"{INDENT}self.{one} = {value}" for one, _, value in (*inputs, *variables)]
        before = [f"{INDENT}{one} = self.{one}" for one in names]
        after = [f"{INDENT}self.{one} = {one}" for one in names]
        return "\n".join(
            [f"def {name}start(self):", *start, f"def {name}(self):", *before, *body, *after, ""]
        )

    def declared(self, item: Any) -> Iterator[Declared]:
        """The name, type and first value of what an item declares."""
        for variable in item.variables:
            name = f"{str(variable.variable.name).casefold()}_"
            init = item.init
            if isinstance(init, tree.ArrayTypeInitialization):
                kind = str(init.spec.type.type_name)
                yield name, "ARRAY", self.array(init, kind)
            else:
                kind = str(init.spec.type).upper()
                value = None if init.value is None else self.converted(self.expression(init.value), kind)
                yield name, kind, self.zero(kind) if value is None else value

    def array(self, init: Any, kind: str) -> str:
        numbers = list(elements(init.value))
        (subrange,) = init.spec.subranges
        assert int(str(subrange.start.value)) == 0
        assert int(str(subrange.stop.value)) == len(numbers) - 1
        return f"[{', '.join(self.converted(self.expression(one), kind.upper()) for one in numbers)}]"

    def zero(self, kind: str) -> str:
        if kind.casefold() in self.blocks:
            return f"Block(space, {f'{kind.casefold()}_'!r})"
        if kind in ZEROS:
            return ZEROS[kind]
        fields = [
            f"{str(variable.variable.name).casefold()}_={self.zero(str(item.init.spec.type).upper())}"
            for item in self.types[kind.casefold()].declarations
            for variable in item.variables
        ]
        return f"made(Structure(), {', '.join(fields)})"

    def converted(self, text: str, kind: str) -> str:
        return f"{CONVERSIONS.get(kind, 'copied')}({text})"

    # statements

    def statements(self, body: Any, returned: str) -> list[str]:
        lines = [line for one in body for line in self.statement(one, returned)]
        return lines or ["pass"]

    def inner(self, body: Any, returned: str) -> list[str]:
        statements = body.statements if body is not None else []
        return [f"{INDENT}{line}" for line in self.statements(statements, returned)]

    def statement(self, one: Any, returned: str) -> list[str]:  # noqa: PLR0911 - a case for each statement
        match one:
            case tree.AssignmentStatement():
                value = f"copied({self.expression(one.expression)})"
                return [f"{self.expression(target)} = {value}" for target in one.variables]
            case tree.IfStatement():
                lines = [f"if {self.condition(one.if_expression)}:", *self.inner(one.statements, returned)]
                for other in one.else_ifs:
                    lines += [f"elif {self.condition(other.if_expression)}:"]
                    lines += self.inner(other.statements, returned)
                if one.else_clause is not None:
                    lines += ["else:", *self.inner(one.else_clause.statements, returned)]
                return lines
            case tree.WhileStatement():
                return [f"while {self.condition(one.expression)}:", *self.inner(one.statements, returned)]
            case tree.ForStatement():
                step = "1" if one.step is None else self.expression(one.step)
                start, to = self.expression(one.from_), self.expression(one.to)
                end = f"{to} + (1 if {step} > 0 else -1)"  # which belongs to the loop
                head = f"for {self.expression(one.control)} in range({start}, {end}, {step}):"
                return [head, *self.inner(one.statements, returned)]
            case tree.FunctionCallStatement():
                name = f"{str(one.name.name).casefold()}_"
                given = [(str(each.name.name), self.expression(each.value)) for each in one.parameters]
                return [*(f"{name}.set({own!r}, {value})" for own, value in given), f"{name}.call()"]
            case tree.ReturnStatement():
                return [f"return {returned}"]
            case tree.ExitStatement():
                return ["break"]
            case tree.ContinueStatement():
                return ["continue"]
        raise AssertionError(f"{one} is not known")

    # expressions

    def condition(self, one: Any) -> str:
        return f"truth({self.expression(one)})"

    def expression(self, one: Any) -> str:  # noqa: PLR0911 - a case for each expression
        match one:
            case tree.Boolean():
                return str(one.value).capitalize()
            case tree.Integer():
                return str(int(str(one.value)))
            case tree.Real():
                return str(one.value)
            case tree.ParenthesizedExpression():
                return f"({self.expression(one.expr)})"
            case tree.UnaryOperation():
                sign = "not truth" if str(one.op).upper() == "NOT" else str(one.op)
                return f"({sign}({self.expression(one.expr)}))"
            case tree.BinaryOperation():
                return self.operation(
                    str(one.op).upper(), self.expression(one.left), self.expression(one.right)
                )
            case tree.SimpleVariable():
                return f"{str(one.name).casefold()}_"
            case tree.MultiElementVariable():
                return self.place(one)
            case tree.FunctionCall():
                name = str(one.name.name).casefold()
                given = ", ".join(self.expression(each.value) for each in one.parameters)
                return f"{name}{'_' * (name in self.functions)}({given})"
        raise AssertionError(f"{one} is not known")

    def operation(self, sign: str, a: str, b: str) -> str:
        if sign in PYTHON:
            return f"{PYTHON[sign]}({a}, {b})"
        if sign in ("AND", "OR"):  # both sides are computed
            return f"(truth({a}) {'&' if sign == 'AND' else '|'} truth({b}))"
        return f"({a} {OPERATORS.get(sign, sign)} {b})"

    def place(self, one: Any) -> str:
        text = f"{str(one.name.name).casefold()}_"
        for element in one.elements:
            if isinstance(element, tree.FieldSelector):
                text += f".{str(element.field.name).casefold()}_"
            else:
                text += f"[{', '.join(map(self.expression, element.subscripts))}]"
        return text


class Block:
    """An instance of a function block: its variables by name, and one call after the other."""

    def __init__(self, space: dict[str, Any], name: str) -> None:
        self.body = space[name]
        space[f"{name}start"](self)

    def set(self, name: str, value: Any) -> None:
        assert hasattr(self, f"{name.casefold()}_"), name
        setattr(self, f"{name.casefold()}_", value)

    def get(self, place: str) -> Any:
        value: Any = self
        for name in place.split("."):
            value = getattr(value, f"{name.casefold()}_")
        return value

    def call(self) -> None:
        with np.errstate(all="ignore"):
            self.body(self)


def made(structure: Structure, **values: Any) -> Structure:
    vars(structure).update(values)
    return structure


STANDARD["made"] = made


def elements(init: Any) -> Iterator[Any]:
    """The elements of an array, which blark nests where one has a sign."""
    for one in init.elements:
        element = getattr(one, "element", one)
        if isinstance(element, tree.ArrayInitialization):
            yield from elements(element)
        else:
            yield element
