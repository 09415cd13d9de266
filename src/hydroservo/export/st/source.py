"""A controller or a demand as a function block, and the block that replays its test vectors."""

import inspect
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import Block, nested_signal
from hydroservo.core.field import Field
from hydroservo.export.c.project import TOLERANCE
from hydroservo.export.declared import declarations_by_name
from hydroservo.export.layout import INDENT, ST, align_comments, split_statement
from hydroservo.export.st.functions import function_of
from hydroservo.export.st.names import unused_name
from hydroservo.export.st.numbers import BEYOND, literal_of, parts_of
from hydroservo.export.st.pou import Declaration, Pou, Structure, note, said
from hydroservo.export.st.primitives import NO_ARGUMENT, text_function, with_callees
from hydroservo.export.st.writer import STWriter, block_name
from hydroservo.export.translation import Translation, ordered_records
from hydroservo.export.unit import CModule, Part, Signal
from hydroservo.export.vectors import Vectors
from hydroservo.language.liveness import Liveness
from hydroservo.language.names import place_in_c
from hydroservo.language.terms import Function, Record

REALS = {"double": "LREAL", "float": "REAL"}
COMMAND = "command"
OWN_PARAMETERS = "own_parameters"
OWN = frozenset(
    ("reset", "parameters", OWN_PARAMETERS, "used", "state", "running")
)  # names in every function block
RENAMED = {"measurement.command": "applied_command"}
RESET = Declaration("reset", "BOOL", "TRUE: back to the start before this sample")
MISSING = 2 * BEYOND  # the exponent that stands for not-a-number in test vectors
SAMPLE = "samples"  # the replay's variable


class STModule(NamedTuple):
    """A unit in Structured Text, each part of it after those that it uses.

    Attributes:
        about: the comment at the head of a file.
        structures: types.
        functions: functions.
        block: the function block.
        inputs: the block's input for each signal of the arguments, in their order.
        states: the place in the block's ``state`` of each number of the unit's state, in their order.
    """

    about: str
    structures: Sequence[Structure]
    functions: Sequence[Pou]
    block: Pou
    inputs: Sequence[str]
    states: Sequence[str]

    @property
    def text(self) -> str:
        """All of it, as one file."""
        texts = [*(one.text for one in self.structures), *(pou.text for pou in self.pous)]
        return "\n".join([said(self.about), *texts])

    @property
    def pous(self) -> list[Pou]:
        """Functions and function block."""
        return [*self.functions, self.block]


class BlockWriter(NamedTuple):
    """What the function block is written from.

    Attributes:
        translation: functions and records.
        writer: of functions and records.
        unit: the same in C, whose numbers it has.
    """

    translation: Translation
    writer: STWriter
    unit: CModule

    def block(self) -> Pou:
        """The function block: it starts, calls the functions, and hands their results on."""
        inputs = [RESET, *(self.declaration(name, signal) for name, signal in self.inputs())]
        read, kind = self.reads_parameters(), self.writer.type(self.translation.parameters)
        given = [
            Declaration(OWN_PARAMETERS, "BOOL", "TRUE: the next input is used; else those of the scenario"),
            Declaration("parameters", kind, f"begin with {self.defaults_name()}(FALSE), and change some"),
        ]
        state = Declaration("state", self.writer.type(self.translation.init.returns), "of this sample")
        sections = {
            "VAR_INPUT": [*inputs, *given * (read and not self.unit.inlined)],
            "VAR_OUTPUT": [*(self.declaration(name, signal) for name, _, signal in self.outputs()), state],
            "VAR": [
                Declaration("running", "BOOL", "the state is that of a sample"),
                *[Declaration("used", kind)] * read,
                *(Declaration(name, self.writer.type(record)) for name, record in self.arguments()),
            ],
        }
        about = f"{self.unit.title}\n\nCall it once every {self.unit.period!r} s, from a task of that period."
        body = [line for one in self.body() for line in split_statement(one.strip(), one[: indent(one)], ST)]
        return Pou(block_name(self.unit.prefix), "", about, sections, body)

    def inputs(self) -> list[tuple[str, Signal]]:
        """The name of the block's input for each signal: ``velocity``, ``demand_rate``."""
        taken, names = {*OWN, COMMAND, *self.writer.taken}, []
        for argument in self.unit.arguments:
            for signal in argument.signals:
                own = signal.path.rpartition(".")[2]
                own = RENAMED.get(signal.path, own if argument.name == "measurement" else f"demand_{own}")
                names.append((unused_name(own, taken), signal))
        return names

    def outputs(self) -> list[tuple[str, str, Signal]]:
        """Name and place of what goes out besides the state: the command, or all numbers of a demand."""
        taken = {*OWN, *self.writer.taken}
        states = zip(self.states(), self.unit.states, strict=True)
        if self.unit.part is Part.CONTROLLER:
            return [(COMMAND, place, signal) for place, signal in states if signal.place == "u"]
        return [(unused_name(place.rpartition(".")[2], taken), place, signal) for place, signal in states]

    def states(self) -> list[str]:
        """The places of the state's numbers, in the order of the unit's."""
        state = self.translation.init.returns
        assert isinstance(state, Record)
        return list(self.writer.leaves(state))

    def arguments(self) -> list[tuple[str, Record]]:
        """The records that a step is given."""
        return [(name, one) for name, one in self.translation.arguments if self.writer.needed.kept(one)]

    def reads_parameters(self) -> bool:
        """True where a function takes parameters."""
        both = (self.translation.init, self.translation.step)
        return any("self" in dict(self.writer.needed.takes(function)) for function in both)

    def declaration(self, name: str, signal: Signal) -> Declaration:
        return Declaration(name, self.writer.real, note(signal.unit, signal.meaning))

    def defaults_name(self) -> str:
        return f"{self.unit.prefix}_defaults"

    def defaults(self) -> Pou:
        """The function that gives the scenario's parameters."""
        record = self.translation.parameters
        kind = self.writer.type(record)
        lines = list(self.values(self.translation.block, record, "value_of.", self.translation.signal))
        sections = {"VAR_INPUT": [Declaration(NO_ARGUMENT, "BOOL")], "VAR": [Declaration("value_of", kind)]}
        name = self.defaults_name()
        body = [*align_comments(lines, ST), f"{name} := value_of;"]
        return Pou(name, kind, "The scenario's parameters.", sections, body)

    def values(self, block: Block, record: Record, place: str, signal: Field | None) -> Iterator[str]:
        """A statement for each number of a record."""
        fields = declarations_by_name(record, [signal])
        for name, kind in self.writer.kept(record):
            value, own = getattr(block, name), f"{place}{self.writer.member(record, name)}"
            if isinstance(kind, Record):
                yield from self.values(value, kind, f"{own}.", nested_signal(block, name, signal))
            else:
                field = fields.get(name, Field("", ""))
                said = note(field.unit, field.meaning)
                yield f"{own} := {self.writer.number(value)[0]};{f' (* {said} *)' if said else ''}"

    def body(self) -> Iterator[str]:
        """What the block does at a sample."""
        init, step = self.translation.init, self.translation.step
        if self.reads_parameters() and not self.unit.inlined:
            yield f"IF {OWN_PARAMETERS} THEN"
            yield f"{INDENT}used := parameters;"
            yield "ELSIF NOT running THEN"
            yield f"{INDENT}used := {self.defaults_name()}(FALSE);"
            yield "END_IF;"
        yield "IF reset OR NOT running THEN"
        if self.reads_parameters() and self.unit.inlined:
            yield f"{INDENT}used := {self.defaults_name()}(FALSE);"
        yield f"{INDENT}state := {self.call(init, ['used'])};"
        yield f"{INDENT}running := TRUE;"
        yield "END_IF;"
        records = dict(self.translation.arguments)
        for (name, signal), argument in zip(self.inputs(), self.owners(), strict=True):
            field = next(one for one in records[argument].fields if place_in_c(one) == signal.place)
            yield f"{argument}.{self.writer.member(records[argument], field)} := {name};"
        yield f"state := {self.call(step, ['used', 'state', *records])};"
        for name, place, _ in self.outputs():
            yield f"{name} := state.{place};"

    def owners(self) -> list[str]:
        """The name of the argument of each signal."""
        return [argument.name for argument in self.unit.arguments for _ in argument.signals]

    def call(self, function: Function, arguments: Sequence[str]) -> str:
        """A call with what the function takes of these arguments."""
        taken = {name for name, _ in self.writer.needed.takes(function)}
        pairs = zip(function.parameters, arguments, strict=True)
        given = ", ".join(argument for (name, _), argument in pairs if name in taken)
        return f"{self.writer.function_name(function)}({given or 'FALSE'})"


def indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def st_module(translation: Translation, needed: Liveness, unit: CModule, about: str) -> STModule:
    """A unit in Structured Text.

    Args:
        translation: its functions and records.
        needed: what of them is needed.
        unit: the same in C, whose numbers it has.
        about: what it is, and where it comes from.

    Raises:
        TranslationError: a function has no Structured Text.
    """
    writer = STWriter(unit.prefix, REALS[unit.real], needed, translation.signals())
    given = [record for _, record in translation.arguments]
    records = ordered_records([*given, translation.parameters, *translation.records], needed)
    writer.name_all(records)
    structures = [writer.record(record) for record in records]
    functions = documented_functions(writer)
    block = BlockWriter(translation, writer, unit)
    pou = block.block()
    functions += [block.defaults()] if block.reads_parameters() else []
    inputs = [name for name, _ in block.inputs()]
    return STModule(about, structures, [*writer.text_functions(), *functions], pou, inputs, block.states())


def documented_functions(writer: STWriter) -> list[Pou]:
    """The functions, the first of each block's below what the block is: its equation, source and limits."""
    documented: set[type] = set()
    functions = []
    for function in writer.needed.reached:
        pou, owner = function_of(writer, function), function.owner
        if pou is None:
            continue
        if owner is not None and owner not in documented:
            documented.add(owner)
            own = f"\n\nThis function: {pou.about}" if pou.about else ""
            pou = pou._replace(about=f"{owner.__name__}\n\n{inspect.getdoc(owner) or ''}{own}")
        functions.append(pou)
    return functions


def replay_of(module: STModule, unit: CModule, vectors: Vectors) -> list[Pou]:
    """What runs a unit through test vectors, a sample at each call, and counts the numbers that differ."""
    real, p, count = REALS[unit.real], unit.prefix, len(vectors.expected)
    columns = zip((*module.inputs, *module.states), (*vectors.inputs.T, *vectors.expected.T), strict=True)
    tables = [Column(f"column_{i}", p, real, place, numbers) for i, (place, numbers) in enumerate(columns, 1)]
    given, wanted = tables[: len(module.inputs)], tables[len(module.inputs) :]
    body = [f"IF {SAMPLE} >= {count} THEN", f"{INDENT}RETURN;", "END_IF;"]
    arguments = ", ".join(f"{one.place} := {one.number}" for one in given)
    body += split_statement(f"unit({arguments});", "", ST)
    for one in wanted:
        compared = f"unit.state.{one.place}, {one.number}, {one.tolerance}"
        body += split_statement(f"IF {p}_differs({compared}) THEN", "", ST)
        body += [f"{INDENT}different := different + 1;", "END_IF;"]
    body += [f"{SAMPLE} := {SAMPLE} + 1;", f"done := {SAMPLE} >= {count};"]
    sections = {
        "VAR_OUTPUT": [
            Declaration("done", "BOOL", "all samples have been replayed"),
            Declaration(SAMPLE, "DINT", "replayed so far"),
            Declaration("different", "DINT", "numbers that are not the wanted ones; 0 where all is well"),
        ],
        "VAR": [Declaration("unit", block_name(p))],
        "VAR CONSTANT": [declaration for one in tables for declaration in one.declarations()],
    }
    about = f"Replays {count} samples through {block_name(p)}, one at each call.\n\n{vectors.made}"
    return [*vector_functions(module, p, real), Pou(f"{block_name(p)}_replay", "", about, sections, body)]


class Column(NamedTuple):
    """The numbers of one signal in test vectors: a constant array, or two of mantissas and exponents."""

    name: str
    prefix: str
    real: str
    place: str
    numbers: NDArray[np.float64]

    @property
    def number(self) -> str:
        """The number of the sample at hand."""
        here = f"{self.name}[{SAMPLE}]"
        return here if self.is_plain() else f"{self.prefix}_given({here}, {self.name}_exponent[{SAMPLE}])"

    @property
    def tolerance(self) -> str:
        """How far a number may be off: not at all, or in single precision as far as in C."""
        sizes = np.abs(self.numbers[np.isfinite(self.numbers)])
        most = float(TOLERANCE) * float(sizes.max(initial=0.0))
        return "0.0" if self.real == "LREAL" else literal_of(most, self.real) or "0.0"

    def is_plain(self) -> bool:
        """True where each number has a literal."""
        return all(literal_of(one, self.real) for one in self.numbers.tolist())

    def declarations(self) -> list[Declaration]:
        """The array, or both."""
        numbers = self.numbers.tolist()
        if self.is_plain():
            return [self.declaration(self.name, [literal_of(one, self.real) for one in numbers])]
        parts = [("1.0", f"{MISSING}.0") if math.isnan(one) else parts_of(one, self.real) for one in numbers]
        names = (self.name, f"{self.name}_exponent")
        return [
            self.declaration(name, [*of]) for name, of in zip(names, zip(*parts, strict=True), strict=True)
        ]

    def declaration(self, name: str, literals: Sequence[str]) -> Declaration:
        return Declaration(name, self.real, self.place, literals, length=len(literals))


def vector_functions(module: STModule, prefix: str, real: str) -> list[Pou]:
    """What reads a number of a test vector, what compares one, and what they call."""
    known = {pou.name for pou in module.functions}
    helpers = [text_function(name, prefix, real) for name in with_callees(["nan"])]
    given, differs = f"{prefix}_given", f"{prefix}_differs"
    parts = [Declaration("mantissa", real), Declaration("exponent", real)]
    compared = [Declaration(name, real) for name in ("x", "wanted", "tolerance")]
    return [
        *(pou for pou in helpers if pou.name not in known),
        Pou(
            given,
            real,
            f"A number of a test vector; an exponent of {MISSING} stands for not-a-number.",
            {"VAR_INPUT": parts},
            [
                f"IF exponent = {MISSING}.0 THEN",
                f"{INDENT}{given} := {prefix}_nan(FALSE);",
                "ELSE",
                f"{INDENT}{given} := {prefix}_number(mantissa, exponent);",
                "END_IF;",
            ],
        ),
        Pou(
            differs,
            "BOOL",
            "TRUE for a number that is not the wanted one, or farther from it than a tolerance.",
            {"VAR_INPUT": compared},
            [
                "IF (x <> x) OR (wanted <> wanted) THEN",
                f"{INDENT}{differs} := (x = x) OR (wanted = wanted);",
                "ELSE",
                f"{INDENT}{differs} := NOT (ABS(x - wanted) <= tolerance);",
                "END_IF;",
            ],
        ),
    ]
