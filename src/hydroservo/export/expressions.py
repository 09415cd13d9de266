"""Translates expressions of Python."""

import ast
import inspect
import math
import operator
from collections.abc import Mapping, Sequence
from types import FunctionType, ModuleType
from typing import TYPE_CHECKING, Any

from hydroservo import ops
from hydroservo.export.bindings import bound_names
from hydroservo.export.names import identifier, snake
from hydroservo.export.scope import Scope, TranslationError, Value
from hydroservo.export.terms import (
    BOOL,
    INT,
    REAL,
    Bound,
    Call,
    Choice,
    Constant,
    Conversion,
    Element,
    Expression,
    Known,
    Literal,
    Make,
    Matrix,
    Member,
    Operation,
    Python,
    Record,
    Several,
    Table,
    Unary,
    Variable,
    Whole,
)
from hydroservo.ops import basic

if TYPE_CHECKING:
    from hydroservo.export.translate import Translator

__all__ = ["Expressions", "is_op"]

ARITHMETIC = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
WHOLE = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.Pow: operator.pow,
}
COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
COMPARE = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


class Expressions:
    """The expressions of one function."""

    def __init__(self, translator: "Translator", scope: Scope) -> None:
        self.translator, self.scope = translator, scope

    def expression(self, node: ast.expr) -> Value:
        match node:
            case ast.Constant(value=value):
                return self.constant(value, node)
            case ast.Name(id=name):
                return self.named(name, node)
            case ast.Attribute(value=value, attr=name):
                return self.attribute(self.expression(value), name, node)
            case ast.Call():
                return self.call(node)
            case ast.BinOp(left=left, op=op, right=right):
                return self.arithmetic(op, self.expression(left), self.expression(right), node)
            case ast.UnaryOp(op=op, operand=operand):
                return self.unary(op, operand, node)
            case ast.Compare() | ast.BoolOp():
                return self.condition(node)
            case ast.IfExp(test=test, body=body, orelse=otherwise):
                condition = self.condition(test)
                if isinstance(condition, Known):
                    return self.expression(body if condition.value else otherwise)
                return self.choice(condition, self.expression(body), self.expression(otherwise), node)
            case ast.Subscript(value=value, slice=index):
                return self.element(self.expression(value), index, node)
            case ast.Tuple(elts=elements):
                return self.several(elements)
        raise self.scope.error(f"{ast.unparse(node)!r} has no equal in C here", node)

    def several(self, elements: Sequence[ast.expr]) -> Several:
        names: list[str] = []
        for i, element in enumerate(elements):
            name = identifier(element.id) if isinstance(element, ast.Name) else f"value_{i + 1}"
            names.append(name if name not in names else f"value_{i + 1}")
        return Several(tuple(self.expression(element) for element in elements), tuple(names))

    def constant(self, value: object, node: ast.AST) -> Value:
        if isinstance(value, (bool, int)):
            return Known(value)
        if isinstance(value, float):
            return Literal(REAL, value)
        raise self.scope.error(f"{value!r} is neither a number nor a truth value", node)

    def named(self, name: str, node: ast.AST) -> Value:
        if name in self.scope.environment:
            value = self.scope.environment[name]
            if isinstance(value, Variable) and value.mutable and value.name not in self.scope.certain:
                raise self.scope.error(f"{name} may have no value yet", node, "give it one on every path")
            return value
        if name in self.scope.changing or name in bound_names(self.scope.tree):
            raise self.scope.error(f"{name} may have no value yet", node, "give it one on every path")
        namespace = self.scope.origin.__globals__
        builtins = vars(__import__("builtins"))
        if name in namespace:
            return self.python(namespace[name], name, self.scope.origin.__module__, node)
        if name in builtins:
            return Python(builtins[name])
        raise self.scope.error(f"{name} is not defined", node)

    def python(self, thing: Any, name: str, module: str, node: ast.AST) -> Value:
        """Something that a module holds."""
        if isinstance(thing, (bool, int)):
            return Known(thing)
        if isinstance(thing, float):
            special = not math.isfinite(thing)
            return Literal(REAL, thing) if special else Constant(REAL, module, name, thing)
        if callable(thing) or isinstance(thing, ModuleType):
            return Python(thing)
        raise self.scope.error(
            f"{name} is a {type(thing).__name__}, which a law cannot use", node, "use floats and blocks"
        )

    def attribute(self, base: Value, name: str, node: ast.AST) -> Value:
        if isinstance(base, Python):
            if not isinstance(base.thing, ModuleType) or not hasattr(base.thing, name):
                raise self.scope.error(f"{ast.unparse(node)} is not there", node)
            return self.python(getattr(base.thing, name), name, base.thing.__name__, node)
        if isinstance(base, Table) and name == "size":
            return Known(base.array.size)
        if isinstance(base, Expression) and isinstance(base.type, Record):
            if name in base.type.fields:
                return self.member(self.scope.lasting(base), name)
            method = vars(base.type.cls).get(name) if base.type.cls and name[0] != "_" else None
            if isinstance(method, FunctionType):
                return Bound(base, method)
            raise self.scope.error(f"{base.type.name} has neither a field nor a method {name!r}", node)
        raise self.scope.error(f"{ast.unparse(node)!r} has no equal in C", node)

    def member(self, base: Expression, name: str) -> Value:
        kind = base.type.fields[name]  # type: ignore[union-attr]
        return kind if isinstance(kind, (Known, Table)) else Member(kind, base, name)

    def element(self, table: Value, index: ast.expr, node: ast.AST) -> Value:
        if not isinstance(table, Table):
            raise self.scope.error("only the arrays of recorded signals can be indexed", node)
        parts = index.elts if isinstance(index, ast.Tuple) else [index]
        if len(parts) != table.array.ndim:
            raise self.scope.error(f"this array takes {table.array.ndim} indices", node)
        total: Value = Known(0)
        for part, length in zip(parts, table.array.shape, strict=True):
            found = self.expression(part)
            if isinstance(found, Known) and found.value < 0:
                found = Known(found.value + length)
            scaled = self.arithmetic(ast.Mult(), total, Known(length), node)
            total = found if scaled == Known(0) else self.arithmetic(ast.Add(), scaled, found, node)
        return Element(REAL, table, total)

    def arithmetic(self, op: ast.operator, a: Value, b: Value, node: ast.AST) -> Value:
        if isinstance(a, Known) and isinstance(b, Known) and type(op) in WHOLE:
            return Known(WHOLE[type(op)](a.value, b.value))
        if not isinstance(op, (ast.Div, ast.FloorDiv)) and self.whole(a) and self.whole(b):
            if type(op) not in ARITHMETIC:
                raise self.scope.error("this operation on whole numbers has no equal in C", node)
            return Operation(INT, ARITHMETIC[type(op)], self.integer(a), self.integer(b))
        if isinstance(op, ast.FloorDiv) and self.whole(a) and isinstance(b, Known) and b.value > 0:
            return Operation(INT, "/", self.integer(a), self.integer(b))  # of numbers that are not negative
        if isinstance(op, ast.Pow) and b == Known(2) and isinstance(a, Expression) and a.type == REAL:
            return Operation(REAL, "*", a, a)
        if type(op) not in ARITHMETIC:
            text = ast.unparse(ast.BinOp(ast.Name("a"), op, ast.Name("b")))
            raise self.scope.error(f"{text} of floats has no equal in C", node, "use ops.power or ops.floor")
        return Operation(REAL, ARITHMETIC[type(op)], self.real(a, node), self.real(b, node))

    def unary(self, op: ast.unaryop, operand: ast.expr, node: ast.AST) -> Value:
        if isinstance(op, ast.Not):
            condition = self.condition(operand)
            return Known(not condition.value) if isinstance(condition, Known) else Unary(BOOL, "!", condition)
        value = self.expression(operand)
        if isinstance(op, ast.USub):
            if isinstance(value, Known):
                return Known(-value.value)
            if isinstance(value, Literal):
                return Literal(REAL, -value.value)
            if isinstance(value, Expression) and value.type in (REAL, INT):
                return Unary(value.type, "-", value)
        raise self.scope.error(f"{ast.unparse(node)!r} has no equal in C", node)

    def condition(self, node: ast.expr) -> Expression | Known:
        """A truth value."""
        match node:
            case ast.Compare(left=left, ops=operators, comparators=rest):
                values = [self.expression(one) for one in (left, *rest)]
                pairs = zip(values, operators, values[1:], strict=False)
                return self.all_of([self.comparison(a, op, b, node) for a, op, b in pairs])
            case ast.BoolOp(op=ast.And(), values=parts):
                return self.all_of([self.condition(part) for part in parts])
            case ast.BoolOp(op=ast.Or(), values=parts):
                negated = [self.negated(self.condition(part)) for part in parts]
                if any(isinstance(one, Known) for one in negated):
                    return self.negated(self.all_of(negated))
                found = [self.condition(part) for part in parts]
                return self.joined("||", found)
        value = self.expression(node)
        if isinstance(value, Known) or (isinstance(value, Expression) and value.type == BOOL):
            return value
        raise self.scope.error(f"{ast.unparse(node)!r} is a number, not a truth value", node, "compare it")

    def comparison(self, a: Value, op: ast.cmpop, b: Value, node: ast.AST) -> Expression | Known:
        if type(op) not in COMPARISONS:
            raise self.scope.error("this comparison has no equal in C", node)
        sign = COMPARISONS[type(op)]
        if isinstance(a, Known) and isinstance(b, Known):
            return Known(COMPARE[sign](a.value, b.value))
        if self.whole(a) and self.whole(b):
            return Operation(BOOL, sign, self.integer(a), self.integer(b))
        return Operation(BOOL, sign, self.real(a, node), self.real(b, node))

    def all_of(self, conditions: Sequence[Expression | Known]) -> Expression | Known:
        if any(isinstance(one, Known) and not one.value for one in conditions):
            return Known(False)
        left = [one for one in conditions if isinstance(one, Expression)]
        return self.joined("&&", left) if left else Known(True)

    def joined(self, sign: str, conditions: Sequence[Any]) -> Expression:
        first, *rest = conditions
        for one in rest:
            first = Operation(BOOL, sign, first, one)
        return first  # type: ignore[no-any-return]

    def negated(self, condition: Expression | Known) -> Expression | Known:
        if isinstance(condition, Known):
            return Known(not condition.value)
        return Unary(BOOL, "!", condition)

    def choice(self, condition: Expression, a: Value, b: Value, node: ast.AST) -> Expression:
        first, second = self.runtime(a, node), self.runtime(b, node)
        if first.type != second.type:
            first, second = self.real(a, node), self.real(b, node)
        return Choice(first.type, condition, first, second)

    def whole(self, value: Value) -> bool:
        return isinstance(value, Known) or (isinstance(value, Expression) and value.type == INT)

    def integer(self, value: Value) -> Expression:
        return value if isinstance(value, Expression) else Whole(INT, value.value)  # type: ignore[union-attr]

    def real(self, value: Value, node: ast.AST) -> Expression:
        """A real number."""
        if isinstance(value, Known) and not isinstance(value.value, bool):
            return Literal(REAL, float(value.value))
        if isinstance(value, Expression) and value.type == REAL:
            return value
        if isinstance(value, Expression) and value.type == INT:
            return Conversion(REAL, value)
        raise self.scope.error("a number is needed here", node)

    def runtime(self, value: Value, node: ast.AST) -> Expression:
        """A value in C."""
        if isinstance(value, Expression):
            return value
        if isinstance(value, Known):
            return Whole(BOOL if isinstance(value.value, bool) else INT, value.value)
        raise self.scope.error("this is not a value in C", node)

    def call(self, node: ast.Call) -> Value:
        target = self.expression(node.func)
        if any(isinstance(one, ast.Starred) for one in node.args) or any(
            k.arg is None for k in node.keywords
        ):
            raise self.scope.error("arguments with * cannot be translated to C", node)
        given = [self.expression(one) for one in node.args]
        named = {str(one.arg): self.expression(one.value) for one in node.keywords}
        if isinstance(target, Bound):
            owner = self.scope.lasting(target.owner)
            return self.invoked(target.function, [owner, *given], named, owner.type.cls, node)  # type: ignore[union-attr]
        if not isinstance(target, Python):
            raise self.scope.error(f"{ast.unparse(node.func)} cannot be called", node)
        thing = target.thing
        if thing is basic.where:
            return self.where(given, node)
        if thing is float and len(given) == 1:
            return self.real(given[0], node)
        if isinstance(thing, type) and issubclass(thing, tuple) and hasattr(thing, "_fields"):
            return self.made(thing, given, named, node)
        if isinstance(thing, FunctionType) and (is_op(thing) or thing in self.translator.written):
            return self.invoked(thing, given, named, None, node)
        raise self.refused(thing, node)

    def refused(self, thing: Any, node: ast.Call) -> TranslationError:
        name = getattr(thing, "__name__", ast.unparse(node.func))
        text = ast.unparse(node.func)
        equal = {"fabs": "absolute", "abs": "absolute", "max": "maximum", "min": "minimum", "pow": "power"}
        equal |= {"exp": "power(math.e, x)"}
        same = equal.get(name, name)
        if same.partition("(")[0] in ops.__all__:
            return self.scope.error(f"{text} has no equal in C here", node, f"use ops.{same}")
        return self.scope.error(f"{text} has no equal in C here", node)

    def where(self, given: Sequence[Value], node: ast.AST) -> Value:
        if len(given) != 3:
            raise self.scope.error("where takes a condition and two values", node)
        condition, a, b = given
        if isinstance(condition, Known):
            return a if condition.value else b
        if not (isinstance(condition, Expression) and condition.type == BOOL):
            raise self.scope.error("where's condition is a number, not a truth value", node, "compare it")
        return self.choice(condition, a, b, node)

    def invoked(
        self, function: Any, given: Sequence[Value], named: Mapping[str, Value], owner: Any, node: ast.AST
    ) -> Expression:
        """A call of a function that is, or will be, in C."""
        signature = inspect.signature(function)
        try:
            bound = signature.bind(*given, **named)
        except TypeError as error:
            raise self.scope.error(f"{function.__qualname__}: {error}", node) from None
        values = []
        for name, parameter in signature.parameters.items():
            default = parameter.default
            value = bound.arguments.get(name)
            value = self.constant(default, node) if value is None else value
            wants_real = parameter.annotation is float and isinstance(value, Known)
            values.append(self.real(value, node) if wants_real else value)
        kinds = [value.type if isinstance(value, Expression) else value for value in values]
        if any(isinstance(kind, (Python, Bound, Several)) for kind in kinds):
            raise self.scope.error("an argument is not a value in C", node)
        callee = self.translator.function(function, kinds, owner)  # type: ignore[arg-type]
        arguments = [
            self.scope.lasting(value) if isinstance(value.type, (Record, Matrix)) else value
            for value in values
            if isinstance(value, Expression)
        ]
        return Call(callee.returns, callee, tuple(arguments))

    def made(self, cls: type, given: Sequence[Value], named: Mapping[str, Value], node: ast.AST) -> Make:
        """A record from positional and named fields."""
        names: tuple[str, ...] = cls._fields  # type: ignore[attr-defined]
        if len(given) > len(names) or not set(named) <= set(names[len(given) :]):
            raise self.scope.error(f"{cls.__name__} does not take these fields", node, "give each field once")
        values: dict[str, Expression] = {}
        found = dict(zip(names, given, strict=False)) | dict(named)
        for name in names:
            if name not in found:
                raise self.scope.error(f"{cls.__name__} is given no {name}", node, "give every field")
            value = found[name]
            values[name] = self.real(value, node) if isinstance(value, Known) else self.runtime(value, node)
        kinds = {name: value.type for name, value in values.items()}
        record = self.translator.record(cls, kinds, snake(cls.__name__))
        return Make(record, values)


def is_op(function: Any) -> bool:
    """True for the functions of ops."""
    return str(getattr(function, "__module__", "")).startswith("hydroservo.ops")
