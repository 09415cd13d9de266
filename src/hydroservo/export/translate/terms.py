"""The terms that a block's method is translated into, before they are printed as C.

Every expression is pure: it has no effect but its value, so what nobody reads can be left out.
"""

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field
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
    """A whole number or truth value that is part of the code: both a value and its own type."""

    value: int

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Known) and self.key() == other.key()

    def __hash__(self) -> int:
        return hash(self.key())

    def key(self) -> tuple[type, int]:
        """1 and True are not the same here."""
        return type(self.value), self.value


@dataclass(frozen=True, eq=False)
class Table:
    """A recorded signal's array, written into the code: both a value and its own type."""

    name: str
    array: NDArray[np.float64]


@dataclass(frozen=True)
class Matrix:
    """The split matrix of a linear system of so many equations."""

    size: int


Type = Scalar | Record | Known | Table | Matrix


@dataclass(frozen=True, eq=False)
class Python:
    """Something that is there while translating only: a function, a class, a module."""

    thing: Any


@dataclass(frozen=True, eq=False)
class Bound:
    """A method of a record."""

    owner: "Expression"
    function: Any


@dataclass(frozen=True, eq=False)
class Several:
    """Several values, not yet a record."""

    items: tuple[Any, ...]
    names: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Expression:
    """A value in C."""

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
class Constant(Expression):
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

    table: Table
    index: Any  # an Expression or Known


@dataclass(frozen=True, eq=False)
class Unary(Expression):
    """-a or !a."""

    operator: str
    a: Expression


@dataclass(frozen=True, eq=False)
class Operation(Expression):
    """a op b, C's operator."""

    operator: str
    a: Expression
    b: Expression


@dataclass(frozen=True, eq=False)
class Choice(Expression):
    """a if the condition holds, else b."""

    condition: Expression
    a: Expression
    b: Expression


@dataclass(frozen=True, eq=False)
class Conversion(Expression):
    """A whole number as a real one."""

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
class Return:
    """The end of a function."""

    value: Expression


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
    """Statements for each whole number from 0 to count - 1."""

    name: str
    count: Any  # an Expression or Known
    body: list["Statement"]


Statement = Let | Assign | Return | If | While | For


@dataclass(eq=False)
class Function:
    """A function in C.

    Attributes:
        name: in C.
        parameters: the name and type of each.
        origin: the Python function.
        owner: the class whose method it is.
        locals: the type of each local that changes.
        body: its statements; empty for one whose text is written, not translated.
        returns: the type of its value.
        written: what writes the text of a function that is not translated, from what of it is used.
        calls: the functions that such a function calls.
        whole: the records all of whose numbers such a function reads.
    """

    name: str
    parameters: list[tuple[str, Type]]
    origin: Any = None
    owner: type | None = None
    locals: dict[str, Type] = field(default_factory=dict)
    body: list[Statement] = field(default_factory=list)
    returns: Type = REAL
    written: Any = None
    calls: Sequence["Function"] = ()
    whole: Sequence[Record] = ()


class Translator(Protocol):
    """What one function's translation asks of that of all; the methods are those of ``program.Program``."""

    written: Mapping[Any, Any]

    def record(self, cls: type | None, fields: Mapping[str, Type], name: str) -> Record: ...
    def type_of(self, value: Any, name: str = "") -> Type: ...
    def function(self, origin: Any, arguments: Sequence[Type], owner: type | None = None) -> Function: ...
    def method(self, record: Record, name: str, arguments: Sequence[Type]) -> Function: ...
    def function_name(self, name: str) -> str: ...
    def local_name(self, name: str, taken: Set[str]) -> str: ...
