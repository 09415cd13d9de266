"""Writes the expressions of a function as instructions."""

from collections.abc import Callable, Sequence
from typing import Any

from hydroservo.engine.llvm.module import NUMBERS, Module, fields_of, literal
from hydroservo.language.arithmetic import MODULO, QUOTIENT
from hydroservo.language.terms import (
    BOOL,
    REAL,
    Array,
    Call,
    Choice,
    Constant,
    Conversion,
    Element,
    Expression,
    Function,
    Known,
    Length,
    Literal,
    Load,
    Make,
    Member,
    Memory,
    Operation,
    Record,
    Type,
    Unary,
    Variable,
    View,
    Whole,
)

FLOATS = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
WHOLES = {"+": "add", "-": "sub", "*": "mul", "&": "and", "|": "or", "^": "xor", "<<": "shl", ">>": "ashr"}
COMPARED = {"<": "lt", "<=": "le", ">": "gt", ">=": "ge", "==": "eq", "!=": "ne"}


class Values:
    """The blocks of a function, and the values in them.

    Attributes:
        module: the text that it is part of.
        label: of the block that is written; "" after one that was left.
        failed: whether something in it raises an exception.
    """

    def __init__(self, module: Module) -> None:
        self.module = module
        self.lines: list[str] = []
        self.slots: list[str] = []
        self.count = 0
        self.label = "entry"
        self.names: dict[str, Any] = {}
        self.changing: dict[str, Any] = {}
        self.failed = False

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


def quotient(w: Values, a: str, b: str) -> str:
    """floor(a/b) of whole numbers; 0 where b is 0."""
    zero, _, ratio, _, below = division(w, a, b)
    less = w.emit(f"sext i1 {below} to i64")
    return w.emit(f"select i1 {zero}, i64 0, i64 {w.emit(f'add i64 {ratio}, {less}')}")


def modulo(w: Values, a: str, b: str) -> str:
    """a - b floor(a/b) of whole numbers; 0 where b is 0."""
    zero, divisor, _, rest, below = division(w, a, b)
    more = w.emit(f"select i1 {below}, i64 {divisor}, i64 0")
    return w.emit(f"select i1 {zero}, i64 0, i64 {w.emit(f'add i64 {rest}, {more}')}")


def division(w: Values, a: str, b: str) -> tuple[str, str, str, str, str]:
    """Whether b is 0, b or 1 then, quotient and rest towards 0, and whether the floor is below."""
    zero = w.emit(f"icmp eq i64 {b}, 0")
    divisor = w.emit(f"select i1 {zero}, i64 1, i64 {b}")
    ratio, rest = w.emit(f"sdiv i64 {a}, {divisor}"), w.emit(f"srem i64 {a}, {divisor}")
    uneven = w.emit(f"icmp ne i64 {rest}, 0")
    apart = w.emit(f"icmp slt i64 {w.emit(f'xor i64 {rest}, {divisor}')}, 0")
    return zero, divisor, ratio, rest, w.emit(f"and i1 {uneven}, {apart}")


WHOLE_DIVISIONS: dict[Function, Callable[..., str]] = {QUOTIENT: quotient, MODULO: modulo}


def is_there(value: Expression) -> bool:
    """Whether a value takes no work."""
    while isinstance(value, Member):
        value = value.base
    return isinstance(value, Variable | Literal | Constant | Whole)
