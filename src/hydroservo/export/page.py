"""A page that runs a loop in a browser: its WebAssembly, sliders, plots and metrics in one file."""

import base64
import inspect
import json
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hydroservo.control.controlled import Command
from hydroservo.control.loop import Loop
from hydroservo.control.monitors.group import snake_case
from hydroservo.core.block import Block, field_at, leaves, replace, value_at
from hydroservo.core.command_scale import commands_in
from hydroservo.core.errors import (
    HydroservoError,
    HydroservoWarning,
    LoopError,
    ParameterError,
    ScenarioError,
)
from hydroservo.core.formatting import (
    Scale,
    brief,
    counted,
    enumeration,
    plain_quantity,
    readable_unit,
    scale_of,
)
from hydroservo.core.outputs import check_outputs, write_text, written_or_kept
from hydroservo.cosimulation import refuse_fmus
from hydroservo.export.fmu import checked_ending
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.products import Export, Progress, report_nothing, title_and_prefix
from hydroservo.export.texts import render
from hydroservo.export.unit import CModule, Part, Proof, Signal
from hydroservo.export.wasm import WasmLoop, check_bits, check_packages, wasm_of
from hydroservo.export.watched import METRICS, WATCH, metric_places, page_monitors, watched_loop
from hydroservo.machine.drives import ValveOnSupply
from hydroservo.machine.valves import NoValve
from hydroservo.runs.arguments import checked_loop, checked_mapping, checked_path
from hydroservo.runs.fitting import name_with_inner
from hydroservo.runs.run import PreparedRun, prepare_loop, prepare_run
from hydroservo.runs.trace import Trace
from hydroservo.scenario.ranges import as_entries, both_ends, check_path, typed_scales
from hydroservo.scenario.tables import TableEntry

UNSEEN = ("holds", "sample")  # of the state, besides what monitors gather
PLAIN = (NoValve, ValveOnSupply)  # of which there is nothing to say
SHOWN = {"demand": "reference.value", "signal": "controlled.value", "command": "controller.u"}


class Slider(NamedTuple):
    """A parameter that a page can change.

    Attributes:
        signal: the number.
        low: smallest value [SI].
        high: largest.
        scale: the unit in which it is shown.
    """

    signal: Signal
    low: float
    high: float
    scale: Scale


def export_page(
    loop: Loop,
    file: Path | str,
    sliders: Mapping[str, str | tuple[float, float]],
    *,
    name: str = "",
    title: str = "",
    progress: Progress | None = None,
) -> Export:
    """Write a loop as one HTML file that runs it, with sliders, plots and metrics; it needs no server.

    The loop is that of :func:`~hydroservo.export_c`, compiled to WebAssembly. Before the file is written, its
    numbers are held against strict runs, bit for bit: of the loop as it is, and at both ends of each slider.
    The seed, the steps, and the state in which it begins stay those of the loop as it is. Needs the extra
    ``page``.

    Args:
        loop: the loop.
        file: ends in ".html".
        sliders: the range of each number that can be moved, by its path in the loop, with its value inside:
            two numbers in SI units, ``hs.relative(low, high)``, or a text such as "0.1..30 V s/m".
        name: of the scenario, for the title and the file.
        title: what the scenario is, in a line.
        progress: called now and then.

    Returns:
        What was exported, how many recorded samples have the bits of the runs, and the path written.

    Warns:
        HydroservoWarning: what :func:`~hydroservo.simulate` warns of; the page says it too.

    Raises:
        TranslationError, ParameterError, LoopError: as of :func:`~hydroservo.export_c`; also where a slider
            is not a number of the loop, or changes others that the page holds.
        ScenarioError: a range is empty, or its unit is another one.
        HydroservoError: the file cannot be written, a package is missing, or an FMU is in the loop.

    Source: WebAssembly Core Specification, whose arithmetic is that of IEEE 754.
    Fails to prove anything between the ends of the sliders, and of several that are moved together, and to
    notice where these make the steps too coarse.
    """
    entries = as_entries(checked_mapping("sliders", sliders, "paths to ranges"), "sliders")
    return write_page(loop, file, entries, name=name, title=title, progress=progress)[0]


def write_page(
    loop: Loop,
    file: Path | str,
    ranges: Mapping[str, TableEntry],
    *,
    fitting_only: bool = False,
    name: str = "",
    title: str = "",
    progress: Progress | None = None,
) -> tuple[Export, list[str]]:
    """As :func:`export_page`, of ranges with the places where they stand; also the paths of the sliders.

    With ``fitting_only``, ranges of which no slider can be made are left out, if there are others.
    """
    path, report = checked_ending(checked_path("file", file), ".html"), progress or report_nothing
    loop = checked_loop(loop)
    refuse_fmus(loop, "write a page")
    if not (ranges and all(isinstance(one, str) for one in ranges)):
        raise ParameterError("sliders", [*ranges], "must name numbers and their ranges")
    if not isinstance(title, str):
        raise ParameterError("title", title, "must be a string: what the scenario is, in a line")
    check_outputs([path])
    check_packages()
    report(0.0, "translating")
    what, prefix = title_and_prefix(loop, Part.LOOP, name)
    with commands_in(loop.command):
        unit = exported_unit(loop, Part.LOOP, prefix=prefix, title=what, block=watched_loop)
        sliders = sliders_of(unit, held := with_its_start(loop), ranges, fitting_only)
        report(0.1, "compiling to WebAssembly")
        code = wasm_of(unit, [one.signal for one in sliders])
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always", HydroservoWarning)
            run = prepare_run(held, record=recorded_paths(unit), metrics=page_monitors(loop), strict=True)
        trace = run({})
        proof = replay(unit, code, sliders, run, trace, report)
        text = render(
            "page.html",
            {
                "title": title or what,
                "name": name or what,
                "machine": machine_line(run.loop),
                "warnings": [str(one.message) for one in said],
                "unit": unit,
                "samples": proof.samples,
                "data": in_script(page_data(unit, sliders, run, trace)),
                "code": base64.b64encode(code).decode(),
            },
        )
    for one in said:
        warnings.warn(one.message, stacklevel=3)
    report(0.95, "writing the page")
    files = written_or_kept(path.parent, lambda to: [write_text(to / path.name, text)])
    return Export(unit, proof, tuple(files)), [one.signal.path for one in sliders]


def with_its_start(loop: Loop) -> Loop:
    """The loop that begins in the state in which it begins, whatever of its numbers is changed."""
    ready = prepare_loop(loop)[1]
    return loop._replace(plant=ready.plant, start=ready.start)


def sliders_of(
    unit: CModule, loop: Loop, ranges: Mapping[str, TableEntry], fitting_only: bool
) -> list[Slider]:
    """The sliders with these ranges, all or those that there can be."""
    found, problems = [], []
    for path, entry in ranges.items():
        try:
            found.append(slider_of(unit, loop, path, entry))
        except (ParameterError, ScenarioError) as error:
            problems.append(error)
    if problems and not fitting_only:
        raise problems[0]
    if not found:
        raise HydroservoError(f"{problems[0]}; choose another number")
    return found


def slider_of(unit: CModule, loop: Loop, path: str, entry: TableEntry) -> Slider:
    """The slider of a parameter, in the unit in which its range was typed, or that suits it.

    Raises:
        ScenarioError: the loop has no such number or does not read it in a run, the range is none or does not
            hold the number's value, or a simulation would change other numbers with it.
    """
    check_path(path, entry, loop, ())
    field, value = field_at(loop, path), float(value_at(loop, path))
    low, high = both_ends(entry, field, value)
    read = {signal.path: signal for signal in unit.parameters}
    if others := sorted(set(read) & {one for end in (low, high) for one in also_set(loop, path, end)}):
        more = f" and {counted(len(others) - 1, 'other')}" if len(others) > 1 else ""
        problem = f"cannot be a slider: before a run, it decides {others[0]}{more}"
        raise ScenarioError(entry.origin.name, entry.key, problem)
    if path not in read:
        raise ScenarioError(entry.origin.name, entry.key, "is not a number that the exported loop reads")
    if not low <= value <= high:
        raise entry.error(f"must hold the value of the loop, {plain_quantity(value, field.unit)}")
    typed = typed_scales([(entry, field.unit)]).get(field.unit)
    return Slider(read[path], low, high, typed or scale_of([low, high], field.unit))


def also_set(loop: Loop, path: str, value: float) -> Iterator[str]:
    """The other numbers of a loop that a simulation has changed before it begins, where one is another."""
    before = dict(leaves(prepare_loop(loop)[1]))
    for other, found in leaves(prepare_loop(replace(loop, {path: value}))[1]):
        if other != path and not np.array_equal(
            np.asarray(found, float), np.asarray(before.get(other), float), equal_nan=True
        ):
            yield other


def recorded_paths(unit: CModule) -> list[str]:
    """The numbers of the loop's own state."""
    paths = [signal.path for signal in unit.states]
    return [path for path in paths if path.partition(".")[0] not in (METRICS, WATCH, *UNSEEN)]


def replay(
    unit: CModule,
    code: bytes,
    sliders: Sequence[Slider],
    run: PreparedRun,
    trace: Trace,
    report: Progress,
) -> Proof:
    """How many recorded samples WebAssembly repeats to the last bit, as it is and at the ends of all sliders.

    Raises:
        LoopError: it does not repeat one.
    """
    at = {signal.path: i for i, signal in enumerate(unit.states)}
    columns = {path: at[path] for path in run.wanted} | metric_columns(unit, trace)
    wasm, last, samples = WasmLoop(code, unit, len(sliders)), run.plan.samples - 1, 0
    for i, changes in enumerate(corners(sliders)):
        when = "".join(f"with {path} = {value!r}" for path, value in changes.items()) or "as it is"
        report(0.3 + 0.6 * i / (1 + 2 * len(sliders)), f"replaying it {when}")
        expected = run(changes) if changes else trace
        values = [changes.get(one.signal.path, one.signal.value) for one in sliders]
        found = wasm.replay(values, run.plan.samples, run.plan.stride)
        end = found.reached * unit.period if found.reached < last else math.nan
        if not np.array_equal(end, expected["diverged_at"], equal_nan=True):
            raise LoopError(f"nothing is written: {when}, the page diverges where the simulation does not")
        check_bits(found, expected, columns, when)
        samples += len(found.rows)
    return Proof(samples, "zig and wasmtime")


def metric_columns(unit: CModule, trace: Trace) -> dict[str, int]:
    """Where each metric that judges is among the numbers of the state."""
    at = {signal.path: i for i, signal in enumerate(unit.states)}
    places = zip(trace.metrics, metric_places(trace.loop), strict=False)
    return {name: at[place] for name, place in places if trace.fields[name].smaller_is_better}


def corners(sliders: Sequence[Slider]) -> Iterator[dict[str, float]]:
    """What is replayed: the loop as it is, and each slider at both ends."""
    yield {}
    for one in sliders:
        yield {one.signal.path: one.low}
        yield {one.signal.path: one.high}


def page_data(unit: CModule, sliders: Sequence[Slider], run: PreparedRun, trace: Trace) -> dict[str, Any]:
    """What the script of a page is told: numbers in SI units, each with the unit in which it is read."""
    at = {signal.path: i for i, signal in enumerate(unit.states)}
    signal = trace.loop.controls.declared()
    plots = [command := {"name": "command", "is": ["command"], **scaled(trace[SHOWN["command"]], "V")}]
    if not isinstance(trace.loop.controls, Command):
        values = [*trace[SHOWN["demand"]], *trace[SHOWN["signal"]]]
        error = trace[SHOWN["demand"]] - trace[SHOWN["signal"]]
        plots = [
            {"name": signal.meaning, "is": ["signal", "demand"], **scaled(values, signal.unit)},
            {"name": "error", "is": ["error"], **scaled(error, signal.unit)},
            command,
        ]
    return {
        "samples": run.plan.samples,
        "stride": run.plan.stride,
        "period": unit.period,
        "columns": {name: at[path] for name, path in SHOWN.items()},
        "width": len(unit.states),
        "plots": plots,
        "sliders": [slider_data(one) for one in sliders],
        "metrics": [
            {"meaning": (field := trace.fields[name]).meaning, "column": column}
            | scaled([trace[name]], field.unit)
            for name, column in metric_columns(unit, trace).items()
        ],
    }


def slider_data(one: Slider) -> dict[str, Any]:
    path, value = one.signal.path, one.signal.value
    about = {"path": path, "name": path.rpartition(".")[2].replace("_", " "), "meaning": one.signal.meaning}
    return about | {"low": one.low, "high": one.high, "value": value} | scale_data(one.scale)


def scaled(values: Any, unit: str) -> dict[str, Any]:
    """The unit in which some SI numbers are read."""
    return scale_data(scale_of(values, unit))


def scale_data(scale: Scale) -> dict[str, Any]:
    return {"unit": scale.label, "factor": scale.factor, "zero": scale.zero}


def machine_line(loop: Loop) -> str:
    """What a machine and its law are, in a line."""
    plant = (inspect.getdoc(type(loop.plant)) or type(loop.plant).__name__).partition("\n\n")[0]
    shown = [one for one in (loop.valve, loop.drive, loop.supply) if not isinstance(one, PLAIN)]
    names = [*map(in_words, shown), f"{in_words(loop.load)} load"]
    law = name_with_inner(loop.controller, "controller")
    label, factor = readable_unit("s", loop.simulation.period)
    sampled = f"{brief(factor * loop.simulation.period)} {label}"
    return f"{' '.join(plant.split())} With {enumeration(names)}. Law: {law}, sampled every {sampled}."


def in_words(block: Block) -> str:
    """The name of a block's class as words."""
    return snake_case(type(block).__name__).replace("_", " ")


def in_script(data: Mapping[str, Any]) -> str:
    """JSON that may stand in a script of HTML."""
    return json.dumps(data).replace("<", "\\u003c")
