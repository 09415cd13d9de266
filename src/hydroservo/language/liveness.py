"""What of a translation is needed: which functions, which of their arguments and which fields of records.

Laws read few of the machine's parameters, and a design model carries more than one law reads. What nobody
reads is left out of the C, so that each number in its records has an effect.
"""

from collections.abc import Iterator, Sequence

from hydroservo.language import terms


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
        functions: Sequence[terms.Function],
        whole: Sequence[terms.Record],
        given: Sequence[terms.Record] = (),
        fields: Sequence[tuple[terms.Record, str]] = (),
    ) -> None:
        self.given = given
        self.fields = set(fields)
        self.arguments: set[tuple[terms.Function, str]] = set()
        self.locals: dict[terms.Function, set[str]] = {}
        self.reached: dict[terms.Function, None] = {}
        self.tables: set[terms.ConstantArray] = set()
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

    def keep(self, record: terms.Record) -> None:
        """Keeps all fields of a record and of those in it."""
        for name, kind in record.fields.items():
            if kind not in self.given:
                self.fields.add((record, name))
            if isinstance(kind, terms.Record) and kind not in self.given:
                self.keep(kind)

    def kept(self, kind: terms.Type) -> bool:
        """True for all but a record of which nothing is kept."""
        return not isinstance(kind, terms.Record) or any(self.has(kind, name) for name in kind.fields)

    def has(self, record: terms.Record, name: str) -> bool:
        """True if a field of a record is kept."""
        return (record, name) in self.fields and self.kept(record.fields[name])

    def takes(self, function: terms.Function) -> list[tuple[str, terms.Type]]:
        """The parameters that a function really has."""
        return [
            (name, kind)
            for name, kind in function.parameters
            if (function, name) in self.arguments and self.kept(kind)
        ]

    def visit(self, function: terms.Function) -> None:
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

    def live(self, function: terms.Function) -> None:
        """Finds which locals matter, from the returns backwards."""
        names = self.locals.setdefault(function, set())
        size = -1
        while size != len(names):
            size = len(names)
            names |= set(self.read(function.body, names))
        self.arguments |= {(function, name) for name, _ in function.parameters if name in names}

    def read(self, body: Sequence[terms.Statement], names: set[str]) -> Iterator[str]:
        for one in body:
            if not matters(one, names):
                continue
            match one:
                case terms.Let(value=value) | terms.Assign(value=value) | terms.Return(value=value):
                    yield from self.names(value)
                case terms.If(condition=condition, body=inner, otherwise=otherwise):
                    yield from self.names(condition)
                    yield from self.read(inner, names)
                    yield from self.read(otherwise, names)
                case terms.While(condition=condition, body=inner):
                    yield from self.names(condition)
                    yield from self.read(inner, names)
                case terms.For(start=start, stop=stop, body=inner):
                    for end in (start, stop):
                        if isinstance(end, terms.Expression):
                            yield from self.names(end)
                    yield from self.read(inner, names)

    def names(self, value: terms.Expression) -> Iterator[str]:
        """The locals that a value is made of; fields that it reads are kept from here on."""
        if not self.kept(value.type):
            return
        match value:
            case terms.Variable(name=name):
                yield name
            case terms.Member(base=base, name=name):
                assert isinstance(base.type, terms.Record)
                self.fields.add((base.type, name))
                yield from self.names(base)
            case terms.Call(function=function, arguments=arguments):
                self.visit(function)
                for (name, _), argument in zip(function.parameters, arguments, strict=True):
                    if (function, name) in self.arguments:
                        yield from self.names(argument)
            case terms.Make(values=values):
                assert isinstance(value.type, terms.Record)
                for name, part in values.items():
                    if self.has(value.type, name):
                        yield from self.names(part)
            case terms.Choice(condition=condition, a=a, b=b):
                for part in (condition, a, b):
                    yield from self.names(part)
            case terms.Operation(a=a, b=b):
                yield from self.names(a)
                yield from self.names(b)
            case terms.Unary(a=a) | terms.Conversion(a=a):
                yield from self.names(a)
            case terms.Element(table=table, index=index):
                self.tables.add(table)
                if isinstance(index, terms.Expression):
                    yield from self.names(index)


def matters(statement: terms.Statement, names: set[str]) -> bool:
    """True if a statement returns, or gives a value to a local that matters."""
    match statement:
        case terms.Return() | terms.Break() | terms.Continue():
            return True
        case terms.Let(name=name) | terms.Assign(name=name):
            return name in names
        case terms.If(body=body, otherwise=otherwise):
            return any(matters(one, names) for one in (*body, *otherwise))
        case terms.While(body=body) | terms.For(body=body):
            return any(matters(one, names) for one in body)
    return False
