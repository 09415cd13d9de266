"""Writes translated functions as LLVM's text.

Each is a function of its own, which LLVM puts in the place of its calls. Records are passed by value; the
numbers of a local that changes stand in memory of the stack, from which LLVM takes them.
"""

from collections.abc import Sequence
from typing import Any

from hydroservo.engine.llvm.module import Module, parts_of
from hydroservo.engine.llvm.values import Values
from hydroservo.language.terms import (
    INT,
    Assign,
    Break,
    Continue,
    Do,
    Expression,
    For,
    Function,
    If,
    Known,
    Let,
    Record,
    Require,
    Return,
    Statement,
    Store,
    While,
)

FEW = 16  # turns of a loop that is unrolled, for loops over lanes hold no others


def function_text(module: Module, function: Function) -> str:
    """The text of a function."""
    return Body(module, function).text()


class Body(Values):
    """The statements of one function."""

    def __init__(self, module: Module, function: Function) -> None:
        super().__init__(module)
        self.function = function
        self.loops: list[tuple[str, str]] = []  # where a turn and the loop end
        self.result: Any = None  # where a record is put that is returned at several places
        self.fails = module.fails(function)

    def text(self) -> str:
        function, module = self.function, self.module
        kinds = [(name, kind) for name, kind in function.parameters if not isinstance(kind, Known)]
        self.names = {name: f"%a{i}" for i, (name, _) in enumerate(kinds)}
        taken = [f"{module.type(kind)} %a{i}" for i, (_, kind) in enumerate(kinds)]
        taken += ["ptr %failed"] * self.fails
        self.changing = {name: self.slot(kind) for name, kind in function.locals.items()}
        returned = module.type(function.returns)
        if isinstance(function.returns, Record) and len(returns_in(function.body)) > 1:
            self.result = self.slot(function.returns)
        self.statements(function.body)
        if self.label:
            self.lines.append("  unreachable")
        if self.result is not None:
            self.enter("done")
            self.leave(f"ret {returned} {self.taken(self.result, function.returns)}")
        if self.failed:
            self.lines += [
                "raised:",
                "  ret void" if returned == "void" else f"  ret {returned} zeroinitializer",
            ]
        head = f"define internal {returned} @f.{function.name}({', '.join(taken)}) alwaysinline nounwind {{"
        return "\n".join([head, "entry:", *self.slots, *self.lines, "}"])

    # statements

    def statements(self, body: Sequence[Statement]) -> None:
        for one in body:
            if self.label:
                self.statement(one)

    def statement(self, one: Statement) -> None:
        match one:
            case Let(name=name, value=value):
                self.names[name] = self.value(value)
            case Assign(name=name, value=value):
                self.put(self.changing[name], value.type, self.value(value))
            case Store(memory=memory, index=index, value=value):
                kind = self.module.type(value.type)
                given = self.value(value)
                self.line(f"store {kind} {given}, ptr {self.address(memory, index)}, align 8")
            case Do(call=call):
                self.value(call)
            case Require(condition=condition):
                holds = self.value(condition)
                (further, fails) = self.labels("so", "fails")
                self.choose(holds, further, fails)
                self.enter(fails)
                self.failed = True
                self.line("store i1 true, ptr %failed")
                self.branch("raised")
                self.enter(further)
            case Return(value=value):
                self.returns(value)
            case If(condition=condition, body=body, otherwise=otherwise):
                self.branches(condition, body, otherwise)
            case While(condition=condition, body=body):
                self.repeats(condition, body)
            case For():
                self.counts(one)
            case Break():
                self.branch(self.loops[-1][1])
            case Continue():
                self.branch(self.loops[-1][0])

    def returns(self, value: Expression) -> None:
        found = self.value(value)
        if self.result is not None:
            self.put(self.result, value.type, found)
            self.branch("done")
            return
        kind = self.module.type(value.type)
        self.leave("ret void" if kind == "void" else f"ret {kind} {found}")

    def branches(
        self, condition: Expression, body: Sequence[Statement], otherwise: Sequence[Statement]
    ) -> None:
        then, other, after = self.labels("then", "else", "after")
        self.choose(self.value(condition), then, other if otherwise else after)
        self.enter(then)
        self.statements(body)
        goes_on = bool(self.label) or not otherwise
        self.branch(after)
        if otherwise:
            self.enter(other)
            self.statements(otherwise)
            goes_on = goes_on or bool(self.label)
            self.branch(after)
        if goes_on:
            self.enter(after)

    def repeats(self, condition: Expression, body: Sequence[Statement]) -> None:
        head, inside, after = self.labels("head", "turn", "after")
        self.branch(head)
        self.enter(head)
        self.choose(self.value(condition), inside, after)
        self.enter(inside)
        self.turn(body, head, after, few=False)
        self.enter(after)

    def counts(self, loop: For) -> None:
        slot, step = self.slot(INT), loop.step.value
        stop = self.index(loop.stop)
        self.line(f"store i64 {self.index(loop.start)}, ptr {slot}")
        head, inside, next_turn, after = self.labels("head", "turn", "next", "after")
        self.branch(head)
        self.enter(head)
        i = self.emit(f"load i64, ptr {slot}")
        self.choose(self.emit(f"icmp {'slt' if step > 0 else 'sgt'} i64 {i}, {stop}"), inside, after)
        self.enter(inside)
        self.names[loop.name] = i
        self.loops.append((next_turn, after))
        self.statements(loop.body)
        self.loops.pop()
        self.branch(next_turn)
        self.enter(next_turn)
        self.line(f"store i64 {self.emit(f'add nsw i64 {i}, {step}')}, ptr {slot}")
        self.loop_back(head, few_turns(loop))
        self.enter(after)

    def turn(self, body: Sequence[Statement], head: str, after: str, *, few: bool) -> None:
        """The statements of a loop, which goes on at its head."""
        next_turn, *_ = self.labels("next")
        self.loops.append((next_turn, after))
        self.statements(body)
        self.loops.pop()
        self.branch(next_turn)
        self.enter(next_turn)
        self.loop_back(head, few)

    def loop_back(self, head: str, few: bool) -> None:
        """Leaves this block for the head of the loop that it ends."""
        self.module.few.append(few)
        self.leave(f"br label %{head}, !llvm.loop !{len(self.module.few)}")


def few_turns(loop: For) -> bool:
    """Whether a loop is known to be short."""
    bounds = (loop.start, loop.stop, loop.step)
    return all(isinstance(one, Known) for one in bounds) and len(range(*(one.value for one in bounds))) <= FEW


def returns_in(body: Sequence[Statement]) -> list[Return]:
    """The returns in some statements."""
    inner = [one for statement in body for one in parts_of(statement) if isinstance(one, Statement)]
    return [one for one in body if isinstance(one, Return)] + (returns_in(inner) if inner else [])
