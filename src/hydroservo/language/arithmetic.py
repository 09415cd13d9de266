"""Translates operators: what is known while translating is computed, all else becomes an operation."""

import ast
import operator
from collections.abc import Callable, Sequence
from typing import Any

from hydroservo.language import functions
from hydroservo.language.ranges import LARGEST, LARGEST_REAL
from hydroservo.language.scope import WAY_OUT, Scope, TranslationError, Value, runtime_whole
from hydroservo.language.terms import (
    BOOL,
    INT,
    REAL,
    Call,
    Choice,
    Conversion,
    Expression,
    Known,
    Literal,
    Make,
    Member,
    Operation,
    Several,
    Translator,
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
    ast.BitXor: operator.xor,
    ast.Pow: operator.pow,
}
BITS: dict[type, str] = {ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^", ast.LShift: "<<", ast.RShift: ">>"}
LOGIC = {"&": "&", "|": "|", "^": "!="}  # of truth values
MOST_BITS = 64  # that a shift or power of known numbers may reach, lest it fill the memory
COMPARISONS: dict[type[ast.cmpop], tuple[str, Callable[[Any, Any], bool]]] = {
    ast.Lt: ("<", operator.lt),
    ast.LtE: ("<=", operator.le),
    ast.Gt: (">", operator.gt),
    ast.GtE: (">=", operator.ge),
    ast.Eq: ("==", operator.eq),
    ast.NotEq: ("!=", operator.ne),
}
DIVISIONS: dict[type, Any] = {ast.FloorDiv: functions.whole_quotient, ast.Mod: functions.whole_modulo}
REMAINDERS: dict[type, Any] = {ast.FloorDiv: functions.floor_quotient, ast.Mod: functions.modulo}


class Arithmetic:
    """The operators of one function.

    Every method raises :class:`TranslationError` for what is not in the language.
    """

    def __init__(self, translator: Translator, scope: Scope) -> None:
        self.translator, self.scope = translator, scope

    def binary(self, op: ast.operator, a: Value, b: Value, node: ast.AST) -> Value:
        """a op b."""
        if isinstance(a, Known) and isinstance(b, Known):
            return self.fold(op, a, b, node)
        if isinstance(op, ast.Pow) and isinstance(a, Known | Literal) and isinstance(b, Known | Literal):
            return self.fold(op, a, b, node)
        if type(op) in BITS and is_truth(a) and is_truth(b) and BITS[type(op)] in LOGIC:
            return Operation(BOOL, LOGIC[BITS[type(op)]], self.truth(a), self.truth(b))
        if self.whole(a) and self.whole(b) and not isinstance(op, ast.Div):
            return self.whole_numbers(op, a, b, node)
        if type(op) in REMAINDERS:
            function = self.translator.function(REMAINDERS[type(op)], [REAL, REAL])
            return Call(REAL, function, (self.real(a, node), self.real(b, node)), ast.unparse(node))
        if type(op) not in SIGNS:
            way_out = "write x * x, or use ops.power" if isinstance(op, ast.Pow) else WAY_OUT
            text = ast.unparse(ast.BinOp(ast.Name("a"), op, ast.Name("b")))
            raise self.error(f"{text} of floats is not supported", node, way_out)
        return Operation(REAL, SIGNS[type(op)], self.real(a, node), self.real(b, node))

    def fold(self, op: ast.operator, a: Known | Literal, b: Known | Literal, node: ast.AST) -> Value:
        """An operation of numbers that are both known."""
        if isinstance(op, (ast.Pow, ast.LShift)) and isinstance(a, Known) and abs(b.value) > MOST_BITS:
            raise self.error(f"a number of more than {MOST_BITS} bits", node)
        try:
            found = FOLDED[type(op)](a.value, b.value)
            return Known(found) if isinstance(found, int) else Literal(REAL, float(found))
        except (KeyError, ArithmeticError, TypeError, ValueError) as error:
            raise self.error(f"{ast.unparse(node)!r} is not supported: {error}", node) from None

    def whole_numbers(self, op: ast.operator, a: Value, b: Value, node: ast.AST) -> Expression:
        """An operation of whole numbers that are not both known; they have 64 bits at run time."""
        first, second = self.integer(a, node), self.integer(b, node)
        house, known = self.scope.house, isinstance(b, Known) and b.value > 0
        if type(op) in DIVISIONS and (house or known):
            function = self.translator.function(DIVISIONS[type(op)], [INT, INT])
            return Call(INT, function, (first, second), ast.unparse(node))
        sign = SIGNS.get(type(op)) or (BITS.get(type(op)) if house else None)
        if sign is None:
            way_out = (
                "divide by a positive number that is written out" if type(op) in DIVISIONS else "use floats"
            )
            raise self.error("this operation on whole numbers is not supported", node, way_out)
        found = Operation(INT, sign, first, second)
        self.scope.limit(found, LARGEST, node)
        return found

    def minus(self, value: Value, node: ast.AST) -> Value:
        """-a."""
        if isinstance(value, Known) and is_number(value):
            return Known(-value.value)
        if isinstance(value, Literal):
            return Literal(REAL, -value.value)
        if isinstance(value, Expression) and value.type in (REAL, INT):
            return Unary(value.type, "-", value)
        if is_truth(value):
            return Unary(INT, "-", self.integer(value, node))
        raise self.error(f"{ast.unparse(node)!r} is not supported", node)

    def comparison(self, a: Value, op: ast.cmpop, b: Value, node: ast.AST) -> Expression | Known:
        """a < b and its like."""
        if isinstance(op, (ast.Is, ast.IsNot)):
            return Known(self.identical(a, b, node) is isinstance(op, ast.Is))
        if type(op) not in COMPARISONS:
            raise self.error("this comparison is not supported", node)
        sign, compare = COMPARISONS[type(op)]
        if isinstance(a, Known) and isinstance(b, Known) and is_number(a) and is_number(b):
            return Known(compare(a.value, b.value))
        if self.whole(a) and self.whole(b):
            first, second = self.integer(a, node), self.integer(b, node)
            same = equal(first, second)  # which C compilers complain of
            return Known(compare(0, 0)) if same else Operation(BOOL, sign, first, second)
        return Operation(BOOL, sign, self.real(a, node), self.real(b, node))

    def identical(self, a: Value, b: Value, node: ast.AST) -> bool:
        """Whether one of two values is None as the other one is."""
        if Known(None) not in (a, b):
            raise self.error(
                "whether two values are one object is not known", node, "compare with None alone"
            )
        return a == b

    def logic(self, sign: str, conditions: Sequence[Expression | Known]) -> Expression | Known:
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

    def negation(self, condition: Expression | Known) -> Expression | Known:
        """not a."""
        return Known(not condition.value) if isinstance(condition, Known) else Unary(BOOL, "!", condition)

    def choice(
        self, condition: Expression, a: Value, b: Value, node: ast.AST, both: bool = False
    ) -> Expression:
        """a if the condition holds, else b."""
        first, second = self.of_one_type(a, b, node)
        if isinstance(first.type, Known):
            return first
        return Choice(first.type, condition, first, second, both)

    def of_one_type(self, a: Value, b: Value, node: ast.AST) -> tuple[Expression, Expression]:
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
        """True for a whole number or a truth value."""
        if isinstance(value, Known):
            return is_number(value)
        return isinstance(value, Expression) and value.type in (INT, BOOL)

    def integer(self, value: Value, node: ast.AST) -> Expression:
        """A whole number at run time, of a truth value 1 or 0."""
        if isinstance(value, Known):
            return self.runtime(Known(int(value.value)), node)
        if isinstance(value, Expression) and value.type == BOOL:
            return Choice(INT, value, Whole(INT, 1), Whole(INT, 0))
        return self.runtime(value, node)

    def counting(self, value: Value, node: ast.AST) -> Value:
        """A whole number, known or not, that counts or finds something."""
        return Known(int(value.value)) if isinstance(value, Known) else self.integer(value, node)

    def truth(self, value: Value) -> Expression:
        """A truth value at run time."""
        assert isinstance(value, (Known, Expression))
        return Whole(BOOL, value.value) if isinstance(value, Known) else value

    def real(self, value: Value, node: ast.AST) -> Expression:
        """A real number at run time, of a truth value 1 or 0."""
        if isinstance(value, Known) and is_number(value):
            if abs(value.value) > LARGEST_REAL and not is_exact_whole(value.value):
                raise self.error(f"no float holds {value.value}", node, "write it as a float")
            return Literal(REAL, float(value.value))
        if isinstance(value, Expression) and value.type == REAL:
            return value
        if isinstance(value, Expression) and value.type == INT:
            self.scope.limit(value, LARGEST_REAL, node)
            return Conversion(REAL, value)
        if isinstance(value, Expression) and value.type == BOOL:
            return Choice(REAL, value, Literal(REAL, 1.0), Literal(REAL, 0.0))
        raise self.error("a number is needed here", node, "take one number of it")

    def runtime(self, value: Value, node: ast.AST) -> Expression:
        """A value at run time; several are a record."""
        if isinstance(value, Expression):
            return value
        if isinstance(value, Several):
            return self.record_of(value, node)
        if isinstance(value, Known):
            try:
                return runtime_whole(value)
            except TranslationError as error:
                raise self.error(str(error), node, "write it as a float") from None
        raise self.error("this is not a number, a block or several of them", node)

    def record_of(self, several: Several, node: ast.AST) -> Make:
        if several.once:
            raise self.error("these values can be read once alone", node, "write tuple(...)")
        values = {
            name: self.runtime(item, node) for name, item in zip(several.names, several.items, strict=True)
        }
        for value in values.values():
            self.scope.limit(value, LARGEST_REAL, node)
        kinds = {name: value.type for name, value in values.items()}
        return Make(self.translator.record(None, kinds, f"{self.scope.function.name}_values"), values)

    def error(self, problem: str, node: ast.AST, way_out: str | None = None) -> TranslationError:
        return self.scope.error(problem, node, WAY_OUT if way_out is None else way_out)


def is_number(value: Known) -> bool:
    """True for a whole number or a truth value, not for None."""
    return isinstance(value.value, int)


def is_truth(value: Value) -> bool:
    """True for a truth value, known or not."""
    if isinstance(value, Known):
        return isinstance(value.value, bool)
    return isinstance(value, Expression) and value.type == BOOL


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
            return sign == other and (same or (sign in "+*&|^" and equal(x, w) and equal(y, v)))
    return False


def is_exact_whole(value: int) -> bool:
    """True if a float holds a whole number."""
    try:
        return int(float(value)) == value
    except OverflowError:
        return False
