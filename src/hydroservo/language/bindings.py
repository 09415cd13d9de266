"""What each name of a Python function means where it stands.

A name is a *variable* wherever the same assignments may have given it its value: two uses that no assignment
reaches both are two variables, though they share a name. In C each variable has a name of its own.
"""

import ast
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

Block = tuple[int, ...]  # a block of statements: the way to it, a number for each block around
Reaching = dict[str, frozenset[int]]  # the assignments whose value each name may have


@dataclass(eq=False)
class Binding:
    """One variable of a Python function."""

    name: str  # in Python
    block: Block = ()  # in which it gets its value; that of the first assignment
    changing: bool = False  # its value changes, or is read where its block in C has ended
    counter: bool = False  # the number of a loop, and nothing else
    read: bool = False  # something reads it


@dataclass
class BindingSite:
    """A place where a name gets a value."""

    name: str
    block: Block
    order: int
    counter: bool = False
    reads: list[tuple[Block, int]] = field(default_factory=list)


class LoopEnds(NamedTuple):
    """What reaches the ends of a loop's turns, and of the loop itself, that its statements ask for."""

    turns: list[Reaching]
    loop: list[Reaching]


class Bindings:
    """The variables of a function, from what each assignment reaches."""

    def __init__(self, tree: ast.FunctionDef) -> None:
        self.given: dict[int, BindingSite] = {}  # by the number of the node
        self.joined: dict[int, int] = {}
        self.seen: dict[int, frozenset[int]] = {}
        self.orders: dict[int, int] = {}
        self.loops: list[LoopEnds] = []
        given = parameter_names(tree)
        self.bound = {*bound_names(tree), *(argument.arg for argument in given)}
        first: Reaching = {}
        for argument in given:
            self.set_value(argument, argument.arg, (), first)
        self.flow(tree.body, (), first)
        self.variables = self.variables_by_root()
        self.arguments = {one.arg: self.variables[self.root(id(one))] for one in given}

    def variable_set(self, node: ast.AST) -> Binding:
        """The variable that a node gives a value."""
        return self.variables[self.root(id(node))]

    def variable_read(self, node: ast.AST) -> Binding | None:
        """The variable that a node reads; None where no assignment reaches it."""
        reaching = self.seen.get(id(node))
        return self.variables[self.root(min(reaching))] if reaching else None

    def all(self) -> list[Binding]:
        """Every variable, in the order of the text."""
        return list(dict.fromkeys(self.variables[self.root(one)] for one in self.given))

    # what reaches what

    def flow(self, nodes: Sequence[ast.stmt], block: Block, now: Reaching) -> Reaching | None:
        """What reaches the end of some statements; None where they always return."""
        for node in nodes:
            found = self.statement(node, block, now)
            if found is None:
                return None
            now = found
        return now

    def statement(self, node: ast.stmt, block: Block, now: Reaching) -> Reaching | None:
        match node:
            case ast.Return():
                self.note_reads(node, block, now)
                return None
            case ast.If(test=test, body=body, orelse=otherwise):
                self.note_reads(test, block, now)
                after = self.flow(body, (*block, id(body[0])), dict(now))
                other = self.flow(otherwise, (*block, id(node)), dict(now))
                return merge(after, other)
            case ast.Break():
                self.loops[-1].loop.append(now)
                return None
            case ast.Continue():
                self.loops[-1].turns.append(now)
                return None
            case ast.While(test=test, body=body):
                endless = isinstance(test, ast.Constant) and bool(test.value)
                return self.loop(now, lambda start: self.turn(test, None, body, block, start), endless)
            case ast.For(target=target, iter=counted, body=body):
                self.note_reads(counted, block, now)
                return self.loop(now, lambda start: self.turn(None, target, body, block, start))
            case ast.AnnAssign(value=None):  # gives no value, and takes none away
                return now
        self.note_reads(node, block, now)
        after = dict(now)
        for one in sorted(stores(node), key=lambda one: (one.lineno, one.col_offset)):
            self.set_value(one, one.id, block, after)
        return after

    def turn(
        self,
        test: ast.expr | None,
        target: ast.expr | None,
        body: Sequence[ast.stmt],
        block: Block,
        start: Reaching,
    ) -> Reaching | None:
        """A loop's condition or counter, and its statements."""
        inner = (*block, id(body[0]))
        if test is not None:
            self.note_reads(test, block, start)
        now = dict(start)
        for one in stores(target) if target is not None else ():
            self.set_value(one, one.id, inner, now, counter=True)
        return self.flow(body, inner, now)

    def loop(
        self, now: Reaching, turn: Callable[[Reaching], Reaching | None], endless: bool = False
    ) -> Reaching | None:
        """What reaches the end of a loop, the end of whose turns may reach its beginning."""
        while True:
            self.loops.append(LoopEnds([], []))
            last = turn(now)
            ends = self.loops.pop()
            after = merge_all([now, last, *ends.turns])
            if after is None or after == now:
                return merge_all([None if endless else now, *ends.loop])
            now = after

    def set_value(self, node: ast.AST, name: str, block: Block, now: Reaching, counter: bool = False) -> None:
        if id(node) not in self.given:
            self.given[id(node)] = BindingSite(name, block, self.order(node), counter)
        now[name] = frozenset({id(node)})

    def note_reads(self, node: ast.AST, block: Block, now: Reaching) -> None:
        """Notes what each name in a node reads."""
        for one, name in loads(node):
            reaching = now.get(name, frozenset())
            self.seen[id(one)] = self.seen.get(id(one), frozenset()) | reaching
            order = self.order(one)
            for giver in reaching:
                self.given[giver].reads.append((block, order))
                self.joined[self.root(giver)] = self.root(min(reaching))

    def order(self, node: ast.AST) -> int:
        """A number that grows with the text: names are met in its order."""
        return self.orders.setdefault(id(node), len(self.orders))

    def root(self, giver: int) -> int:
        while self.joined.get(giver, giver) != giver:
            giver = self.joined[giver]
        return giver

    # variables

    def variables_by_root(self) -> dict[int, Binding]:
        """The variables, each by the number of one of its assignments."""
        parts: dict[int, list[BindingSite]] = {}
        for node, one in self.given.items():
            parts.setdefault(self.root(node), []).append(one)
        return {root: merged_variable(givers) for root, givers in parts.items()}


@lru_cache(maxsize=1024)
def bindings_of(tree: ast.FunctionDef) -> Bindings:
    """The variables of a function, found once for all the types that it is translated for."""
    return Bindings(tree)


def merged_variable(givers: Sequence[BindingSite]) -> Binding:
    """The variable that some assignments give its values."""
    first = min(givers, key=lambda one: one.order)
    reads = [read for one in givers for read in one.reads]
    within = all(block[: len(first.block)] == first.block and order > first.order for block, order in reads)
    changing = len(givers) > 1 or not within
    return Binding(first.name, first.block, changing, first.counter and not changing, bool(reads))


def merge(a: Reaching | None, b: Reaching | None) -> Reaching | None:
    """What reaches the place where two ways meet."""
    if a is None or b is None:
        return b if a is None else a
    nothing: frozenset[int] = frozenset()
    return {name: a.get(name, nothing) | b.get(name, nothing) for name in [*a, *b]}


def merge_all(ways: Iterable[Reaching | None]) -> Reaching | None:
    """What reaches the place where ways meet."""
    found: Reaching | None = None
    for way in ways:
        found = merge(found, way)
    return found


def parameter_names(tree: ast.FunctionDef) -> list[ast.arg]:
    """The parameters of a function that takes none with *."""
    return [*tree.args.posonlyargs, *tree.args.args, *tree.args.kwonlyargs]


def loads(node: ast.AST) -> Iterator[tuple[ast.AST, str]]:
    """Every node that reads a name, and the name."""
    for one in ast.walk(node):
        if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Load):
            yield one, one.id
        if isinstance(one, ast.AugAssign) and isinstance(one.target, ast.Name):
            yield one, one.target.id


def stores(node: ast.AST) -> list[ast.Name]:
    return [one for one in ast.walk(node) if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)]


def bound_names(tree: ast.AST) -> Mapping[str, None]:
    """Every name that a function assigns to, in the order of the text."""
    found = sorted(stores(tree), key=lambda node: (node.lineno, node.col_offset))
    return dict.fromkeys(node.id for node in found)
