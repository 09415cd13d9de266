"""Writes a translated function, and all that it calls in the place of the calls, as one of LLVM's.

The numbers of a local that changes stand in memory of the stack, from which LLVM takes them.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.engine.llvm.values import NUMBERS, FunctionValues, float_literal
from hydroservo.language import terms

FEW = 16  # turns of a loop that is unrolled, for loops over lanes hold no others


class LLVMWriter(FunctionValues):
    """The statements of a function and of those that it calls."""

    def __init__(self) -> None:
        super().__init__()
        self.loops: list[tuple[str, str]] = []  # where a turn and the loop end
        self.result: Any = None  # where the value is put that a function returns
        self.done = ""  # and where it ends

    def text(self, name: str, arguments: Sequence[str]) -> str:
        """The module of a function that returns 0, or 1 where something raises."""
        tables = [array_constant(name, table.array) for table, name in self.tables.items()]
        unrolled = len(self.few) + 1
        nodes = [f"!{i} = distinct !{{!{i}, !{unrolled if few else 0}}}" for i, few in enumerate(self.few, 1)]
        nodes.append(f'!{unrolled} = !{{!"llvm.loop.unroll.full"}}')
        head = [f"define i32 @{name}({', '.join(arguments)}) nounwind {{", "entry:", *self.slots]
        raised = ["raised:", "  ret i32 1"] if self.failed else []
        end = ["  ret i32 0", *raised, "}"]
        return "\n".join([*tables, *self.declared.values(), *head, *self.lines, *end, *nodes, ""])

    def inlined(self, function: terms.Function, given: Sequence[Any]) -> Any:
        """What a function returns for some values; its text is written here."""
        outer = self.names, self.changing, self.loops, self.result, self.done
        names = [name for name, kind in function.parameters if not isinstance(kind, terms.Known)]
        self.names, self.loops = dict(zip(names, given, strict=True)), []
        self.changing = {name: self.slot(kind) for name, kind in function.locals.items()}
        *first, last = function.body
        if isinstance(last, terms.Return) and len(returns_in(function.body)) == 1:
            self.statements(first)
            if not self.label:  # after what never ends
                self.enter(*self.labels("never"))
            found = self.value(last.value)
        else:
            self.result, (self.done,) = self.slot(function.returns), self.labels("done")
            self.statements(function.body)
            self.branch(self.done)
            self.enter(self.done)
            found = self.loaded(self.result, function.returns)
        self.names, self.changing, self.loops, self.result, self.done = outer
        return found

    # statements

    def statements(self, body: Sequence[terms.Statement]) -> None:
        for one in body:
            if self.label:
                self.statement(one)

    def statement(self, one: terms.Statement) -> None:
        match one:
            case terms.Let(name=name, value=value):
                self.names[name] = self.value(value)
            case terms.Assign(name=name, value=value):
                self.put(self.changing[name], value.type, self.value(value))
            case terms.MemoryStore(memory=memory, index=index, value=value):
                given = self.value(value)
                self.line(f"store {NUMBERS[value.type]} {given}, ptr {self.address(memory, index)}, align 8")
            case terms.Do(call=call):
                self.value(call)
            case terms.Require(condition=condition):
                self.require(self.value(condition))
            case terms.Return(value=value):
                self.returns(value)
            case terms.If(condition=condition, body=body, otherwise=otherwise):
                self.branches(condition, body, otherwise)
            case terms.While(condition=condition, body=body):
                self.repeats(condition, body)
            case terms.For():
                self.counts(one)
            case terms.Break():
                self.branch(self.loops[-1][1])
            case terms.Continue():
                self.branch(self.loops[-1][0])

    def returns(self, value: terms.Expression) -> None:
        self.put(self.result, value.type, self.value(value))
        self.branch(self.done)

    def branches(
        self,
        condition: terms.Expression,
        body: Sequence[terms.Statement],
        otherwise: Sequence[terms.Statement],
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

    def repeats(self, condition: terms.Expression, body: Sequence[terms.Statement]) -> None:
        head, inside, after = self.labels("head", "turn", "after")
        self.branch(head)
        self.enter(head)
        self.choose(self.value(condition), inside, after)
        self.enter(inside)
        self.turn(body, head, after, few=False)
        self.enter(after)

    def counts(self, loop: terms.For) -> None:
        slot, step = self.slot(terms.INT), loop.step.value
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

    def turn(self, body: Sequence[terms.Statement], head: str, after: str, *, few: bool) -> None:
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
        self.few.append(few)
        self.leave(f"br label %{head}, !llvm.loop !{len(self.few)}")


def few_turns(loop: terms.For) -> bool:
    """Whether a loop is known to be short."""
    turns = loop.turns()
    return turns is not None and turns <= FEW


def returns_in(body: Sequence[terms.Statement]) -> list[terms.Return]:
    found = [one for one in body if isinstance(one, terms.Return)]
    return sum((returns_in(inner) for one in body for inner in terms.bodies(one)), found)


def array_constant(name: str, array: NDArray[np.float64]) -> str:
    """The text of an array that is part of the code."""
    numbers = ", ".join(f"double {float_literal(x)}" for x in array.ravel().tolist())
    return f"{name} = private unnamed_addr constant [{array.size} x double] [{numbers}]"
