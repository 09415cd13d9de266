"""A controller or a demand as a function block, and the block that replays its test vectors."""

import inspect
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from hydroservo.core.block import Block, nested_signal
from hydroservo.core.field import Field
from hydroservo.export.layout import INDENT, ST, align_comments, split_statement
from hydroservo.export.st.functions import FunctionWriter
from hydroservo.export.st.names import unused_name
from hydroservo.export.st.pou import Declaration, Pou, Structure, block_comment, remark
from hydroservo.export.st.primitives import NO_ARGUMENT
from hydroservo.export.st.writer import OWN, STWriter, block_name
from hydroservo.export.translation import Translation, declarations_by_name, ordered_records
from hydroservo.export.unit import CModule, Part, Signal
from hydroservo.language.liveness import Liveness
from hydroservo.language.terms import Function, Record

REALS = {"double": "LREAL", "float": "REAL"}
COMMAND = "command"
OWN_PARAMETERS = "own_parameters"
RENAMED = {"measurement.command": "applied_command"}
RESET = Declaration("reset", "BOOL", "TRUE: back to the start before this sample")


class STModule(NamedTuple):
    """A unit in Structured Text, each part of it after those that it uses."""

    about: str  # the comment at the head of a file
    structures: Sequence[Structure]  # types
    functions: Sequence[Pou]  # functions
    block: Pou  # the function block
    inputs: Sequence[str]  # the block's input for each signal of the arguments, in their order
    # the place in the block's ``state`` of each number of the unit's state, in their order
    states: Sequence[str]
    outputs: Sequence[tuple[str, Signal]]  # name and signal of what the block hands on besides its state
    # the place of each parameter in their record, by its place in C; of those that are left
    parameters: Mapping[str, str]
    parameters_type: str  # the type of that record

    @property
    def text(self) -> str:
        """All of it, as one file."""
        texts = [*(one.text for one in self.structures), *(pou.text for pou in self.pous)]
        return "\n".join([block_comment(self.about), *texts])

    @property
    def pous(self) -> list[Pou]:
        """Functions and function block."""
        return [*self.functions, self.block]


class BlockWriter(NamedTuple):
    """What the function block is written from."""

    translation: Translation  # functions and records
    writer: STWriter  # of functions and records
    unit: CModule  # the same in C, whose numbers it has

    def block(self) -> Pou:
        """The function block: it starts, calls the functions, and hands their results on."""
        inputs = [RESET, *(self.declaration(name, signal) for name, _, signal in self.inputs())]
        read, kind = self.reads_parameters(), self.writer.type(self.translation.parameters)
        given = [
            Declaration(OWN_PARAMETERS, "BOOL", "TRUE: use the next input; FALSE: the scenario's"),
            Declaration("parameters", kind, f"begin with {self.defaults_name()}(FALSE), and change some"),
        ]
        state = Declaration("state", self.writer.type(self.translation.init.returns), "of this sample")
        sections = {
            "VAR_INPUT": [*inputs, *given * (read and not self.unit.inlined)],
            "VAR_OUTPUT": [*(self.declaration(name, signal) for name, _, signal in self.outputs()), state],
            "VAR": [
                Declaration("running", "BOOL", "the state is that of a sample"),
                *[Declaration("active_parameters", kind)] * read,
                *(Declaration(name, self.writer.type(record)) for name, record in self.arguments()),
            ],
        }
        about = f"{self.unit.title}\n\nCall it once every {self.unit.period!r} s, from a task of that period."
        body = [line for one in self.body() for line in split_statement(one.strip(), one[: indent(one)], ST)]
        return Pou(block_name(self.unit.prefix), "", about, sections, body)

    def inputs(self) -> list[tuple[str, str, Signal]]:
        """The block's input for each signal, such as ``velocity`` or ``demand_rate``, and its argument."""
        taken, names = {*self.writer.taken, *OWN}, []
        for argument in self.unit.arguments:
            for signal in argument.signals:
                own = signal.path.rpartition(".")[2]
                own = RENAMED.get(signal.path, own if argument.name == "measurement" else f"demand_{own}")
                names.append((unused_name(own, taken), argument.name, signal))
        return names

    def outputs(self) -> list[tuple[str, str, Signal]]:
        """Name and place of what goes out besides the state: the command, or all numbers of a demand."""
        taken = {*self.writer.taken, *OWN}
        states = zip(self.states(), self.unit.states, strict=True)
        if self.unit.part is Part.CONTROLLER:
            return [(COMMAND, place, signal) for place, signal in states if signal.place == "u"]
        return [(unused_name(place.rpartition(".")[2], taken), place, signal) for place, signal in states]

    def states(self) -> list[str]:
        """The places of the state's numbers, in the order of the unit's."""
        state = self.translation.init.returns
        assert isinstance(state, Record)
        return [place for _, place in self.writer.places(state)]

    def arguments(self) -> list[tuple[str, Record]]:
        """The records that a step is given."""
        return [(name, one) for name, one in self.translation.arguments if self.writer.needed.kept(one)]

    def reads_parameters(self) -> bool:
        """True where a function takes parameters."""
        both = (self.translation.init, self.translation.step)
        return any("self" in dict(self.writer.needed.takes(function)) for function in both)

    def declaration(self, name: str, signal: Signal) -> Declaration:
        return Declaration(name, self.writer.real, remark(signal.unit, signal.meaning))

    def defaults_name(self) -> str:
        return f"{self.unit.prefix}_defaults"

    def defaults(self) -> Pou:
        """The function that gives the scenario's parameters."""
        record = self.translation.parameters
        kind = self.writer.type(record)
        lines = list(self.values(self.translation.block, record, "values.", self.translation.signal))
        sections = {"VAR_INPUT": [Declaration(NO_ARGUMENT, "BOOL")], "VAR": [Declaration("values", kind)]}
        name = self.defaults_name()
        body = [*align_comments(lines, ST), f"{name} := values;"]
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
                about = remark(field.unit, field.meaning)
                yield f"{own} := {self.writer.number(value)[0]};{f' (* {about} *)' if about else ''}"

    def body(self) -> Iterator[str]:
        """What the block does at a sample."""
        init, step = self.translation.init, self.translation.step
        if self.reads_parameters() and not self.unit.inlined:
            yield f"IF {OWN_PARAMETERS} THEN"
            yield f"{INDENT}active_parameters := parameters;"
            yield "ELSE"
            yield f"{INDENT}active_parameters := {self.defaults_name()}(FALSE);"
            yield "END_IF;"
        yield "IF reset OR NOT running THEN"
        if self.reads_parameters() and self.unit.inlined:
            yield f"{INDENT}active_parameters := {self.defaults_name()}(FALSE);"
        yield f"{INDENT}state := {self.call(init, ['active_parameters'])};"
        yield f"{INDENT}running := TRUE;"
        if self.unit.part is Part.DEMAND:  # whose first state is that of the first sample
            yield "ELSE"
            yield f"{INDENT}state := {self.call(step, ['active_parameters', 'state'])};"
        yield "END_IF;"
        records = dict(self.translation.arguments)
        for name, argument, signal in self.inputs():
            own = self.writer.member(records[argument], signal.path.rpartition(".")[2])
            yield f"{argument}.{own} := {name};"
        if self.unit.part is Part.CONTROLLER:
            yield f"state := {self.call(step, ['active_parameters', 'state', *records])};"
        for name, place, _ in self.outputs():
            yield f"{name} := state.{place};"

    def call(self, function: Function, arguments: Sequence[str]) -> str:
        """A call with what the function takes of these arguments."""
        given = ", ".join(self.writer.arguments_of(function, arguments))
        return f"{self.writer.function_name(function)}({given or 'FALSE'})"


def indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def st_module(translation: Translation, needed: Liveness, unit: CModule, about: str) -> STModule:
    """A unit in Structured Text.

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
    inputs = [name for name, _, _ in block.inputs()]
    functions = [*writer.text_functions(), *functions]
    outputs = [(name, signal) for name, _, signal in block.outputs()]
    kind = writer.type(translation.parameters)
    return STModule(
        about,
        structures,
        functions,
        pou,
        inputs,
        block.states(),
        outputs,
        dict(writer.places(translation.parameters)),
        kind,
    )


def documented_functions(writer: STWriter) -> list[Pou]:
    """The functions, the first of each block's below what the block is: its equation, source and limits."""
    documented: set[type] = set()
    functions = []
    for function in writer.needed.reached:
        if not function.body:
            continue
        pou, owner = FunctionWriter(writer, function).pou(), function.owner
        if owner is not None and owner not in documented:
            documented.add(owner)
            own = f"\n\nThis function: {pou.about}" if pou.about else ""
            pou = pou._replace(about=f"{owner.__name__}\n\n{inspect.getdoc(owner) or ''}{own}")
        functions.append(pou)
    return functions
