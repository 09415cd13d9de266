"""Writes translated functions as functions of Structured Text."""

from collections.abc import Callable, Sequence
from itertools import starmap

from hydroservo.export.layout import INDENT
from hydroservo.export.st.expressions import ExpressionWriter, is_simple, opposite
from hydroservo.export.st.pou import Declaration, Pou
from hydroservo.export.st.primitives import NO_ARGUMENT
from hydroservo.export.st.writer import STWriter
from hydroservo.export.translation import first_paragraph
from hydroservo.language import terms
from hydroservo.language.liveness import matters


class FunctionWriter(ExpressionWriter):
    """The statements of one function."""

    def __init__(self, writer: STWriter, function: terms.Function) -> None:
        self.function, self.name = function, writer.function_name(function)
        super().__init__(writer, self.name)
        self.inputs: dict[str, str] = {}  # types by the name written

    def pou(self) -> Pou:
        """The function's definition."""
        function, writer = self.function, self.writer
        for name, kind in writer.needed.takes(function):
            self.inputs[self.new_name(name)] = writer.type(kind)
        live = writer.needed.locals[function]
        for name, kind in function.locals.items():
            if name in live:
                self.variable(name, kind)
        self.statements(function.body, last=True)
        sections = {
            "VAR_INPUT": list(starmap(Declaration, (self.inputs or {NO_ARGUMENT: "BOOL"}).items())),
            "VAR": list(starmap(Declaration, self.locals.items())),
            # last, as one compiler takes all declarations behind them for constants
            "VAR CONSTANT": list(self.constants.values()),
        }
        about = first_paragraph(function.origin)
        return Pou(self.name, writer.type(function.returns), about, sections, self.lines)

    def nested(self, body: Sequence[terms.Statement], last: bool = False) -> None:
        """Statements within others; an empty statement where there are none."""
        self.depth += 1
        self.statements(body, last)
        if not self.live_statements(body):
            self.emit(";")
        self.depth -= 1

    def statements(self, body: Sequence[terms.Statement], last: bool = False) -> None:
        """Statements; the function ends behind the last of them where they are its own."""
        live = self.live_statements(body)
        for one in live:
            self.statement(one, last and one is live[-1])

    def live_statements(self, body: Sequence[terms.Statement]) -> list[terms.Statement]:
        live = self.writer.needed.locals[self.function]
        return [one for one in body if matters(one, live)]

    def statement(self, one: terms.Statement, last: bool) -> None:
        match one:
            case terms.Let(name=name, value=value):
                self.assign(self.variable(name, value.type), value, fresh=True)
            case terms.Assign(name=name, value=value):
                self.assign(self.names[name], value)
            case terms.Return(value=value):
                self.return_statement(value, last)
            case terms.If():
                self.if_statement(one, last)
            case terms.While(condition=condition, body=body):
                self.while_loop(condition, body)
            case terms.For():
                self.for_loop(one)
            case terms.Break():
                self.emit("EXIT;")
            case terms.Continue():
                self.emit("CONTINUE;")
            case _:
                raise AssertionError(one)

    def return_statement(self, value: terms.Expression, last: bool) -> None:
        """The value of a function, and its end where more follows."""
        if isinstance(value, terms.Choice):
            self.choice(value, lambda one: self.return_statement(one, last))
            return
        text = self.record_variable(value, "answer") if isinstance(value, terms.Make) else self.value(value)
        self.emit(f"{self.name} := {text};")
        if not last:
            self.emit("RETURN;")

    def if_statement(self, one: terms.If, last: bool, word: str = "IF") -> None:
        """Statements under conditions; one alone in an ELSE makes it ELSIF."""
        self.emit(f"{word} {self.value(one.condition)} THEN")
        self.nested(one.body, last)
        match self.live_statements(one.otherwise):
            case [terms.If() as only] if is_simple(only.condition):
                self.if_statement(only, last, "ELSIF")
                return
            case [_, *_]:
                self.emit("ELSE")
                self.nested(one.otherwise, last)
        self.emit("END_IF;")

    def while_loop(self, condition: terms.Expression, body: Sequence[terms.Statement]) -> None:
        """A loop; the statements that its condition takes are done again at each turn."""
        if is_simple(condition):
            self.emit(f"WHILE {self.value(condition)} DO")
        else:
            self.emit("WHILE TRUE DO")
            self.depth += 1
            self.emit(f"IF {self.value(opposite(condition))} THEN")
            self.emit(f"{INDENT}EXIT;")
            self.emit("END_IF;")
            self.depth -= 1
        self.nested(body)
        self.emit("END_WHILE;")

    def for_loop(self, loop: terms.For) -> None:
        """A loop over whole numbers, whose end is part of it."""
        name, by = self.variable(loop.name, terms.INT), loop.step.value
        last = 1 if by > 0 else -1
        stop = (
            f"{self.operand(loop.stop, 0)} - ({last})"
            if isinstance(loop.stop, terms.Expression)
            else str(loop.stop.value - last)
        )
        start = self.value(loop.start) if isinstance(loop.start, terms.Expression) else str(loop.start.value)
        self.emit(f"FOR {name} := {start} TO {stop}{'' if by == 1 else f' BY {by}'} DO")
        self.nested(loop.body)
        self.emit("END_FOR;")

    def assign(self, target: str, value: terms.Expression, fresh: bool = False) -> None:
        """A value for a variable; nothing of it reads one that is fresh."""
        if isinstance(value, terms.Choice):
            self.choice(value, lambda one: self.assign(target, one, fresh))
        elif isinstance(value, terms.Make) and fresh:
            self.fill(target, value)
        else:
            self.emit(f"{target} := {self.value(value)};")

    def choice(self, value: terms.Choice, use: Callable[[terms.Expression], None]) -> None:
        """One of several values, of which only that one is computed."""
        word = "IF"
        other: terms.Expression = value
        while isinstance(other, terms.Choice) and (word == "IF" or is_simple(other.condition)):
            self.emit(f"{word} {self.value(other.condition)} THEN")
            self.depth += 1
            use(other.a)
            self.depth -= 1
            word, other = "ELSIF", other.b
        self.emit("ELSE")
        self.depth += 1
        use(other)
        self.depth -= 1
        self.emit("END_IF;")
