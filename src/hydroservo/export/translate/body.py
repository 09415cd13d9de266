"""Translates the statements of a Python function."""

import ast
from collections.abc import Sequence
from types import FunctionType

from hydroservo.export.names import identifier, snake
from hydroservo.export.translate.bindings import Binding, parameters
from hydroservo.export.translate.calls import is_op
from hydroservo.export.translate.expressions import Expressions
from hydroservo.export.translate.ranges import LARGEST_REAL
from hydroservo.export.translate.scope import Scope, Value
from hydroservo.export.translate.terms import (
    INT,
    Bound,
    Constant,
    Expression,
    For,
    Function,
    If,
    Known,
    Literal,
    Make,
    Python,
    Record,
    Return,
    Several,
    Statement,
    Translator,
    Type,
    Variable,
    While,
)


class Body:
    """The translation of one Python function for arguments of given types.

    Every method raises :class:`TranslationError` where C has no equal.
    """

    def __init__(
        self, translator: Translator, origin: FunctionType, arguments: Sequence[Type], owner: type | None
    ) -> None:
        module = origin.__module__.rpartition(".")[2]
        prefix = own_prefix(owner) if owner else ("ops" if is_op(origin) else module)
        name = translator.function_name(f"{prefix}_{identifier(origin.__name__)}")
        self.translator = translator
        self.scope = Scope(origin, name, owner, translator.local_name)
        self.expressions = Expressions(translator, self.scope)
        self.returned: list[tuple[Type, ast.AST]] = []
        tree = self.scope.tree
        if tree.args.vararg or tree.args.kwarg or tree.args.kwonlyargs:
            raise self.scope.error("arguments with * cannot be translated to C", tree)
        taken = parameters(tree)
        if len(taken) != len(arguments):
            problem = f"it takes {len(taken)} arguments, and is given {len(arguments)}"
            raise self.scope.error(problem, tree, "take what is given")
        for argument, kind in zip(taken, arguments, strict=True):
            self.scope.parameter(argument.arg, kind)

    def translated(self) -> Function:
        tree, error = self.scope.tree, self.scope.error
        try:
            ends = self.statements(tree.body)
        except RecursionError:
            raise error("its text is nested too deep", tree, "name parts of it") from None
        if not ends:
            raise error("it can end without a return", tree, "let every path return a value")
        kinds = {kind for kind, _ in self.returned}
        if len(kinds) > 1:
            raise error("its returns have different types", self.returned[-1][1], "return one type")
        self.scope.function.returns = kinds.pop()
        self.scope.check_whole()
        return self.scope.function

    def statements(self, nodes: Sequence[ast.stmt]) -> bool:
        """Translates them in order; True if they always return."""
        return any(self.statement(node) for node in nodes)  # what stands behind a return is not reached

    def statement(self, node: ast.stmt) -> bool:
        match node:
            case ast.Expr(value=ast.Constant()) | ast.Pass():
                return False
            case ast.Return(value=ast.expr() as value):
                self.returns(value, node)
                return True
            case ast.Assign(targets=targets, value=value):
                self.assigns(targets, self.expressions.expression(value), node)
            case ast.AnnAssign(value=None):
                return False
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                self.assigns([target], self.expressions.expression(value), node)
            case ast.AugAssign(target=ast.Name(id=name) as target, op=op, value=value):
                before, change = self.expressions.named(name, node), self.expressions.expression(value)
                self.assigns([target], self.expressions.arithmetic.binary(op, before, change, node), node)
            case ast.If():
                return self.branches(node)
            case ast.Expr(value=value):
                raise self.scope.error(f"{ast.unparse(value)!r} does nothing to a state", node)
            case ast.While(orelse=[]):
                self.repeats(node)
            case ast.For(target=ast.Name() as target, orelse=[]):
                self.counts(node, self.scope.bindings.assigned(target))
            case _:
                text = ast.unparse(node).partition("\n")[0]
                raise self.scope.error(f"the statement {text!r} has no equal in C here", node)
        return False

    def returns(self, value: ast.expr, node: ast.AST) -> None:
        found = self.expressions.expression(value)
        if isinstance(found, Several):
            found = self.gathered(found, node)
        result = self.expressions.arithmetic.runtime(found, node)
        self.scope.limit(result, LARGEST_REAL, node)
        self.returned.append((result.type, node))
        self.scope.block.append(Return(result))

    def gathered(self, several: Several, node: ast.AST) -> Make:
        """Several values as one record."""
        pairs = zip(several.names, several.items, strict=True)
        values = {name: self.expressions.arithmetic.runtime(item, node) for name, item in pairs}
        kinds = {name: value.type for name, value in values.items()}
        for value in values.values():
            self.scope.limit(value, LARGEST_REAL, node)
        record = self.translator.record(None, kinds, f"{self.scope.function.name}_values")
        return Make(record, values)

    def assigns(self, targets: Sequence[ast.expr], value: Value, node: ast.AST) -> None:
        """Assigns one value to each of some targets, none of which may change it for the next."""
        several = len(targets) > 1 or isinstance(targets[0], ast.Tuple)
        if several and self.changing(targets):
            value = self.held(value)
        for target in targets:
            match target:
                case ast.Name():
                    self.assign(self.scope.bindings.assigned(target), value, node)
                case ast.Tuple(elts=names):
                    for part, item in zip(names, self.items(value, len(names), node), strict=True):
                        self.assigns([part], item, node)
                case _:
                    problem = "only names can be assigned to: blocks and states are immutable"
                    raise self.scope.error(problem, node)

    def changing(self, targets: Sequence[ast.expr]) -> bool:
        """True if one of the names in these targets changes."""
        names = (node for one in targets for node in ast.walk(one) if isinstance(node, ast.Name))
        return any(self.scope.bindings.assigned(name).changing for name in names)

    def held(self, value: Value) -> Value:
        """A value that the assignments beside it cannot change, as in a, b = b, a."""
        if isinstance(value, Several):
            return Several(tuple(self.held(item) for item in value.items), value.names)
        changes = isinstance(value, Expression) and not isinstance(value, (Literal, Constant))
        return self.scope.let(self.scope.fresh("value"), value) if changes else value

    def items(self, value: Value, count: int, node: ast.AST) -> list[Value]:
        if isinstance(value, Several):
            found: list[Value] = list(value.items)
        elif isinstance(value, Expression) and isinstance(value.type, Record):
            lasting = self.scope.lasting(value)
            found = [self.expressions.member(lasting, name) for name in value.type.fields]
        else:
            raise self.scope.error("this is not several values", node)
        if len(found) != count:
            raise self.scope.error(f"{len(found)} values for {count} names", node, "give each a name")
        return found

    def assign(self, binding: Binding, value: Value, node: ast.AST) -> None:
        scope, name = self.scope, binding.name
        if isinstance(value, Several):
            raise scope.error("several values under one name", node, "give each a name")
        if isinstance(value, Bound):  # of the record as it is now
            value = Bound(self.expressions.kept(value.owner), value.function)
        if not binding.changing:
            scope.environment[binding] = scope.let(scope.in_c[binding], value)
            return
        result = self.expressions.arithmetic.runtime(value, node)
        own = scope.environment.get(binding)
        if not (isinstance(own, Variable) and own.mutable):
            own = scope.environment[binding] = scope.declared(scope.in_c[binding], result.type)
        if own.type != result.type:
            way_out = "keep one type; write 1.0 and not 1 for a float"
            raise scope.error(f"{name} changes its type", node, way_out)
        scope.changed(own, result)

    def branches(self, node: ast.If) -> bool:
        scope = self.scope
        condition = self.expressions.condition(node.test)
        if isinstance(condition, Known):
            return self.statements(node.body if condition.value else node.orelse)
        certain = set(scope.certain)
        body, ends = self.inner(node.body)
        after_body, scope.certain = scope.certain, certain
        otherwise, other_ends = self.inner(node.orelse)
        after_other = scope.certain
        scope.certain = after_other if ends else after_body if other_ends else after_body & after_other
        scope.block.append(If(condition, body, otherwise))
        return ends and other_ends

    def repeats(self, node: ast.While) -> None:
        scope = self.scope
        before, certain = len(scope.block), set(scope.certain)
        condition = self.expressions.condition(node.test)
        if len(scope.block) != before or isinstance(condition, Known):
            raise scope.error("this condition of a loop has no equal in C here", node, "name its parts")
        body, _ = self.inner(node.body)
        scope.certain = certain  # the loop may not run at all
        scope.block.append(While(condition, body))

    def inner(
        self, nodes: Sequence[ast.stmt], first: tuple[Binding, Variable, ast.AST] | None = None
    ) -> tuple[list[Statement], bool]:
        """The statements of a block of their own, which may begin with a value for a variable.

        What first gets a value in it is gone after it, but for what changes.
        """
        scope = self.scope
        outer, environment = scope.block, dict(scope.environment)
        scope.block = []
        if first is not None:
            self.assign(*first)
        ends = self.statements(nodes)
        body, scope.block = scope.block, outer
        kept = {one: v for one, v in scope.environment.items() if isinstance(v, Variable) and v.mutable}
        scope.environment = environment | kept
        return body, ends

    def counts(self, node: ast.For, binding: Binding) -> None:
        """A loop; where its number is read after it or changed in it, that is a local of its own."""
        scope = self.scope
        match node.iter:
            case ast.Call(func=ast.Name(id="range"), args=[given], keywords=[]) if self.builtin(node.iter):
                count = self.expressions.expression(given)
            case _:
                raise scope.error("only range(count) can be looped over", node, "count from 0 in steps of 1")
        if not self.expressions.arithmetic.whole(count):
            raise scope.error("the count of a loop must be a whole number", node)
        if isinstance(count, Known):
            self.expressions.arithmetic.integer(count, node)
        count, certain = self.held(count), set(scope.certain)
        counter = Variable(INT, scope.in_c[binding] if binding.counter else scope.fresh("i"))
        if binding.counter:
            scope.environment[binding] = counter
        body, _ = self.inner(node.body, None if binding.counter else (binding, counter, node))
        scope.certain = certain  # the loop may not run at all
        scope.block.append(For(counter.name, count, body))

    def builtin(self, call: ast.Call) -> bool:
        """True if what is called is Python's own function of that name."""
        found = self.expressions.expression(call.func)
        return isinstance(found, Python) and found.thing is range


def own_prefix(owner: type) -> str:
    """What the functions of a class begin with; "ops" is that of written ones."""
    name = snake(owner.__name__)
    return "own_ops" if name == "ops" else name
