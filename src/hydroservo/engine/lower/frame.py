"""A function while it is lowered into the one that calls it."""

import ast
import builtins
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

from hydroservo.engine.lower.source import Definition, definition_of
from hydroservo.engine.lower.values import LoweringError, Record, lifted
from hydroservo.engine.lower.writer import Block, DeadEndError, Writer

End = tuple[Block, dict[str, Any]]  # a block that is not left yet, and what the names stand for there

Lower = TypeVar("Lower", bound=Callable[["Frame", Any], Any])

EXPRESSIONS: dict[type, Callable[["Frame", Any], Any]] = {}
STATEMENTS: dict[type, Callable[["Frame", Any], None]] = {}
OPEN = ("hydroservo.ops.", "hydroservo.states", "hydroservo.block", "hydroservo.engine.")
DEEPEST = 60  # calls inside each other
MISSING = object()


def lowers(kind: type[ast.expr | ast.stmt]) -> Callable[[Lower], Lower]:
    """Names the function that lowers expressions or statements of a kind."""

    def registered(lower: Lower) -> Lower:
        (EXPRESSIONS if issubclass(kind, ast.expr) else STATEMENTS)[kind] = lower
        return lower

    return registered


class Unlike:
    """What a name stands for where two values meet that cannot be one."""

    def __init__(self, problem: str) -> None:
        self.problem = problem


class Loop:
    """What leaves a loop, and what goes on with its next turn."""

    def __init__(self) -> None:
        self.breaks: list[End] = []
        self.continues: list[End] = []


class Frame:
    """A call: what its names stand for, and what it has returned so far."""

    def __init__(self, writer: Writer, function: FunctionType, stack: list["Frame"]) -> None:
        self.writer, self.function, self.stack = writer, function, stack
        self.definition: Definition = definition_of(function)
        self.env: dict[str, Any] = {}
        self.returns: list[tuple[Block, Any]] = []
        self.loops: list[Loop] = []
        self.line = function.__code__.co_firstlineno

    @property
    def place(self) -> tuple[str, int]:
        """File and line of what is lowered now."""
        return str(Path(self.function.__code__.co_filename).absolute()), self.line

    def value(self, node: ast.expr) -> Any:
        """What an expression stands for."""
        lower = EXPRESSIONS.get(type(node))
        if lower is None:
            self.line = node.lineno
            raise LoweringError(f"compiled code does not support {ast.unparse(node)}")
        return lower(self, node)

    def run(self, body: Sequence[ast.stmt]) -> None:
        """Statements, up to one after which nothing goes on."""
        for statement in body:
            if self.writer.here is None:
                return
            self.line = statement.lineno
            lower = STATEMENTS.get(type(statement))
            if lower is None:
                raise LoweringError(
                    f"compiled code does not support '{ast.unparse(statement).partition(chr(10))[0]}'"
                )
            try:
                lower(self, statement)
            except DeadEndError:
                self.writer.here = None

    def join(self, ends: Sequence[End]) -> None:
        """Goes on where some blocks meet."""
        w = self.writer
        if len(ends) < 2:
            w.here, self.env = ends[0] if ends else (None, {})
            return
        target, blocks = w.block(), [block for block, _ in ends]
        first, *others = (env for _, env in ends)
        self.env = {
            name: self.met(target, blocks, [value, *(env[name] for env in others)])
            for name, value in first.items()
            if all(name in env for env in others)
        }
        for block in blocks:
            w.here = block
            w.branch(target)
        w.enter(target)

    def met(self, target: Block, blocks: Sequence[Block], values: Sequence[Any]) -> Any:
        """What a name stands for where blocks meet."""
        first = values[0]
        if all(value is first for value in values):
            return first
        for value in values:
            if isinstance(value, Unlike):
                return value
        try:
            return self.writer.phi(target, blocks, values)
        except LoweringError as error:
            return Unlike(str(error))

    def named(self, name: str) -> Any:
        """What a name stands for."""
        found = self.env.get(name, MISSING)
        if isinstance(found, Unlike):
            raise LoweringError(f"{name} is {found.problem}")
        if found is not MISSING:
            return found
        if name in self.definition.local:
            raise LoweringError(f"{name} may have no value here")
        return checked(name, lifted(self.outer(name)))

    def outer(self, name: str) -> Any:
        """What a name stands for outside of the function."""
        code = self.function.__code__
        if name in code.co_freevars:
            return (self.function.__closure__ or ())[code.co_freevars.index(name)].cell_contents
        found = self.function.__globals__.get(name, getattr(builtins, name, MISSING))
        if found is MISSING:
            raise LoweringError(f"there is no {name}")
        if isinstance(found, FunctionType):
            allowed(name, found)
        return found


def checked(name: str, value: Any) -> Any:
    """A value that compiled code may have."""
    if isinstance(value, list | dict | set):
        raise LoweringError(f"{name} is a {type(value).__name__}, which compiled code does not support")
    return value


def allowed(name: str, function: FunctionType) -> None:
    """Refuse a function that is no method, none of ops and none of the engine."""
    if not str(function.__module__).startswith(OPEN):
        way = "make it a method of the block"
        raise LoweringError(f"{name} is a function of a module, which compiled code cannot call: {way}")


def inlined(
    writer: Writer,
    function: Any,
    given: Sequence[Any],
    named: Mapping[str, Any],
    stack: list[Frame],
) -> Any:
    """What a function returns for some values; its text is lowered here."""
    if len(stack) >= DEEPEST:
        raise LoweringError(f"{function.__name__} calls itself, or nests too many calls")
    frame = Frame(writer, function, stack)
    frame.env = arguments(function, frame.definition.arguments, given, named)
    stack.append(frame)
    frame.run(frame.definition.body)
    if writer.here is not None:
        frame.returns.append((writer.here, None))
    stack.pop()
    return writer.meet(frame.returns)


def arguments(
    function: FunctionType, asked: ast.arguments, given: Sequence[Any], named: Mapping[str, Any]
) -> dict[str, Any]:
    """What each argument of a function stands for."""
    names = [one.arg for one in (*asked.posonlyargs, *asked.args)]
    env = dict(zip(names, given, strict=False))
    if asked.vararg:
        env[asked.vararg.arg] = Record(tuple, given[len(names) :])
    elif len(given) > len(names):
        raise LoweringError(f"{function.__name__} takes {len(names)} arguments, not {len(given)}")
    keywords = [one.arg for one in asked.kwonlyargs]
    for name, value in named.items():
        if name in env or name not in (*names, *keywords):
            raise LoweringError(f"{function.__name__} takes no argument {name}")
        env[name] = value
    defaults = function.__defaults__ or ()
    spare = dict(zip(names[len(names) - len(defaults) :], defaults, strict=True)) | (
        function.__kwdefaults__ or {}
    )
    for name in (*names, *keywords):
        if name not in env and name not in spare:
            raise LoweringError(f"{function.__name__} is missing its argument {name}")
    return {name: lifted(value) for name, value in spare.items()} | env
