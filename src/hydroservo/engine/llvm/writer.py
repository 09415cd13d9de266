"""Writes translated functions as LLVM's text.

Each is a function of its own, which LLVM puts in the place of its calls. Records are passed by value; a local
that changes stands in memory of the stack, from which LLVM takes it.
"""

import struct
from collections.abc import Callable, Sequence
from typing import Any

from hydroservo.language.arithmetic import MODULO, QUOTIENT
from hydroservo.language.terms import (
    BOOL,
    INT,
    NOTHING,
    REAL,
    Array,
    Assign,
    Break,
    Call,
    Choice,
    Constant,
    Continue,
    Conversion,
    Do,
    Element,
    Expression,
    For,
    Function,
    If,
    Known,
    Length,
    Let,
    Literal,
    Load,
    Make,
    Member,
    Memory,
    Operation,
    Record,
    Require,
    Return,
    Statement,
    Store,
    Table,
    Type,
    Unary,
    Variable,
    View,
    While,
    Whole,
)

NUMBERS = {REAL: "double", INT: "i64", BOOL: "i1"}
FLOATS = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
WHOLES = {"+": "add", "-": "sub", "*": "mul", "&": "and", "|": "or", "^": "xor", "<<": "shl", ">>": "ashr"}
COMPARED = {"<": "lt", "<=": "le", ">": "gt", ">=": "ge", "==": "eq", "!=": "ne"}
FEW = 16  # turns of a loop that is unrolled, for loops over lanes hold no others


class Module:
    """The text of functions, of the types that they use and of the tables that they read."""

    def __init__(self) -> None:
        self.functions: dict[Function, str] = {}
        self.records: dict[Record, str] = {}
        self.types: list[str] = []
        self.tables: dict[Table, str] = {}
        self.declared: dict[str, str] = {}
        self.few: list[bool] = []  # of each loop, whether it has few turns
        self.failing: dict[Function, bool] = {}

    def type(self, kind: Type) -> str:
        """LLVM's name of a type."""
        if isinstance(kind, Record):
            if kind not in self.records:
                inner = ", ".join(self.type(part) for part in fields_of(kind).values())
                self.records[kind] = f"%r{len(self.records)}"
                self.types.append(f"{self.records[kind]} = type {{{inner}}}")
            return self.records[kind]
        if isinstance(kind, Array):
            return f"{{{', '.join(['ptr', *['i64'] * len(kind.lengths)])}}}"
        if kind == NOTHING:
            return "void"
        return "ptr" if isinstance(kind, Memory) else NUMBERS[kind]  # type: ignore[index]

    def table(self, table: Table) -> str:
        """The name of a table that is written into the text."""
        if table not in self.tables:
            self.tables[table] = f"@t{len(self.tables)}"
        return self.tables[table]

    def name(self, function: Function) -> str:
        """The name of a function, whose text is written if it is not there yet."""
        if function not in self.functions:
            self.functions[function] = ""
            self.functions[function] = Body(self, function).text()
        return f"@f.{function.name}"

    def fails(self, function: Function) -> bool:
        """Whether a function may raise an exception."""
        if function not in self.failing:
            self.failing[function] = any(map(self.may_fail, function.body))
        return self.failing[function]

    def may_fail(self, one: Any) -> bool:
        """Whether a statement or an expression may raise an exception."""
        if isinstance(one, Require):
            return True
        if isinstance(one, Call) and self.fails(one.function):
            return True
        return any(map(self.may_fail, parts_of(one)))

    def declare(self, name: str, returned: str, *taken: str) -> str:
        """The name of a function of LLVM or of the C library."""
        self.declared[name] = f"declare {returned} @{name}({', '.join(taken)})"
        return f"@{name}"

    def text(self, entry: str) -> str:
        """All of it, with the function that is called from outside."""
        tables = [
            f"{name} = private unnamed_addr constant [{table.array.size} x double] "
            f"[{', '.join(f'double {literal(x)}' for x in table.array.ravel().tolist())}]"
            for table, name in self.tables.items()
        ]
        unrolled = len(self.few) + 1
        nodes = [f"!{i} = distinct !{{!{i}, !{unrolled if few else 0}}}" for i, few in enumerate(self.few, 1)]
        nodes.append(f'!{unrolled} = !{{!"llvm.loop.unroll.full"}}')
        parts = [*self.types, *tables, *self.declared.values(), *self.functions.values(), entry, *nodes]
        return "\n".join(parts) + "\n"


class Body:
    """The text of one function.

    Attributes:
        module: the text that it is part of.
        label: of the block that is written; "" after one that was left.
    """

    def __init__(self, module: Module, function: Function | None = None) -> None:
        self.module, self.function = module, function
        self.lines: list[str] = []
        self.slots: list[str] = []
        self.count = 0
        self.label = "entry"
        self.names: dict[str, Any] = {}
        self.changing: dict[str, Any] = {}
        self.loops: list[tuple[str, str]] = []  # where a turn and the loop end
        self.result: Any = None  # where a record is put that is returned at several places
        self.fails = function is not None and module.fails(function)
        self.failed = False

    def text(self) -> str:
        function, module = self.function, self.module
        assert function is not None
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

    # blocks and lines

    def fresh(self) -> str:
        self.count += 1
        return f"%v{self.count}"

    def line(self, text: str) -> None:
        self.lines.append(f"  {text}")

    def emit(self, text: str) -> str:
        """A new value by an instruction."""
        found = self.fresh()
        self.lines.append(f"  {found} = {text}")
        return found

    def slot(self, kind: Type) -> Any:
        """Memory of the stack for a value; of a record, for each of its numbers."""
        if isinstance(kind, Record):
            return [self.slot(part) for part in fields_of(kind).values()]
        found = self.fresh()
        self.slots.append(f"  {found} = alloca {self.module.type(kind)}")
        return found

    def put(self, slot: Any, kind: Type, value: str) -> None:
        """A new value for what stands in memory of the stack."""
        own = self.module.type(kind)
        if not isinstance(kind, Record):
            self.line(f"store {own} {value}, ptr {slot}")
            return
        for i, part in enumerate(fields_of(kind).values()):
            self.put(slot[i], part, self.emit(f"extractvalue {own} {value}, {i}"))

    def taken(self, slot: Any, kind: Type) -> str:
        """The value that stands in memory of the stack."""
        if not isinstance(kind, Record):
            return self.emit(f"load {self.module.type(kind)}, ptr {slot}")
        parts = zip(slot, fields_of(kind).values(), strict=True)
        return self.made(kind, [self.taken(*part) for part in parts])

    def labels(self, *names: str) -> list[str]:
        """New labels of blocks."""
        self.count += 1
        return [f"{name}{self.count}" for name in names]

    def enter(self, label: str) -> None:
        """Goes on in a new block."""
        self.lines.append(f"{label}:")
        self.label = label

    def leave(self, text: str) -> None:
        """The last line of a block."""
        self.line(text)
        self.label = ""

    def branch(self, label: str) -> None:
        """Leaves this block for another one, if it is not left yet."""
        if self.label:
            self.leave(f"br label %{label}")

    def choose(self, condition: str, then: str, otherwise: str) -> None:
        """Leaves this block for one of two."""
        self.leave(f"br i1 {condition}, label %{then}, label %{otherwise}")

    def require(self, condition: str) -> None:
        """Leaves the function unless a condition holds."""
        (further,) = self.labels("so")
        self.failed = True
        self.choose(condition, further, "raised")
        self.enter(further)

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

    # expressions

    def index(self, value: Any) -> str:
        """A whole number, known or not."""
        return str(int(value.value)) if isinstance(value, Known) else str(self.value(value))

    def value(self, value: Expression) -> str:
        """The name of an expression's value."""
        match value:
            case Literal(value=number) | Constant(value=number):
                return literal(number)
            case Whole(value=whole):
                return str(int(whole)) if value.type != BOOL else str(bool(whole)).lower()
            case Variable(name=name):
                if name in self.changing:
                    return self.taken(self.changing[name], value.type)
                return str(self.names[name])
            case Member(base=base, name=name):
                place = list(fields_of(base.type)).index(name)  # type: ignore[arg-type]
                return self.emit(f"extractvalue {self.module.type(base.type)} {self.value(base)}, {place}")
            case Make(values=values):
                kept = {name: self.value(values[name]) for name in fields_of(value.type)}  # type: ignore[arg-type]
                return self.made(value.type, list(kept.values()))  # type: ignore[arg-type]
            case Unary(operator=sign, a=a):
                return self.unary(sign, a)
            case Operation(operator=sign, a=a, b=b):
                return self.operation(sign, a, b)
            case Conversion(a=a):
                word = "sitofp i64" if value.type == REAL else "fptosi double"
                return self.emit(f"{word} {self.value(a)} to {self.module.type(value.type)}")
            case Choice():
                return self.choice(value)
            case Call(function=function, arguments=arguments):
                return self.call(function, arguments)
        return self.in_memory(value)

    def in_memory(self, value: Expression) -> str:
        """A number of a memory, an array or a table, or an array itself."""
        match value:
            case Element(table=table, index=index):
                place = self.index(index)
                at = f"getelementptr double, ptr {self.module.table(table)}, i64 {place}"
                return self.emit(f"load double, ptr {self.emit(at)}, align 8")
            case Load(memory=memory, index=index):
                return self.emit(f"load {NUMBERS[value.type]}, ptr {self.address(memory, index)}, align 8")  # type: ignore[index]
            case Length(array=array, axis=axis):
                return self.emit(
                    f"extractvalue {self.module.type(array.type)} {self.value(array)}, {axis + 1}"
                )
            case View(address=address, lengths=lengths):
                pointer = self.emit(f"inttoptr i64 {self.value(address)} to ptr")
                found, kind = "poison", self.module.type(value.type)
                for i, (word, part) in enumerate(
                    [("ptr", pointer), *(("i64", self.value(one)) for one in lengths)]
                ):
                    found = self.emit(f"insertvalue {kind} {found}, {word} {part}, {i}")
                return found
        raise AssertionError(value)

    def address(self, memory: Expression, index: Any) -> str:
        """Where the number at an index is."""
        kind = memory.type
        start, word = self.value(memory), "double"
        if isinstance(kind, Array):
            start = self.emit(f"extractvalue {self.module.type(kind)} {start}, 0")
        elif isinstance(kind, Memory):
            word = NUMBERS[kind.element]
        return self.emit(f"getelementptr {word}, ptr {start}, i64 {self.index(index)}")

    def made(self, record: Record, values: Sequence[str]) -> str:
        """A record from its fields."""
        found, own = "zeroinitializer", self.module.type(record)
        for i, (kind, value) in enumerate(zip(fields_of(record).values(), values, strict=True)):
            found = self.emit(f"insertvalue {own} {found}, {self.module.type(kind)} {value}, {i}")
        return found

    def unary(self, sign: str, a: Expression) -> str:
        value = self.value(a)
        if sign == "!":
            return self.emit(f"xor i1 {value}, true")
        return self.emit(f"fneg double {value}" if a.type == REAL else f"sub i64 0, {value}")

    def operation(self, sign: str, a: Expression, b: Expression) -> str:
        if sign in ("&&", "||"):
            return self.logic(sign, a, b)
        kind, real = self.module.type(a.type), a.type == REAL
        x, y = self.value(a), self.value(b)
        if sign in COMPARED:
            if real:
                return self.emit(f"fcmp {'u' if sign == '!=' else 'o'}{COMPARED[sign]} double {x}, {y}")
            ordered = "" if sign in ("==", "!=") else "s"
            return self.emit(f"icmp {ordered}{COMPARED[sign]} {kind} {x}, {y}")
        return self.emit(f"{FLOATS[sign] if real else WHOLES[sign]} {kind} {x}, {y}")

    def logic(self, sign: str, a: Expression, b: Expression) -> str:
        """Two truth values joined, the second of which is computed only if the first does not decide."""
        first = self.value(a)
        if is_there(b):
            return self.emit(f"{'and' if sign == '&&' else 'or'} i1 {first}, {self.value(b)}")
        further, after = self.labels("also", "after")
        start = self.label
        self.choose(first, *((further, after) if sign == "&&" else (after, further)))
        self.enter(further)
        second = self.value(b)
        end = self.label
        self.branch(after)
        self.enter(after)
        return self.emit(f"phi i1 [ {str(sign == '||').lower()}, %{start} ], [ {second}, %{end} ]")

    def choice(self, value: Choice) -> str:
        """One of two values, of which only that one is computed where Python computes only that."""
        condition = self.value(value.condition)
        if value.both or (is_there(value.a) and is_there(value.b)):
            return self.selected(condition, value.type, self.value(value.a), self.value(value.b))
        then, other, after = self.labels("then", "else", "after")
        slot = self.slot(value.type)
        self.choose(condition, then, other)
        for label, way in ((then, value.a), (other, value.b)):
            self.enter(label)
            self.put(slot, value.type, self.value(way))
            self.branch(after)
        self.enter(after)
        return self.taken(slot, value.type)

    def selected(self, condition: str, kind: Type, a: str, b: str) -> str:
        """One of two values without a branch, number by number."""
        own = self.module.type(kind)
        if not isinstance(kind, Record):
            return self.emit(f"select i1 {condition}, {own} {a}, {own} {b}")
        parts = []
        for i, part in enumerate(fields_of(kind).values()):
            x, y = (self.emit(f"extractvalue {own} {one}, {i}") for one in (a, b))
            parts.append(self.selected(condition, part, x, y))
        return self.made(kind, parts)

    def call(self, function: Function, arguments: Sequence[Expression]) -> str:
        given = [self.value(one) for one in arguments]
        if function in WHOLE_DIVISIONS:
            return WHOLE_DIVISIONS[function](self, *given)
        if not function.body:
            return str(function.written(self, *given))
        pairs = zip(arguments, given, strict=True)
        words = [f"{self.module.type(one.type)} {value}" for one, value in pairs]
        name, kind, fails = (
            self.module.name(function),
            self.module.type(function.returns),
            self.module.fails(function),
        )
        call = f"call {kind} {name}({', '.join([*words, *['ptr %failed'] * fails])})"
        found = ""
        if kind == "void":
            self.line(call)
        else:
            found = self.emit(call)
        if fails:
            self.require(self.emit(f"xor i1 {self.emit('load i1, ptr %failed')}, true"))
        return found


def quotient(w: Body, a: str, b: str) -> str:
    """floor(a/b) of whole numbers; 0 where b is 0."""
    zero, _, ratio, _, below = division(w, a, b)
    less = w.emit(f"sext i1 {below} to i64")
    return w.emit(f"select i1 {zero}, i64 0, i64 {w.emit(f'add i64 {ratio}, {less}')}")


def modulo(w: Body, a: str, b: str) -> str:
    """a - b floor(a/b) of whole numbers; 0 where b is 0."""
    zero, divisor, _, rest, below = division(w, a, b)
    more = w.emit(f"select i1 {below}, i64 {divisor}, i64 0")
    return w.emit(f"select i1 {zero}, i64 0, i64 {w.emit(f'add i64 {rest}, {more}')}")


def division(w: Body, a: str, b: str) -> tuple[str, str, str, str, str]:
    """Whether b is 0, b or 1 then, quotient and rest towards 0, and whether the floor is below."""
    zero = w.emit(f"icmp eq i64 {b}, 0")
    divisor = w.emit(f"select i1 {zero}, i64 1, i64 {b}")
    ratio, rest = w.emit(f"sdiv i64 {a}, {divisor}"), w.emit(f"srem i64 {a}, {divisor}")
    uneven = w.emit(f"icmp ne i64 {rest}, 0")
    apart = w.emit(f"icmp slt i64 {w.emit(f'xor i64 {rest}, {divisor}')}, 0")
    return zero, divisor, ratio, rest, w.emit(f"and i1 {uneven}, {apart}")


WHOLE_DIVISIONS: dict[Function, Callable[..., str]] = {QUOTIENT: quotient, MODULO: modulo}


def fields_of(record: Record) -> dict[str, Type]:
    """The fields of a record that it has at run time."""
    return {name: kind for name, kind in record.fields.items() if not isinstance(kind, Known | Table)}


def is_there(value: Expression) -> bool:
    """Whether a value takes no work."""
    while isinstance(value, Member):
        value = value.base
    return isinstance(value, Variable | Literal | Constant | Whole)


def few_turns(loop: For) -> bool:
    """Whether a loop is known to be short."""
    bounds = (loop.start, loop.stop, loop.step)
    return all(isinstance(one, Known) for one in bounds) and len(range(*(one.value for one in bounds))) <= FEW


def literal(number: float) -> str:
    """A float to its last bit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', number))[0]:016X}"


def returns_in(body: Sequence[Statement]) -> list[Return]:
    """The returns in some statements."""
    inner = [one for statement in body for one in parts_of(statement) if isinstance(one, Statement)]
    return [one for one in body if isinstance(one, Return)] + (returns_in(inner) if inner else [])


def parts_of(one: Any) -> list[Any]:
    """The statements and expressions that a statement or an expression is made of."""
    parts: list[Any] = []
    for part in vars(one).values():
        each = (
            part.values() if isinstance(part, dict) else part if isinstance(part, list | tuple) else (part,)
        )
        parts += [value for value in each if isinstance(value, Expression | Statement)]
    return parts
