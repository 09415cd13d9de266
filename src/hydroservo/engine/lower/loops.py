"""Loops: over whole numbers and while a condition holds; those over tuples are written out.

Names that a loop gives new values become phis at its head. Which type each has is known once the end of the
loop's body is: where that does not fit what was taken for granted, the loop is lowered again.
"""

import ast
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from hydroservo.engine.lower import numbers
from hydroservo.engine.lower.frame import End, Frame, Loop, Unlike, lowers
from hydroservo.engine.lower.memory import item
from hydroservo.engine.lower.source import assigned, read_after
from hydroservo.engine.lower.statements import bind
from hydroservo.engine.lower.values import (
    BOOL,
    DOUBLE,
    INTEGER,
    Array,
    Composite,
    LoweringError,
    Record,
    Scalar,
    is_number,
    kind_of,
    operand,
    same,
    unified,
)
from hydroservo.engine.lower.writer import Writer, said

Path = tuple[Any, ...]  # of a number: the name, and the indices of parts
FEW = 16  # turns of a loop that is unrolled, for loops over lanes hold no others
ZEROS = {DOUBLE: 0.0, INTEGER: 0, BOOL: False}


class Range:
    """What ``range`` gives."""

    def __init__(self, start: Any, stop: Any, step: Any) -> None:
        self.start, self.stop, self.step = start, stop, step


class Turns(NamedTuple):
    """What a loop does around its body."""

    goes_on: Callable[[], Any]
    begin: Callable[[], None] = lambda: None
    advance: Callable[[], None] = lambda: None
    counter: tuple[str, ...] = ()
    few: bool = False


class Guess:
    """What is taken for granted of the names that a loop gives new values."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer
        self.kinds: dict[Path, str] = {}  # of numbers that do not keep the type that they begin with
        self.lost: dict[str, Unlike] = {}  # names that stand for unlike things
        self.late: dict[str, Any] = {}  # names that begin in the loop and are read after it
        self.phis: list[tuple[Scalar, Any]] = []  # and what each begins with
        self.texts: set[str] = set()  # of the phis

    def head(self, value: Any, path: Path) -> Any:
        """What a value becomes at the head of the loop."""
        if isinstance(value, Composite):
            return value.with_parts([self.head(part, (*path, i)) for i, part in enumerate(value.parts)])
        if not is_number(value) or (isinstance(value, bool) and path not in self.kinds):
            return value
        found = self.writer.fresh(self.kinds.get(path, kind_of(value)))
        self.phis.append((found, value))
        self.texts.add(found.text)
        return found

    def ends(self, names: Sequence[str], heads: dict[str, Any], env: dict[str, Any]) -> list[str] | None:
        """What each phi is given at the end of the loop's body; None where that is not as was guessed."""
        given: list[str] = []
        known = [name for name in names if name in heads]
        fits = [self.follow(heads[name], env.get(name), (name,), given) for name in known]
        return given if all(fits) else None

    def follow(self, head: Any, back: Any, path: Path, given: list[str]) -> bool:
        """Whether a value at the end of the body can be the one at the head of the loop."""
        if isinstance(head, Composite) and head.like(back):
            pairs = enumerate(zip(head.parts, back.parts, strict=True))
            fits = [self.follow(*pair, (*path, i), given) for i, pair in pairs]  # each, for what it tells
            return all(fits)
        if isinstance(head, Scalar) and head.text in self.texts and is_number(back):
            kind = unified([head.kind, kind_of(back)])
            given.append(operand(self.writer.converted(back, kind)))
            self.kinds[path] = kind
            return kind == str(head.kind)
        if same(head, back):
            return True
        if is_number(head) and is_number(back):
            self.kinds[path] = unified([kind_of(head), kind_of(back)])
        else:
            problem = f"{said(head)} before a loop and {said(back)} in it"
            self.lost[path[0]] = back if isinstance(back, Unlike) else Unlike(problem)
        return False


def zero(value: Any) -> Any:
    """A value of the same structure, all zeros."""
    if isinstance(value, Composite):
        return value.with_parts([zero(part) for part in value.parts])
    return ZEROS[kind_of(value)] if is_number(value) else value


@lowers(ast.Break)
def break_(frame: Frame, _: ast.Break) -> None:
    frame.loops[-1].breaks.append((frame.writer.end, frame.env))
    frame.writer.here = None


@lowers(ast.Continue)
def continue_(frame: Frame, _: ast.Continue) -> None:
    frame.loops[-1].continues.append((frame.writer.end, frame.env))
    frame.writer.here = None


@lowers(ast.While)
def while_(frame: Frame, node: ast.While) -> None:
    repeat(frame, node, Turns(lambda: numbers.truth(frame.writer, frame.value(node.test))))


@lowers(ast.For)
def for_(frame: Frame, node: ast.For) -> None:
    over = frame.value(node.iter)
    if isinstance(over, Record):
        unroll(frame, node, over.parts)
    elif isinstance(over, Range):
        count(frame, node, over, lambda i: i)
    elif isinstance(over, Array):
        count(frame, node, Range(0, over.lengths[0], 1), lambda i: item(frame.writer, over, i))
    else:
        raise LoweringError(f"compiled code cannot loop over {said(over)}")


def unroll(frame: Frame, node: ast.For, parts: Sequence[Any]) -> None:
    """The body once for each part."""
    loop = Loop()
    frame.loops.append(loop)
    for part in parts:
        if frame.writer.here is None:
            break
        bind(frame, node.target, part)
        frame.run(node.body)
        frame.join([*loop.continues, *here(frame)])
        loop.continues.clear()
    frame.loops.pop()
    if frame.writer.here is not None:
        frame.run(node.orelse)
    frame.join([*here(frame), *loop.breaks])


def here(frame: Frame) -> list[End]:
    """The block that is written, if one is."""
    return [] if frame.writer.here is None else [(frame.writer.here, frame.env)]


def count(frame: Frame, node: ast.For, over: Range, element: Callable[[Any], Any]) -> None:
    """The body for each whole number of a range."""
    w = frame.writer
    counter = f"count{len(frame.loops)}.{node.lineno}"
    frame.env[counter] = over.start
    rising = numbers.compared(w, ast.Gt, over.step, 0)

    def goes_on() -> Any:
        i = frame.env[counter]
        below = numbers.compared(w, ast.Lt, i, over.stop) if rising is not False else False
        above = numbers.compared(w, ast.Gt, i, over.stop) if rising is not True else False
        known = not isinstance(rising, Scalar)
        return (below if rising else above) if known else w.selected(rising, below, above)

    def advance() -> None:
        i = frame.env[counter]
        if over.step == 1:
            frame.env[counter] = w.emit(INTEGER, f"add nsw i64 {operand(i)}, 1")
        else:
            frame.env[counter] = numbers.binary(w, ast.Add, i, over.step)

    begin = lambda: bind(frame, node.target, element(frame.env[counter]))  # noqa: E731 - one of three
    repeat(frame, node, Turns(goes_on, begin, advance, (counter,), few(over)))
    frame.env.pop(counter, None)


def few(over: Range) -> bool:
    """Whether a range is known to be short."""
    bounds = (over.start, over.stop, over.step)
    return not any(isinstance(bound, Scalar) for bound in bounds) and len(range(*bounds)) <= FEW


def repeat(frame: Frame, node: ast.For | ast.While, turns: Turns) -> None:
    """A loop, lowered until what it takes for granted of its names holds."""
    w, guess = frame.writer, Guess(frame.writer)
    names = (*assigned(node), *turns.counter)
    before, mark, returns = frame.env, w.mark(), len(frame.returns)
    while True:
        frame.env = before | guess.late
        if attempt(frame, node, turns, names, guess):
            return
        w.rewind(mark)
        del frame.returns[returns:]
        guess.phis.clear()
        guess.texts.clear()


def attempt(
    frame: Frame, node: ast.For | ast.While, turns: Turns, names: Sequence[str], guess: Guess
) -> bool:
    """The loop lowered; False if it has to be again, with a better guess."""
    w = frame.writer
    entry, head, loop = w.end, w.block(), Loop()
    for name in filter(frame.env.__contains__, names):
        frame.env[name] = guess.lost.get(name) or guess.head(frame.env[name], (name,))
    heads = dict(frame.env)
    starts = [operand(w.converted(value, phi.kind)) for phi, value in guess.phis]
    w.branch(head)
    w.enter(head)
    exits = turn(frame, turns.goes_on())
    if w.here is not None:
        frame.loops.append(loop)
        turns.begin()
        frame.run(node.body)
        frame.loops.pop()
        frame.join([*here(frame), *loop.continues])
    incoming = [f"[ {start}, %{entry.label} ]" for start in starts]
    if w.here is not None:
        turns.advance()
        given = guess.ends(names, heads, frame.env)
        late = [name for name in names if name in frame.env and name not in heads]
        for name in read_after(node, tuple(frame.definition.body)).intersection(late):
            guess.late[name] = zero(frame.env[name])
            given = None
        if given is None:
            return False
        latch = w.end.label
        incoming = [f"{first}, [ {back}, %{latch} ]" for first, back in zip(incoming, given, strict=True)]
        w.loop_back(head, turns.few)
    phis = (f"{phi.text} = phi {phi.kind} " for phi, _ in guess.phis)
    head.phis += map(str.__add__, phis, incoming)
    leave(frame, node, exits, loop)
    return True


def turn(frame: Frame, condition: Any) -> list[End]:
    """Goes on in the body of a loop if a condition holds; returns where it ends otherwise."""
    w, env = frame.writer, dict(frame.env)
    if condition is True:
        return []
    if condition is False:
        end, w.here = w.end, None
        return [(end, env)]
    body, after = w.block(), w.block()
    w.choose(condition, body, after)
    w.enter(body)
    return [(after, env)]


def leave(frame: Frame, node: ast.For | ast.While, exits: list[End], loop: Loop) -> None:
    """Goes on after a loop."""
    w = frame.writer
    w.here = None
    for block, env in exits:
        if block not in w.blocks:
            w.enter(block)
        w.here, frame.env = block, env
        frame.run(node.orelse)
    frame.join([*here(frame), *loop.breaks])
