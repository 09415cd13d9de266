"""A part of a scenario's loop, translated."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from hydroservo._version import __version__
from hydroservo.control.loop import Loop, MachineState
from hydroservo.core.block import Block, field_at, leaves, state_field_at
from hydroservo.core.command_scale import is_volts
from hydroservo.core.errors import LoopError, ParameterError
from hydroservo.core.field import Field, declared_fields
from hydroservo.core.signals import Demand, Measurement
from hydroservo.cosimulation import refuse_fmus
from hydroservo.engine.state_text import Made
from hydroservo.export import parts
from hydroservo.export.c.primitives import WRITTEN
from hydroservo.export.c.source import SourceForm, source_texts
from hydroservo.export.converted import ConvertedController, ConvertedHold, ConvertedState
from hydroservo.export.counting import operation_count
from hydroservo.export.st.primitives import WRITTEN as ST_WRITTEN
from hydroservo.export.st.source import STModule, st_module
from hydroservo.export.texts import checked_prefix, plain_title
from hydroservo.export.translation import Translation, declarations_by_name
from hydroservo.export.unit import INTEGRATED, RATES, Argument, CModule, Part, Precision, Signal
from hydroservo.language.constants import fold_constants
from hydroservo.language.liveness import Liveness
from hydroservo.language.names import place_in_c
from hydroservo.language.program import Program, check_law
from hydroservo.language.terms import REAL, Record
from hydroservo.runs.cautions import quietly
from hydroservo.runs.fitting import first_state
from hydroservo.runs.provenance import canonical_toml, scenario_hash
from hydroservo.runs.run import complete_loop, runnable_loop, simulate
from hydroservo.runs.steady import SIZES

TAKES = {  # name and type of each argument of step besides the state
    Part.CONTROLLER: (("measurement", Measurement), ("demand", Demand)),
    Part.MACHINE: (("command", parts.Command), ("external", parts.ExternalForce)),
    Part.EQUATIONS: (
        ("instant", parts.Instant),
        (INTEGRATED, MachineState),
        ("command", parts.Command),
        ("external", parts.ExternalForce),
    ),
    Part.DEMAND: (),
    Part.LOOP: (),
}

MadeBlock = Callable[[Loop, Part], Block]
PER_VOLT = "per_volt"
CONVERTED: Mapping[type | None, tuple[str, ...]] = {  # which numbers are in the scenario's unit of commands
    Measurement: ("command",),
    parts.Command: ("u",),
    parts.MachineUnitState: ("command",),
    ConvertedState: ("u",),
    **dict.fromkeys((ConvertedController, ConvertedHold, parts.ConvertedEquationsUnit), (PER_VOLT,)),
}
STILL = 1e-6  # of a usual size: what a state has below it is rounding
IN_ST = (Part.CONTROLLER, Part.DEMAND)
STEPPED = (Part.MACHINE, Part.LOOP)  # by an integrator of its own
MACHINE = ("plant.", "valve.", "supply.", "drive.")  # records of a machine's state


class StateSize(NamedTuple):
    """Where an integrated number starts, and its largest absolute value in the scenario."""

    start: float
    largest: float


def exported_unit(
    loop: Loop,
    part: Part,
    *,
    prefix: str,
    title: str,
    precision: Precision = Precision.DOUBLE,
    inlined: bool = False,
    block: MadeBlock = parts.block_of,
) -> CModule:
    """A part of a loop as C99.

    Args:
        loop: the loop.
        part: its controller, its machine with the sensors, the machine's equations, its demand, or all of it.
        prefix: of every name with external linkage, and of files; a C identifier.
        title: what it is, for people; put into one line.
        precision: double, or single for a controller.
        inlined: the parameters are constants of the source, not an argument.
        block: makes what is stepped of the loop and the part.

    Raises:
        TranslationError: a block says what is not in the language.
        ParameterError: a parameter is out of range, or the prefix cannot be one.
        LoopError: single precision where it cannot be, or an expression that nests too deep.
    """
    return c_module(ready_unit(loop, part, prefix, title, precision, inlined, WRITTEN, block))


def exported_block(
    loop: Loop, part: Part, *, prefix: str, title: str, precision: Precision, inlined: bool
) -> tuple[CModule, STModule]:
    """A controller or a demand of a loop as Structured Text, and in C as of :func:`exported_unit`.

    Raises:
        TranslationError, ParameterError, LoopError: as there; also for any other part.
    """
    if part not in IN_ST:
        allowed = " or ".join(IN_ST)
        raise ParameterError(
            "part", part.value, f"must be {allowed}: Structured Text is not written of others"
        )
    ready = ready_unit(loop, part, prefix, title, precision, inlined, ST_WRITTEN)
    unit = c_module(ready)
    return unit, st_module(ready.translation, ready.needed, unit, ready.about(BITS_ST))


class ReadyUnit(NamedTuple):
    """A translated unit, before it is written in a language."""

    loop: Loop  # the complete loop
    runnable: Loop  # what of it runs
    translation: Translation  # the functions and records
    needed: Liveness  # what of them is needed
    read: Liveness  # the same, before constants were folded
    later: Liveness  # what ``step`` alone needs
    part: Part  # of the loop
    prefix: str  # of names
    title: str  # for people
    real: str  # "double" or "float"
    inlined: bool  # the parameters are constants of the source

    def about(self, bits: str) -> str:
        """The comment at the head of a file."""
        command = self.loop.command
        sampled = f", for a sample period of {self.runnable.simulation.period!r} s"
        in_volts = self.part in (Part.LOOP, Part.DEMAND) or is_volts(command)
        return ABOUT.format(
            bits=bits,
            title=self.title,
            hash=scenario_hash(self.loop),
            version=__version__,
            sampled="" if self.part is Part.EQUATIONS else sampled,
            commands="" if in_volts else COMMANDS.format(unit=command.unit, per_volt=float(command.per_volt)),
        )


def ready_unit(
    loop: Loop,
    part: Part,
    prefix: str,
    title: str,
    precision: Precision,
    inlined: bool,
    written: Mapping[Any, Made],
    block: MadeBlock = parts.block_of,
) -> ReadyUnit:
    """A part of a loop, translated; as of :func:`exported_unit`."""
    checked_prefix(prefix)
    single = precision is Precision.SINGLE
    if single and part is not Part.CONTROLLER:
        raise LoopError(f"{part}: exported in double precision only; time and states need the digits")
    if part not in (Part.CONTROLLER, Part.DEMAND):
        refuse_fmus(loop, f"write its {part} as C")
    loop = complete_loop(loop)
    ready_loop = parts.with_its_substeps(runnable_loop(loop)) if part in STEPPED else runnable_loop(loop)
    translation = translate_unit(block(ready_loop, part), ready_loop, part, prefix, written)
    first_state(ready_loop)  # what goes wrong in Python at once, such as a signal that nothing measures
    read, later = needed_by(translation, init=True), needed_by(translation, init=False)
    parameters = [translation.block] if inlined else []  # which may change between samples where they are not
    fold_constants({translation.init: parameters, translation.step: parameters})
    needed = needed_by(translation, init=True)
    real = "float" if single else "double"
    title = plain_title(title)
    return ReadyUnit(loop, ready_loop, translation, needed, read, later, part, prefix, title, real, inlined)


def c_module(ready: ReadyUnit) -> CModule:
    translation, needed, part, digest = ready.translation, ready.needed, ready.part, scenario_hash(ready.loop)
    form = SourceForm(ready.prefix, ready.real, ready.inlined, ready.about(BITS), digest, __version__)
    header, source = source_texts(translation, needed, form)
    start = translation.start
    integrated = exported_sizes(ready.runnable, start.start) if part is Part.EQUATIONS else {}
    return CModule(
        part=part,
        prefix=ready.prefix,
        title=ready.title,
        scenario=canonical_toml(ready.loop),
        hash=digest,
        version=__version__,
        period=ready.runnable.simulation.period,
        real=ready.real,
        inlined=ready.inlined,
        header=header,
        source=source,
        parameters=tuple(parameter_signals(translation, ready.read, ready.later)),
        arguments=tuple(
            Argument(name, tuple(argument_signals(name, record, needed, integrated, translation.signal)))
            for name, record in translation.arguments
            if needed.kept(record)
        ),
        states=tuple(state_signals(translation, needed)),
        operations=operation_count(translation.step, needed),
    )


ABOUT = """\
{title}

Written by hydroservo {version} from the scenario with hash {hash}{sampled}.{commands}
What is computed here is, operation by operation, what the simulation computes: {bits}
SPDX-License-Identifier: BSD-3-Clause"""
BITS = """\
with IEEE 754 numbers, no
contraction of a*b + c, which is switched off below, and no -ffast-math, results agree to the last bit."""
BITS_ST = """\
with IEEE 754 numbers
and no contraction of a*b + c, results agree to the last bit. Numbers are in SI units."""

COMMANDS = """
The command comes and goes in {unit}, {per_volt:g} {unit} a volt; what is inside counts in volts."""


def translate_unit(
    block: Block, loop: Loop, part: Part, prefix: str, written: Mapping[Any, Made]
) -> Translation:
    """A unit's functions and records."""
    try:
        program = Program(written, prefix)
        found = translation_of(program, block, part, loop.controls.declared())
    except RecursionError:
        raise LoopError(
            f"{part}: an expression nests too deeply to be translated; give names to parts of it"
        ) from None
    if part is not Part.LOOP and not is_volts(loop.command):
        hold: type = type(loop.hold.init())
        held = tuple(name for name, field in declared_fields(hold).items() if field.unit == "V")
        converted = {**CONVERTED, hold: held}
        for record in program.records.values():
            names = converted.get(record.cls, ())
            record.units = {one: f"{loop.command.unit}{'/V' * (one == PER_VOLT)}" for one in names}
    return found


def translation_of(program: Program, block: Block, part: Part, controlled: Field) -> Translation:
    # Arguments first: the names of their types are public, and a block such as Command may have the same.
    arguments = tuple((name, argument_record(program, name, cls, block)) for name, cls in TAKES[part])
    record = program.type_of(block)
    assert isinstance(record, Record)
    if part is Part.CONTROLLER:
        check_law(program, record.fields["controller"], [kind for _, kind in arguments])
    init = program.method(record, "init", [])
    state = init.returns
    assert isinstance(state, Record)
    step = program.method(record, "step", [state, *(kind for _, kind in arguments)])
    record.name, state.name = "parameters", "state"
    known = tuple(program.records.values()), tuple(program.tables.values())
    return Translation(block, record, init, step, arguments, part, *known, controlled)


def argument_record(program: Program, name: str, cls: Any, block: Block) -> Record:
    """The record of an argument: of numbers alone, but for the state of equations."""
    if name != INTEGRATED:
        return program.record(cls, dict.fromkeys(cls._fields, REAL), name)
    record = program.type_of(block.init().start)
    assert isinstance(record, Record)
    record.name = name
    return record


def needed_by(translation: Translation, *, init: bool) -> Liveness:
    """What a unit's functions need: both of them, or ``step`` alone."""
    functions = [translation.init, translation.step] if init else [translation.step]
    given = [record for name, record in translation.arguments if name != INTEGRATED]
    state = translation.init.returns
    assert isinstance(state, Record)
    timed = init and "period" in translation.parameters.fields
    return Liveness(functions, [state], given, [(translation.parameters, "period")] if timed else [])


def parameter_signals(translation: Translation, needed: Liveness, later: Liveness) -> Iterator[Signal]:
    """The parameters that are read; fixed are those that no step reads later."""
    for place, record, name in kept_numbers(translation.parameters, needed):
        path = "simulation.period" if place == "period" else place.removeprefix("loop.")
        fixed = not later.has(record, name) or place == "period"
        field = field_at(translation.block, place, translation.signal)
        field = replace(field, unit=record.units.get(name, field.unit))
        parameter = unit_signal(path, place, field, number_in(translation.block, place))
        least, most = field_bounds(field)
        yield parameter._replace(fixed=fixed, least=least, most=most)


def argument_signals(
    argument: str, record: Record, needed: Liveness, integrated: Mapping[str, StateSize], controlled: Field
) -> Iterator[Signal]:
    """The numbers of an argument; those that an integrator carries on have a start and a nominal value."""
    for place, owner, name in kept_numbers(record, needed):
        field = declarations_by_name(owner, [controlled]).get(name, Field("", name))
        if argument == INTEGRATED:
            start, largest = integrated[place]
            state = unit_signal(place, place, field, start)
            yield state._replace(integrated=True, nominal=nominal_size(largest, field.unit))
        else:
            path = "controller.u" if owner.cls is parts.Command else f"{argument}.{place}"
            yield unit_signal(path, place, field, 0.0)


def nominal_size(largest: float, unit: str) -> float:
    """The usual size of a state: its largest in the scenario, or that of its unit where it stands still."""
    usual = SIZES.get(unit, 1.0)
    return largest if largest > STILL * usual else usual


def exported_sizes(loop: Loop, start: Block) -> dict[str, StateSize]:
    """The size of each state of a machine, from a run of the scenario."""
    run = quietly(simulate)(loop, record=[path for path, _ in leaves(start)], metrics=())
    return {path: StateSize(value, float(np.nanmax(np.abs(run[path])))) for path, value in leaves(start)}


def state_signals(translation: Translation, needed: Liveness) -> Iterator[Signal]:
    """The numbers of the state, by their paths in the loop."""
    start, part = translation.start, translation.part
    for place, record, name in kept_numbers(translation.init.returns, needed):
        own = place.removeprefix("loop.")
        integrated = part is not Part.CONTROLLER and own.startswith(MACHINE)
        path = f"controller.{own}" if part is Part.CONTROLLER else own
        field = state_field_at(translation.stepped, start, place, translation.signal)
        field = replace(field, unit=record.units.get(name, field.unit))
        state = unit_signal(path, place, field, number_in(start, place))
        if own.startswith(RATES):
            state = state._replace(unit=f"{state.unit or 1}/s", meaning=f"rate of the {state.meaning}")
        yield state._replace(integrated=integrated)


def unit_signal(path: str, place: str, field: Field, value: float) -> Signal:
    return Signal(path, place_in_c(place), field.unit, field.meaning, float(value))


def field_bounds(field: Field) -> tuple[float, float]:
    """The smallest and the largest number in a field's range."""
    least = max(one for one in (-math.inf, field.at_least, next_to(field.above, math.inf)) if one is not None)
    most = min(one for one in (math.inf, field.at_most, next_to(field.below, -math.inf)) if one is not None)
    return least, most


def next_to(bound: float | None, towards: float) -> float | None:
    """The number beside a bound that is itself excluded."""
    return None if bound is None else math.nextafter(bound, towards)


def kept_numbers(record: Any, needed: Liveness, place: str = "") -> Iterator[tuple[str, Record, str]]:
    """Each number of a record that is kept: its place, and the record and name of its field."""
    for name, kind in record.fields.items():
        if isinstance(kind, Record) and needed.has(record, name):
            yield from kept_numbers(kind, needed, f"{place}{name}.")
        elif needed.has(record, name):
            yield place + name, record, name


def number_in(block: Block, place: str) -> float:
    for name in place.split("."):
        block = getattr(block, name)
    return float(block)
