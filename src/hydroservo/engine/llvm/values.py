"""Writes the expressions of functions as LLVM's instructions."""

import struct
from collections.abc import Sequence
from typing import Any

from hydroservo.language import terms

NUMBERS: dict[terms.Type, str] = {terms.REAL: "double", terms.INT: "i64", terms.BOOL: "i1"}
FLOATS = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
WHOLES = {"+": "add", "-": "sub", "*": "mul", "&": "and", "|": "or", "^": "xor", "<<": "shl", ">>": "ashr"}
COMPARED = {"<": "lt", "<=": "le", ">": "gt", ">=": "ge", "==": "eq", "!=": "ne"}


class FunctionValues:
    """The blocks of one LLVM function, and the values in them.

    The value of a number is its name; that of a record or an array a list, of its fields' values or its
    address and lengths.
    """

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.slots: list[str] = []
        self.count = 0
        self.label = "entry"  # of the block that is written; "" after one that was left
        self.failed = False  # whether something raises an exception
        self.names: dict[str, Any] = {}  # what each name of the function that is written stands for
        self.changing: dict[str, Any] = {}  # where its locals that change stand in memory of the stack
        self.declared: dict[str, str] = {}
        self.tables: dict[terms.ConstantArray, str] = {}
        self.few: list[bool] = []  # of each loop, whether it has few turns

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

    def slot(self, kind: terms.Type) -> Any:
        """Memory of the stack for a value; of a record, for each of its numbers."""
        if isinstance(kind, terms.Record):
            return [self.slot(part) for part in runtime_fields(kind).values()]
        if kind not in NUMBERS:
            return None
        found = self.fresh()
        self.slots.append(f"  {found} = alloca {NUMBERS[kind]}")
        return found

    def put(self, slot: Any, kind: terms.Type, value: Any) -> None:
        """A new value for what stands in memory of the stack."""
        if isinstance(kind, terms.Record):
            for part in zip(slot, runtime_fields(kind).values(), value, strict=True):
                self.put(*part)
        elif kind in NUMBERS:
            self.line(f"store {NUMBERS[kind]} {value}, ptr {slot}")

    def loaded(self, slot: Any, kind: terms.Type) -> Any:
        """The value that stands in memory of the stack."""
        if isinstance(kind, terms.Record):
            return [self.loaded(*part) for part in zip(slot, runtime_fields(kind).values(), strict=True)]
        return self.emit(f"load {NUMBERS[kind]}, ptr {slot}") if kind in NUMBERS else ""

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
        """Leaves the function with an exception unless a condition holds."""
        (further,) = self.labels("so")
        self.failed = True
        self.choose(condition, further, "raised")
        self.enter(further)

    def declare(self, name: str, returned: str, *taken: str) -> str:
        """The name of a function of LLVM."""
        self.declared[name] = f"declare {returned} @{name}({', '.join(taken)})"
        return f"@{name}"

    # expressions

    def index(self, value: Any) -> str:
        """A whole number, known or not."""
        return str(int(value.value)) if isinstance(value, terms.Known) else str(self.value(value))

    def place(self, value: terms.Expression) -> Any:
        """Where a value stands in memory of the stack; None where it does not."""
        if isinstance(value, terms.Variable):
            return self.changing.get(value.name)
        if isinstance(value, terms.Member) and (base := self.place(value.base)) is not None:
            return base[index_of(value)]
        return None

    def value(self, value: terms.Expression) -> Any:
        """An expression's value."""
        if (place := self.place(value)) is not None:
            return self.loaded(place, value.type)
        match value:
            case terms.Literal(value=number) | terms.NamedNumber(value=number):
                return float_literal(number)
            case terms.Whole(value=whole):
                return str(int(whole)) if value.type != terms.BOOL else str(bool(whole)).lower()
            case terms.Variable(name=name):
                return self.names[name]
            case terms.Member(base=base):
                return self.value(base)[index_of(value)]
            case terms.Make(values=values):
                return [self.value(values[name]) for name in runtime_fields(value.type)]  # type: ignore[arg-type]
            case terms.Unary(operator=sign, a=a):
                return self.unary(sign, a)
            case terms.Operation(operator=sign, a=a, b=b):
                return self.operation(sign, a, b)
            case terms.Conversion(a=a):
                word = "sitofp i64" if value.type == terms.REAL else "fptosi double"
                return self.emit(f"{word} {self.value(a)} to {NUMBERS[value.type]}")
            case terms.Choice():
                return self.choice(value)
            case terms.Call(function=function, arguments=arguments):
                return self.call(function, arguments)
        return self.in_memory(value)

    def in_memory(self, value: terms.Expression) -> Any:
        """A number of a memory, an array or a table, or an array itself."""
        match value:
            case terms.Element(table=table, index=index):
                name = self.tables.setdefault(table, f"@t{len(self.tables)}")
                at = f"getelementptr double, ptr {name}, i64 {self.index(index)}"
                return self.emit(f"load double, ptr {self.emit(at)}, align 8")
            case terms.MemoryLoad(memory=memory, index=index):
                return self.emit(f"load {NUMBERS[value.type]}, ptr {self.address(memory, index)}, align 8")
            case terms.Length(array=array, axis=axis):
                return self.value(array)[axis + 1]
            case terms.ArrayView(address=address, lengths=lengths):
                return [self.emit(f"inttoptr i64 {self.value(address)} to ptr"), *map(self.value, lengths)]
        raise AssertionError(value)

    def address(self, memory: terms.Expression, index: Any) -> str:
        """Where the number at an index is."""
        start = self.value(memory)
        if isinstance(memory.type, terms.Array):
            start, word = start[0], "double"
        else:
            assert isinstance(memory.type, terms.Memory)
            word = NUMBERS[memory.type.element]
        return self.emit(f"getelementptr {word}, ptr {start}, i64 {self.index(index)}")

    def unary(self, sign: str, a: terms.Expression) -> str:
        value = self.value(a)
        if sign == "!":
            return self.emit(f"xor i1 {value}, true")
        return self.emit(f"fneg double {value}" if a.type == terms.REAL else f"sub i64 0, {value}")

    def operation(self, sign: str, a: terms.Expression, b: terms.Expression) -> str:
        if sign in ("&&", "||"):
            return self.logic(sign, a, b)
        kind, real = NUMBERS[a.type], a.type == terms.REAL
        x, y = self.value(a), self.value(b)
        if sign in COMPARED:
            if real:
                return self.emit(f"fcmp {'u' if sign == '!=' else 'o'}{COMPARED[sign]} double {x}, {y}")
            ordered = "" if sign in ("==", "!=") else "s"
            return self.emit(f"icmp {ordered}{COMPARED[sign]} {kind} {x}, {y}")
        return self.emit(f"{FLOATS[sign] if real else WHOLES[sign]} {kind} {x}, {y}")

    def logic(self, sign: str, a: terms.Expression, b: terms.Expression) -> str:
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

    def choice(self, value: terms.Choice) -> Any:
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
        return self.loaded(slot, value.type)

    def selected(self, condition: str, kind: terms.Type, a: Any, b: Any) -> Any:
        """One of two values without a branch, number by number."""
        if not isinstance(kind, terms.Record):
            return self.emit(f"select i1 {condition}, {NUMBERS[kind]} {a}, {NUMBERS[kind]} {b}")
        parts = zip(runtime_fields(kind).values(), a, b, strict=True)
        return [self.selected(condition, *part) for part in parts]

    def call(self, function: terms.Function, arguments: Sequence[terms.Expression]) -> Any:
        given = [self.value(one) for one in arguments]
        if not function.body:
            return function.written(self, *given)
        return self.inlined(function, given)

    def inlined(self, function: terms.Function, given: Sequence[Any]) -> Any:
        """What a function returns for some values; its text is written here."""
        raise NotImplementedError


def index_of(member: terms.Member) -> int:
    """Where a field stands among those of its record."""
    assert isinstance(member.base.type, terms.Record)
    return list(runtime_fields(member.base.type)).index(member.name)


def is_there(value: terms.Expression) -> bool:
    """Whether a value takes no work."""
    while isinstance(value, terms.Member):
        value = value.base
    return isinstance(value, terms.Variable | terms.Literal | terms.NamedNumber | terms.Whole)


def runtime_fields(record: terms.Record) -> dict[str, terms.Type]:
    """The fields of a record that it has at run time."""
    return {
        name: kind
        for name, kind in record.fields.items()
        if not isinstance(kind, terms.Known | terms.ConstantArray)
    }


def float_literal(number: float) -> str:
    """A float to its last bit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', number))[0]:016X}"
