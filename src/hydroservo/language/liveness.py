"""What of a translation is needed: which functions, which of their arguments and which fields of records.

Laws read few of the machine's parameters, and a design model carries more than one law reads. What nobody
reads is left out of the C, so that each number in its records has an effect.
"""

from collections.abc import Iterator, Sequence

from hydroservo.language.terms import (
    Assign,
    Break,
    Call,
    Choice,
    ConstantArray,
    Continue,
    Conversion,
    Element,
    Expression,
    For,
    Function,
    If,
    Let,
    Make,
    Member,
    Operation,
    Record,
    Return,
    Statement,
    Type,
    Unary,
    Variable,
    While,
)


class Liveness:
    """The least set of functions, arguments, locals and fields that some functions need.

    Args:
        functions: those that are called from outside.
        whole: records all of whose fields are kept.
        given: records of which even there only those fields are kept that are read.
        fields: single fields to be kept.
    """

    def __init__(
        self,
        functions: Sequence[Function],
        whole: Sequence[Record],
        given: Sequence[Record] = (),
        fields: Sequence[tuple[Record, str]] = (),
    ) -> None:
        self.given = given
        self.fields = set(fields)
        self.arguments: set[tuple[Function, str]] = set()
        self.locals: dict[Function, set[str]] = {}
        self.reached: dict[Function, None] = {}
        self.tables: set[ConstantArray] = set()
        for record in whole:
            self.keep(record)
        size = -1
        while size != self.size():  # each round sees more; what is needed only grows
            size = self.size()
            self.reached.clear()
            for function in functions:
                self.visit(function)

    def size(self) -> int:
        return len(self.fields) + len(self.arguments) + sum(map(len, self.locals.values()))

    def keep(self, record: Record) -> None:
        """Keeps all fields of a record and of those in it."""
        for name, kind in record.fields.items():
            if kind not in self.given:
                self.fields.add((record, name))
            if isinstance(kind, Record) and kind not in self.given:
                self.keep(kind)

    def kept(self, kind: Type) -> bool:
        """True for all but a record of which nothing is kept."""
        return not isinstance(kind, Record) or any(self.has(kind, name) for name in kind.fields)

    def has(self, record: Record, name: str) -> bool:
        """True if a field of a record is kept."""
        return (record, name) in self.fields and self.kept(record.fields[name])

    def takes(self, function: Function) -> list[tuple[str, Type]]:
        """The parameters that a function really has."""
        return [
            (name, kind)
            for name, kind in function.parameters
            if (function, name) in self.arguments and self.kept(kind)
        ]

    def visit(self, function: Function) -> None:
        if function in self.reached:
            return
        for callee in function.calls:
            self.visit(callee)
        if function.body:
            self.live(function)
        else:
            for record in function.whole:
                self.keep(record)
            self.arguments |= {(function, name) for name, _ in function.parameters}
        self.reached[function] = None  # after what it calls, so that C sees those first

    def live(self, function: Function) -> None:
        """Finds which locals matter, from the returns backwards."""
        names = self.locals.setdefault(function, set())
        size = -1
        while size != len(names):
            size = len(names)
            names |= set(self.read(function.body, names))
        self.arguments |= {(function, name) for name, _ in function.parameters if name in names}

    def read(self, body: Sequence[Statement], names: set[str]) -> Iterator[str]:
        for one in body:
            if not matters(one, names):
                continue
            match one:
                case Let(value=value) | Assign(value=value) | Return(value=value):
                    yield from self.names(value)
                case If(condition=condition, body=inner, otherwise=otherwise):
                    yield from self.names(condition)
                    yield from self.read(inner, names)
                    yield from self.read(otherwise, names)
                case While(condition=condition, body=inner):
                    yield from self.names(condition)
                    yield from self.read(inner, names)
                case For(start=start, stop=stop, body=inner):
                    for end in (start, stop):
                        if isinstance(end, Expression):
                            yield from self.names(end)
                    yield from self.read(inner, names)

    def names(self, value: Expression) -> Iterator[str]:
        """The locals that a value is made of; fields that it reads are kept from here on."""
        if not self.kept(value.type):
            return
        match value:
            case Variable(name=name):
                yield name
            case Member(base=base, name=name):
                assert isinstance(base.type, Record)
                self.fields.add((base.type, name))
                yield from self.names(base)
            case Call(function=function, arguments=arguments):
                self.visit(function)
                for (name, _), argument in zip(function.parameters, arguments, strict=True):
                    if (function, name) in self.arguments:
                        yield from self.names(argument)
            case Make(values=values):
                assert isinstance(value.type, Record)
                for name, part in values.items():
                    if self.has(value.type, name):
                        yield from self.names(part)
            case Choice(condition=condition, a=a, b=b):
                for part in (condition, a, b):
                    yield from self.names(part)
            case Operation(a=a, b=b):
                yield from self.names(a)
                yield from self.names(b)
            case Unary(a=a) | Conversion(a=a):
                yield from self.names(a)
            case Element(table=table, index=index):
                self.tables.add(table)
                if isinstance(index, Expression):
                    yield from self.names(index)


def matters(statement: Statement, names: set[str]) -> bool:
    """True if a statement returns, or gives a value to a local that matters."""
    match statement:
        case Return() | Break() | Continue():
            return True
        case Let(name=name) | Assign(name=name):
            return name in names
        case If(body=body, otherwise=otherwise):
            return any(matters(one, names) for one in (*body, *otherwise))
        case While(body=body) | For(body=body):
            return any(matters(one, names) for one in body)
    return False
