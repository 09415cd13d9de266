"""Translates the statements of a Python function."""

import ast
from collections.abc import Sequence
from types import FunctionType

from hydroservo.language.bindings import Binding, parameter_names, stores
from hydroservo.language.calls import is_op
from hydroservo.language.expressions import Expressions
from hydroservo.language.names import identifier, snake
from hydroservo.language.ranges import LARGEST, LARGEST_REAL
from hydroservo.language.scope import Scope, TranslationError, Value
from hydroservo.language.terms import (
    BOOL,
    INT,
    REAL,
    Bound,
    Break,
    Call,
    Continue,
    Do,
    Expression,
    For,
    Function,
    HostObject,
    If,
    Known,
    Literal,
    MemoryLoad,
    MemoryStore,
    NamedNumber,
    Record,
    Return,
    Several,
    Statement,
    Translator,
    Type,
    Unary,
    Variable,
    While,
    Whole,
)


class Body:
    """The translation of one Python function for arguments of given types.

    Every method raises :class:`TranslationError` for what is not in the language.
    """

    def __init__(
        self, translator: Translator, origin: FunctionType, arguments: Sequence[Type], owner: type | None
    ) -> None:
        module = f"{origin.__module__}".rpartition(".")[2]
        prefix = own_prefix(owner) if owner else ("ops" if is_op(origin) else module)
        name = translator.function_name(f"{prefix}_{identifier(origin.__name__)}")
        self.translator = translator
        self.scope = Scope(origin, name, owner, translator.local_name)
        self.expressions = Expressions(translator, self.scope)
        self.returned: list[tuple[Type, ast.AST]] = []
        self.loops: list[list[set[str]]] = []  # of each loop, what has a value at each end that is asked for
        tree = self.scope.tree
        if tree.args.vararg or tree.args.kwarg:
            raise self.scope.error("arguments with * are not supported", tree)
        taken = parameter_names(tree)
        if len(taken) != len(arguments):
            problem = f"it takes {len(taken)} arguments, and is given {len(arguments)}"
            raise self.scope.error(problem, tree, "take what is given")
        for argument, kind in zip(taken, arguments, strict=True):
            self.scope.parameter(argument.arg, kind)

    def translated(self) -> Function:
        try:
            return self.translate_body()
        except TranslationError as error:
            error.places.append(self.scope.place)
            raise

    def translate_body(self) -> Function:
        tree, error = self.scope.tree, self.scope.error
        try:
            ends = self.statements(tree.body)
        except RecursionError:
            raise error("its text is nested too deep", tree, "name parts of it") from None
        if not ends and not self.scope.engine:
            raise error("it can end without a return", tree, "let every path return a value")
        if not ends:
            self.returns(ast.Constant(None), tree)
        kinds = {kind for kind, _ in self.returned}
        if not kinds:
            raise error("it never returns", tree, "let every path return a value")
        if len(kinds) > 1:
            raise error(
                "its returns have different types",
                self.returned[-1][1],
                "return one type; write 1.0 and not 1 for a float",
            )
        self.scope.function.returns = kinds.pop()
        self.scope.check_whole()
        return self.scope.function

    def statements(self, nodes: Sequence[ast.stmt]) -> bool:
        """Translates them in order; True if they always return."""
        return any(self.statement(node) for node in nodes)  # what stands behind a return is not reached

    def statement(self, node: ast.stmt) -> bool:
        self.scope.line = node.lineno
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
                self.assigns([target], self.expressions.binary(op, before, change, node), node)
            case ast.AugAssign(target=ast.Subscript() as target, op=op, value=value):
                change = self.expressions.expression(value)
                before = self.expressions.expression(target)
                self.stores(target, self.expressions.arithmetic.binary(op, before, change, node), node)
            case ast.If():
                return self.if_statement(node)
            case ast.Expr(value=ast.Call() as value) if self.scope.engine:
                call = self.expressions.expression(value)
                if isinstance(call, Call):
                    self.scope.block.append(Do(call))
            case ast.Expr(value=value):
                raise self.scope.error(f"{ast.unparse(value)!r} does nothing to a state", node)
            case ast.While(orelse=[]):
                return self.while_loop(node)
            case ast.For(orelse=[]):
                return self.loops_over(node)
            case ast.Break() if self.loops:
                self.loops[-1].append(set(self.scope.certain))
                self.scope.block.append(Break())
                return True
            case ast.Continue() if self.loops:
                self.scope.block.append(Continue())
                return True
            case ast.Raise() | ast.Assert():
                text = ast.unparse(node).partition("\n")[0]
                raise self.scope.error(
                    f"{text!r} is not supported", node, "return math.nan, which ends a run"
                )
            case _:
                text = ast.unparse(node).partition("\n")[0]
                raise self.scope.error(f"{text!r} is not supported", node)
        return False

    def stores(self, target: ast.Subscript, value: Value, node: ast.AST) -> None:
        """A new number in the engine's memory."""
        place = self.expressions.element(self.expressions.expression(target.value), target.slice, node)
        if not (isinstance(place, MemoryLoad) and self.scope.engine):
            raise self.scope.error("blocks, states and arrays are immutable", node, "make a new one")
        arithmetic = self.expressions.arithmetic
        number = arithmetic.real(value, node) if place.type == REAL else arithmetic.integer(value, node)
        self.scope.block.append(MemoryStore(place.memory, place.index, number))

    def returns(self, value: ast.expr, node: ast.AST) -> None:
        found = self.expressions.expression(value)
        if isinstance(found, Several) and isinstance(value, ast.Tuple):
            found = Several(found.items, names_of(value.elts, len(found.items)))
        if isinstance(found, Several) and self.returned:  # by the names of the first
            first, _ = self.returned[0]
            if isinstance(first, Record) and first.cls is None and len(first.fields) == len(found.items):
                found = Several(found.items, tuple(first.fields))
        result = self.expressions.arithmetic.runtime(found, node)
        self.scope.limit(result, LARGEST_REAL, node)
        self.returned.append((result.type, node))
        self.scope.block.append(Return(result))

    def assigns(self, targets: Sequence[ast.expr], value: Value, node: ast.AST) -> None:
        """Assigns one value to each of some targets, none of which may change it for the next."""
        several = len(targets) > 1 or isinstance(targets[0], ast.Tuple | ast.List)
        if several and self.changes(targets):
            value = self.snapshot(value)
        for target in targets:
            match target:
                case ast.Name():
                    self.assign(self.scope.bindings.variable_set(target), value, node)
                case ast.Tuple(elts=names) | ast.List(elts=names):
                    for part, item in zip(names, self.items(value, len(names), node), strict=True):
                        self.assigns([part], item, node)
                case ast.Subscript():
                    self.stores(target, value, node)
                case _:
                    problem = "only names can be assigned to: blocks and states are immutable"
                    raise self.scope.error(problem, node)

    def changes(self, targets: Sequence[ast.expr]) -> bool:
        """True if one of the names in these targets changes."""
        names = (name for target in targets for name in stores(target))
        return any(self.scope.bindings.variable_set(name).changing for name in names)

    def snapshot(self, value: Value) -> Value:
        """A value that the assignments beside it cannot change, as in a, b = b, a."""
        if isinstance(value, Several):
            return Several(tuple(self.snapshot(item) for item in value.items), value.names, value.once)
        if isinstance(value, Bound):
            return Bound(self.expressions.snapshot(value.owner), value.function)
        changes = isinstance(value, Expression) and not isinstance(value, (Literal, NamedNumber))
        return self.scope.let(self.scope.fresh("value"), value) if changes else value

    def items(self, value: Value, count: int, node: ast.AST) -> list[Value]:
        found = self.expressions.items(value, node)
        if len(found) != count:
            raise self.scope.error(f"{len(found)} values for {count} names", node, "give each a name")
        return found

    def assign(self, binding: Binding, value: Value, node: ast.AST) -> None:
        scope, name = self.scope, binding.name
        if isinstance(value, Several) and value.once:
            raise scope.error(f"{name} can be read once alone", node, "loop over it directly")
        if isinstance(value, Bound | Several):  # of records as they are now
            value = self.snapshot(value)
        if binding.changing and value == Known(None):
            raise scope.error(f"{name} is None and something else in turn", node, "give it two names")
        if not binding.changing:
            scope.environment[binding] = scope.let(scope.in_c[binding], value)
            return
        result = self.expressions.arithmetic.runtime(value, node)
        own = scope.environment.get(binding)
        if not (isinstance(own, Variable) and own.mutable):
            own = scope.environment[binding] = scope.declare(scope.in_c[binding], result.type)
        if own.type != result.type:
            way_out = "keep one type; write 1.0 and not 1 for a float"
            raise scope.error(f"{name} changes its type", node, way_out)
        scope.assign(own, result)

    def if_statement(self, node: ast.If) -> bool:
        scope = self.scope
        condition = self.expressions.condition(node.test)
        if isinstance(condition, Known):
            return self.statements(node.body if condition.value else node.orelse)
        certain = set(scope.certain)
        body, ends = self.inner_block(node.body)
        after_body, scope.certain = scope.certain, certain
        otherwise, other_ends = self.inner_block(node.orelse)
        after_other = scope.certain
        scope.certain = after_other if ends else after_body if other_ends else after_body & after_other
        scope.block.append(If(condition, body, otherwise))
        return ends and other_ends

    def while_loop(self, node: ast.While) -> bool:
        """A loop; True if it never ends but by a return."""
        scope = self.scope
        outer, scope.block = scope.block, []
        condition = self.expressions.condition(node.test)
        work, scope.block = scope.block, outer
        if isinstance(condition, Known) and not condition.value:
            return False
        certain, ends = set(scope.certain), self.loop_body(node.body)
        endless, body = isinstance(condition, Known), self.turned
        if work and isinstance(condition, Expression):  # which each turn needs anew
            body = [*work, If(Unary(BOOL, "!", condition), [Break()], []), *body]
        scope.certain = set.intersection(*ends) if endless and ends else certain
        scope.block.append(While(Whole(BOOL, True) if endless or work else condition, body))  # type: ignore[arg-type]
        return endless and not ends

    def loop_body(
        self, nodes: Sequence[ast.stmt], first: tuple[Binding, Variable, ast.AST] | None = None
    ) -> list[set[str]]:
        """Translates a loop's statements, into ``turned``; what has a value at each of its breaks."""
        self.loops.append([])
        self.turned, _ = self.inner_block(nodes, first)
        return self.loops.pop()

    def inner_block(
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

    def loops_over(self, node: ast.For) -> bool:
        """A loop over whole numbers or over the values of a tuple; True if it always returns."""
        match node.iter:
            case ast.Call(func=ast.Name(id="range"), args=given, keywords=[]) if self.is_range(node.iter):
                if not isinstance(node.target, ast.Name):
                    raise self.scope.error("a loop over whole numbers gives one name a value", node)
                self.counted_loop(
                    node, self.scope.bindings.variable_set(node.target), self.expressions.arguments(given)
                )
                return False
            case ast.Call() | ast.Name() | ast.Attribute() | ast.Tuple() | ast.Subscript():
                value = self.expressions.expression(node.iter)
                if isinstance(value, Several) or (
                    isinstance(value, Expression) and isinstance(value.type, Record)
                ):
                    return self.unroll(node, self.expressions.items(value, node))
        raise self.scope.error("only range(...) and tuples can be looped over", node, "count with range")

    def unroll(self, node: ast.For, items: Sequence[Value]) -> bool:
        """The statements once for each value."""
        if leaves_loop(node.body):
            raise self.scope.error("a loop over a tuple runs to its end", node, "count with range, or use if")
        for item in [self.snapshot(item) for item in items]:  # which the statements may not change
            self.assigns([node.target], item, node)
            if self.statements(node.body):
                return True
        return False

    def counted_loop(self, node: ast.For, binding: Binding, given: Sequence[Value]) -> None:
        """A loop; where its number is read after it or changed in it, that is a local of its own."""
        arithmetic = self.expressions.arithmetic
        if not 1 <= len(given) <= 3 or not all(map(arithmetic.whole, given)):
            raise self.scope.error("the count of a loop must be a whole number", node)
        given = [arithmetic.counting(one, node) for one in given]
        start, stop, step = (Known(0), *given, Known(1)) if len(given) == 1 else (*given, Known(1))[:3]
        if not isinstance(step, Known) or step.value == 0:
            raise self.scope.error("the step of a loop must be a known number and not 0", node)
        up, down = max(step.value - 1, 0), max(-step.value - 1, 0)  # by which the count may pass its end
        self.limit_bound(start, -LARGEST - 1, LARGEST, node)
        self.limit_bound(stop, -LARGEST - 1 + down, LARGEST - up, node)
        start, stop, certain = self.snapshot(start), self.snapshot(stop), set(self.scope.certain)
        counter = Variable(INT, self.scope.in_c[binding] if binding.counter else self.scope.fresh("i"))
        if binding.counter:
            self.scope.environment[binding] = counter
        self.loop_body(node.body, None if binding.counter else (binding, counter, node))
        self.scope.certain = certain  # the loop may not run at all
        self.scope.block.append(For(counter.name, start, stop, step, self.turned))

    def limit_bound(self, bound: Value, least: int, most: int, node: ast.For) -> None:
        """Refuse a bound of a loop that is not within [least, most]."""
        if isinstance(bound, Expression):
            self.scope.limit(bound, most, node, least)
        elif isinstance(bound, Known) and not least <= bound.value <= most:
            raise self.scope.error(f"a loop to {bound.value} counts beyond 64 bits", node, "use floats")

    def is_range(self, call: ast.Call) -> bool:
        """True if what is called is Python's own function of that name."""
        found = self.expressions.expression(call.func)
        return isinstance(found, HostObject) and found.thing is range


def leaves_loop(nodes: Sequence[ast.stmt]) -> bool:
    """Whether some statements of a loop leave it or one of its turns."""
    for node in nodes:
        if isinstance(node, ast.Break | ast.Continue):
            return True
        if isinstance(node, ast.If) and leaves_loop([*node.body, *node.orelse]):
            return True
    return False


def names_of(elements: Sequence[ast.expr], count: int) -> tuple[str, ...]:
    """Names for several values: their own where they are variables."""
    names = [f"value_{i}" for i in range(1, count + 1)]
    for i, element in enumerate(elements):
        if isinstance(element, ast.Starred):
            break
        if isinstance(element, ast.Name) and (name := identifier(element.id)) not in names:
            names[i] = name
    return tuple(names)


def own_prefix(owner: type) -> str:
    """What the functions of a class begin with; "ops" is that of written ones."""
    name = snake(owner.__name__)
    return "own_ops" if name == "ops" else name
