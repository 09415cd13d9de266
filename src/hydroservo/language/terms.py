"""The terms that a block's method is translated into, before they are printed as C or for LLVM.

Every expression is pure: it has no effect but its value, so what nobody reads can be left out. Memory, and
arrays that are given at run time, are the engine's alone.
"""

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, fields
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Scalar:
    """A number or a truth value."""

    name: str


REAL = Scalar("real")
INT = Scalar("int")
BOOL = Scalar("bool")


@dataclass(eq=False)
class Record:
    """A NamedTuple class whose fields have these types: a struct. ``cls`` is None for several values.

    ``units`` are those of numbers that come and go in others than the class declares.
    """

    cls: type | None
    name: str
    fields: dict[str, "Type"]
    units: Mapping[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, eq=False)
class Known:
    """A whole number, truth value or None that is part of the code: both a value and its own type."""

    value: Any

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Known) and self.key() == other.key()

    def __hash__(self) -> int:
        return hash(self.key())

    def key(self) -> tuple[type, Any]:
        """1 and True are not the same here."""
        return type(self.value), self.value


@dataclass(frozen=True, eq=False)
class ConstantArray:
    """A recorded signal's array, written into the code: both a value and its own type."""

    name: str
    array: NDArray[np.float64]


@dataclass(frozen=True)
class Memory:
    """Numbers of one type from an address on, of which nobody knows the end."""

    element: Scalar


@dataclass(frozen=True)
class Array:
    """An array of floats whose address is given at run time, and those of its lengths that are None here."""

    lengths: tuple[int | None, ...]


Type = Scalar | Record | Known | ConstantArray | Memory | Array
NOTHING = Known(None)  # what a function returns that returns nothing


@dataclass(frozen=True, eq=False)
class HostObject:
    """Something that is there while translating only: a function, a class, a module."""

    thing: Any


@dataclass(frozen=True, eq=False)
class Bound:
    """A method of a record."""

    owner: "Expression"
    function: Any


@dataclass(frozen=True, eq=False)
class Several:
    """Several values, not yet a record; those of zip and its like can be read ``once``."""

    items: tuple[Any, ...]
    names: tuple[str, ...]
    once: bool = False


@dataclass(frozen=True, eq=False)
class Expression:
    """A value at run time."""

    type: Type


@dataclass(frozen=True, eq=False)
class Literal(Expression):
    """A floating-point number."""

    value: float


@dataclass(frozen=True, eq=False)
class Whole(Expression):
    """A whole number or a truth value."""

    value: int


@dataclass(frozen=True, eq=False)
class NamedNumber(Expression):
    """A named number of a module."""

    module: str
    name: str
    value: float


@dataclass(frozen=True, eq=False)
class Variable(Expression):
    """A parameter or local; a mutable one changes."""

    name: str
    mutable: bool = False


@dataclass(frozen=True, eq=False)
class Member(Expression):
    """A field of a record."""

    base: Expression
    name: str


@dataclass(frozen=True, eq=False)
class Element(Expression):
    """An element of a table."""

    table: ConstantArray
    index: Any  # an Expression or Known


@dataclass(frozen=True, eq=False)
class MemoryLoad(Expression):
    """The number at an index of a memory or an array; of an array, counted row by row."""

    memory: Expression
    index: Any  # an Expression or Known


@dataclass(frozen=True, eq=False)
class Length(Expression):
    """The length of an axis of an array."""

    array: Expression
    axis: int


@dataclass(frozen=True, eq=False)
class ArrayView(Expression):
    """The array at an address."""

    address: Expression
    lengths: tuple[Expression, ...]


@dataclass(frozen=True, eq=False)
class Unary(Expression):
    """-a or !a."""

    operator: str
    a: Expression


@dataclass(frozen=True, eq=False)
class Operation(Expression):
    """a op b, C's operator; of truth values, & and | compute both."""

    operator: str
    a: Expression
    b: Expression


@dataclass(frozen=True, eq=False)
class Choice(Expression):
    """a if the condition holds, else b."""

    condition: Expression
    a: Expression
    b: Expression
    both: bool = False  # Python computes both values


@dataclass(frozen=True, eq=False)
class Conversion(Expression):
    """A whole number as a real one, or a real one without what is behind its point."""

    a: Expression


@dataclass(frozen=True, eq=False)
class Call(Expression):
    """A call of a translated function, with all its arguments, read or not, and its text in Python."""

    function: "Function"
    arguments: tuple[Expression, ...]
    text: str = ""


@dataclass(frozen=True, eq=False)
class Computed(Expression):
    """A number that was computed in place of a call, whose text this is."""

    name: str
    value: float
    text: str


@dataclass(frozen=True, eq=False)
class Make(Expression):
    """A record from its fields."""

    values: dict[str, Expression]


@dataclass(eq=False)
class Let:
    """A local that never changes."""

    name: str
    value: Expression


@dataclass(eq=False)
class Assign:
    """A new value for a local that changes."""

    name: str
    value: Expression


@dataclass(eq=False)
class MemoryStore:
    """A new number at an index of a memory."""

    memory: Expression
    index: Any  # an Expression or Known
    value: Expression


@dataclass(eq=False)
class Do:
    """A call for what it does."""

    call: Call


@dataclass(eq=False)
class Require:
    """An exception unless a condition holds."""

    condition: Expression


@dataclass(eq=False)
class Return:
    """The end of a function."""

    value: Expression


@dataclass(eq=False)
class Break:
    """The end of a loop."""


@dataclass(eq=False)
class Continue:
    """The end of a loop's turn."""


@dataclass(eq=False)
class If:
    """Statements under a condition."""

    condition: Expression
    body: list["Statement"]
    otherwise: list["Statement"]


@dataclass(eq=False)
class While:
    """Statements as long as a condition holds."""

    condition: Expression
    body: list["Statement"]


@dataclass(eq=False)
class For:
    """Statements for each whole number from one on, in steps, before another one."""

    name: str
    start: Any  # an Expression or Known, as the others
    stop: Any
    step: Any
    body: list["Statement"]

    def turns(self) -> int | None:
        """How many turns the loop takes; None where its bounds are known at run time alone."""
        bounds = self.start, self.stop, self.step
        if not all(isinstance(bound, Known) for bound in bounds):
            return None
        start, stop, step = (bound.value for bound in bounds)
        return max(0, -int((start - stop) // step))


Statement = Let | Assign | MemoryStore | Do | Require | Return | Break | Continue | If | While | For


@dataclass(eq=False)
class Function:
    """A function for arguments of certain types."""

    name: str  # its own in C
    parameters: list[tuple[str, Type]]  # the name and type of each
    origin: Any = None  # the Python function
    owner: type | None = None  # the class whose method it is
    locals: dict[str, Type] = field(default_factory=dict)  # the type of each local that changes
    # its statements; empty for one whose text is written, not translated
    body: list[Statement] = field(default_factory=list)
    returns: Type = REAL  # the type of its value
    written: Any = None  # what writes the text of a function that is not translated, from what of it is used
    calls: Sequence["Function"] = ()  # the functions that such a function calls
    whole: Sequence[Record] = ()  # the records all of whose numbers such a function reads


def bodies(statement: Statement) -> Iterator[list[Statement]]:
    """The statements in a statement."""
    match statement:
        case If(body=body, otherwise=otherwise):
            yield body
            yield otherwise
        case While(body=body) | For(body=body):
            yield body


def operands(one: Any) -> Iterator[Expression]:
    """The expressions that one is made of."""
    for own in fields(one):
        part = getattr(one, own.name)
        several = part.values() if isinstance(part, dict) else part if isinstance(part, tuple) else (part,)
        yield from (each for each in several if isinstance(each, Expression))


class Translator(Protocol):
    """What one function's translation asks of that of all; the methods are those of ``program.Program``."""

    written: Mapping[Any, Any]

    def record(self, cls: type | None, fields: Mapping[str, Type], name: str) -> Record: ...
    def type_of(self, value: Any, name: str = "") -> Type: ...
    def function(self, origin: Any, arguments: Sequence[Type], owner: type | None = None) -> Function: ...
    def method(self, record: Record, name: str, arguments: Sequence[Type]) -> Function: ...
    def function_name(self, name: str) -> str: ...
    def local_name(self, name: str, taken: Set[str]) -> str: ...
