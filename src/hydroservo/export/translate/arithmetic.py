"""Translates operators: what is known while translating is computed, all else becomes an operation in C."""

import ast
import operator
from collections.abc import Callable, Sequence
from typing import Any

from hydroservo.export.translate.ranges import LARGEST, LARGEST_REAL
from hydroservo.export.translate.scope import WAY_OUT, Scope, TranslationError, Value, whole
from hydroservo.export.translate.terms import (
    BOOL,
    INT,
    REAL,
    Call,
    Choice,
    Conversion,
    Expression,
    Function,
    Known,
    Literal,
    Member,
    Operation,
    Unary,
    Variable,
    Whole,
)

SIGNS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
FOLDED: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.Pow: operator.pow,
}
MOST_BITS = 64  # that a shift or power of known numbers may reach, lest it fill the memory
COMPARISONS: dict[type[ast.cmpop], tuple[str, Callable[[Any, Any], bool]]] = {
    ast.Lt: ("<", operator.lt),
    ast.LtE: ("<=", operator.le),
    ast.Gt: (">", operator.gt),
    ast.GtE: (">=", operator.ge),
    ast.Eq: ("==", operator.eq),
    ast.NotEq: ("!=", operator.ne),
}
QUOTIENT_TEXT = """\
/* The largest whole number not above a/b, for b > 0. */
static int64_t ops_quotient(int64_t a, int64_t b) {
    return ((a % b) < 0) ? ((a / b) - 1) : (a / b);
}
"""
QUOTIENT = Function("ops_quotient", [("a", INT), ("b", INT)], returns=INT, written=lambda _: QUOTIENT_TEXT)


class Arithmetic:
    """The operators of one function.

    Every method raises :class:`TranslationError` where C has no equal.
    """

    def __init__(self, scope: Scope) -> None:
        self.scope = scope

    def binary(self, op: ast.operator, a: Value, b: Value, node: ast.AST) -> Value:
        """a op b."""
        if isinstance(a, Known) and isinstance(b, Known):
            return self.folded(op, a, b, node)
        if isinstance(op, ast.FloorDiv) and self.whole(a) and isinstance(b, Known) and b.value > 0:
            return Call(INT, QUOTIENT, (self.integer(a, node), self.integer(b, node)))
        if not isinstance(op, ast.Div) and self.whole(a) and self.whole(b):
            return self.whole_numbers(op, a, b, node)
        if type(op) not in SIGNS:
            way_out = {ast.Pow: "write x * x, or use ops.power", ast.FloorDiv: "use ops.floor(a / b)"}
            way_out[ast.Mod] = "use a - b * ops.floor(a / b)"
            text = ast.unparse(ast.BinOp(ast.Name("a"), op, ast.Name("b")))
            raise self.error(f"{text} of floats has no equal in C", node, way_out.get(type(op)))
        return Operation(REAL, SIGNS[type(op)], self.real(a, node), self.real(b, node))

    def folded(self, op: ast.operator, a: Known, b: Known, node: ast.AST) -> Value:
        """An operation of numbers that are both known."""
        if isinstance(op, (ast.Pow, ast.LShift)) and abs(b.value) > MOST_BITS:
            raise self.error(f"a number of more than {MOST_BITS} bits", node)
        try:
            found = FOLDED[type(op)](a.value, b.value)
        except (KeyError, ArithmeticError, ValueError) as error:
            raise self.error(f"{ast.unparse(node)!r} has no equal in C: {error}", node) from None
        return Known(found) if isinstance(found, int) else Literal(REAL, float(found))

    def whole_numbers(self, op: ast.operator, a: Value, b: Value, node: ast.AST) -> Expression:
        """An operation of whole numbers that are not both known; they have 64 bits in C."""
        if type(op) not in SIGNS:
            raise self.error("this operation on whole numbers has no equal in C", node)
        found = Operation(INT, SIGNS[type(op)], self.integer(a, node), self.integer(b, node))
        self.scope.limit(found, LARGEST, node)
        return found

    def negative(self, value: Value, node: ast.AST) -> Value:
        """-a."""
        if isinstance(value, Known):
            return Known(-value.value)
        if isinstance(value, Literal):
            return Literal(REAL, -value.value)
        if isinstance(value, Expression) and value.type in (REAL, INT):
            return Unary(value.type, "-", value)
        raise self.error(f"{ast.unparse(node)!r} has no equal in C", node)

    def comparison(self, a: Value, op: ast.cmpop, b: Value, node: ast.AST) -> Expression | Known:
        """a < b and its like."""
        if type(op) not in COMPARISONS:
            raise self.error("this comparison has no equal in C", node)
        sign, compare = COMPARISONS[type(op)]
        if isinstance(a, Known) and isinstance(b, Known):
            return Known(compare(a.value, b.value))
        if self.whole(a) and self.whole(b):
            first, second = self.integer(a, node), self.integer(b, node)
            same = equal(first, second)  # which C compilers complain of
            return Known(compare(0, 0)) if same else Operation(BOOL, sign, first, second)
        return Operation(BOOL, sign, self.real(a, node), self.real(b, node))

    def joined(self, sign: str, conditions: Sequence[Expression | Known]) -> Expression | Known:
        """Truth values joined by && or ||; the known ones decide or are left out."""
        decisive = sign == "||"
        if any(isinstance(one, Known) and one.value == decisive for one in conditions):
            return Known(decisive)
        left = [one for one in conditions if isinstance(one, Expression)]
        if not left:
            return Known(not decisive)
        first, *rest = left
        for one in rest:
            first = Operation(BOOL, sign, first, one)
        return first

    def negated(self, condition: Expression | Known) -> Expression | Known:
        """not a."""
        return Known(not condition.value) if isinstance(condition, Known) else Unary(BOOL, "!", condition)

    def choice(self, condition: Expression, a: Value, b: Value, node: ast.AST) -> Expression:
        """a if the condition holds, else b."""
        first, second = self.alike(a, b, node)
        return Choice(first.type, condition, first, second)

    def alike(self, a: Value, b: Value, node: ast.AST) -> tuple[Expression, Expression]:
        """Two values of one type."""
        first, second = self.runtime(a, node), self.runtime(b, node)
        if {first.type, second.type} == {REAL, INT}:  # -0 is no -0.0, and products of whole numbers are exact
            raise self.error(
                "a choice of a float and a whole number", node, "write 1.0 and not 1 for a float"
            )
        if first.type != second.type:
            raise self.error("a choice of two kinds of values", node, "make them of one kind")
        return first, second

    def whole(self, value: Value) -> bool:
        """True for a whole number."""
        return isinstance(value, Known) or (isinstance(value, Expression) and value.type == INT)

    def integer(self, value: Value, node: ast.AST) -> Expression:
        """A whole number in C."""
        if isinstance(value, Known):
            return self.runtime(Known(int(value.value)), node)
        return self.runtime(value, node)

    def real(self, value: Value, node: ast.AST) -> Expression:
        """A real number in C."""
        if isinstance(value, Known) and not isinstance(value.value, bool):
            if abs(value.value) > LARGEST_REAL and not exact(value.value):
                raise self.error(f"no float holds {value.value}", node, "write it as a float")
            return Literal(REAL, float(value.value))
        if isinstance(value, Expression) and value.type == REAL:
            return value
        if isinstance(value, Expression) and value.type == INT:
            self.scope.limit(value, LARGEST_REAL, node)
            return Conversion(REAL, value)
        if isinstance(value, Known) or (isinstance(value, Expression) and value.type == BOOL):
            raise self.error("a truth value is not a number in C", node, "use ops.where(condition, 1.0, 0.0)")
        raise self.error("a number is needed here", node, "take one number of it")

    def runtime(self, value: Value, node: ast.AST) -> Expression:
        """A value in C."""
        if isinstance(value, Expression):
            return value
        if isinstance(value, Known):
            try:
                return whole(value)
            except TranslationError as error:
                raise self.error(str(error), node, "write it as a float") from None
        raise self.error("this is not a value in C", node)

    def error(self, problem: str, node: ast.AST, way_out: str | None = None) -> TranslationError:
        return self.scope.error(problem, node, WAY_OUT if way_out is None else way_out)


def equal(a: Expression, b: Expression) -> bool:
    """True for whole numbers that are computed in the same way."""
    match a, b:
        case (Whole(value=x), Whole(value=y)) | (Variable(name=x), Variable(name=y)):
            return bool(x == y)
        case (Unary(a=x), Unary(a=y)):
            return equal(x, y)
        case (Member(base=x, name=name), Member(base=y, name=other)):
            return name == other and equal(x, y)
        case (Operation(operator=sign, a=x, b=y), Operation(operator=other, a=v, b=w)):
            same = equal(x, v) and equal(y, w)
            return sign == other and (same or (sign != "-" and equal(x, w) and equal(y, v)))
    return False


def exact(value: int) -> bool:
    """True if a float holds a whole number."""
    try:
        return int(float(value)) == value
    except OverflowError:
        return False
