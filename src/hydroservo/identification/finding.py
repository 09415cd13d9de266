"""What an identification says, with all that was asked beyond it, and what a log says."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydroservo._version import __version__
from hydroservo.core.formatting import Scale, quantity
from hydroservo.core.outputs import final_place, write_text
from hydroservo.identification.log import COMMAND, SIGNALS, TIME
from hydroservo.identification.segments import UnderstoodLog
from hydroservo.runs.provenance import origin_of_loop, scenario_hash
from hydroservo.scenario.ranges import typed_scales
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import logs_in, title_of

if TYPE_CHECKING:
    from hydroservo.core.errors import HydroservoError
    from hydroservo.figures.style import Plot
    from hydroservo.identification.conclusions import Comparison
    from hydroservo.identification.effects import LeftOutEffect
    from hydroservo.identification.proposal import Proposal
    from hydroservo.identification.result import Estimate, Identified, LogFit, SignalFit
    from hydroservo.scenario.tables import TableEntry

Typed = Mapping[str, Scale]
PROMISES = (Column("parameter"), *(Column("from"), Column("to"), UNIT), Column("times as narrow", digits=3))
COLUMNS = (*map(Column, ("signal", "column", "samples", "lowest", "highest")), UNIT)
CAPTION = "Each signal over time, as it is understood. Crosses: samples that stand out alone."
UNFIT = "THE MODEL DOES NOT FIT the logs, so they tell none of its numbers."
PARAMETERS = (Column("parameter"), *(Column("value"), Column("from"), Column("to"), UNIT), Column("the logs"))
SIGNAL_COLUMNS = (
    Column("signal"),
    *(Column(name, digits=3) for name in ("residual, rms", "fitted part", "held out", "offset")),
    UNIT,
    Column("explained", "%"),
    Column("p, white noise", digits=2),
)
EFFECTS = (
    Column("effect"),
    Column("amount", digits=3),
    Column("explains", "%", digits=2),
    Column("apart from the first"),
)
SOUGHT = "What was sought, and whether the logs tell it."
WHITE = "p: of the test by Ljung and Box that the residual is white noise."


class FurtherAnswers(NamedTuple):
    """What was asked beyond numbers and their intervals."""

    other: "Identified | None" = None  # another scenario, fitted to the same logs
    comparison: "Comparison | None" = None  # with it
    proposal: "Proposal | None" = None  # for the next log
    typed: Typed = MappingProxyType({})  # the units in which ranges were typed, by SI unit
    failure: "HydroservoError | None" = None  # why some of it is missing; None where nothing is

    def verdict(self) -> list[Line]:
        """Whether the larger of both models earns its numbers."""
        if self.comparison is None:
            return []
        lead, why = self.comparison.verdict, str(self.comparison)
        mark = Mark.GOOD if self.comparison.earns else Mark.DOUBTFUL
        return [Line(lead, f"{why.removeprefix(lead)}.", mark)]

    def remarks(self, identified: "Identified") -> list[str]:
        """What a user should know of the other scenario alone."""
        if self.other is None:
            return []
        own = [line for line in self.other.remarks if line not in identified.remarks]
        return [f"{self.other.scenario}: {line}" for line in own]

    def tables(self, identified: "Identified") -> list[Table]:
        """What is held out, missed by both models; and what would become of each interval."""
        tables = [] if self.comparison is None else [comparison_table(identified, self.comparison)]
        return tables if self.proposal is None else [*tables, proposal_table(self.proposal, self.typed)]

    def numbers(self) -> dict[str, Any]:
        """All numbers of it, in SI units."""
        numbers: dict[str, Any] = {}
        if self.comparison is not None:
            held = {" ".join(key): list(both) for key, both in self.comparison.held_out.items()}
            numbers["comparison"] = self.comparison._asdict() | {"held_out": held}
        if self.proposal is not None:
            one = self.proposal
            promises = {path: each._asdict() for path, each in one.promises.items()}
            kept = {"promises": promises, "reached": one.reached, "bounds": one.bounds}
            numbers["proposal"] = {"name": one.name, "asked": list(one.asked), **kept}
        return numbers


NO_FURTHER_ANSWERS = FurtherAnswers()


def typed_units(identified: "Identified", ranges: "Mapping[str, TableEntry]") -> dict[str, Scale]:
    """The units in which ranges were typed, by SI unit: those given, and those of the scenario."""
    every = {**identified.fitted.assembly.log_ranges, **ranges}
    return typed_scales((every[path], one.unit) for path, one in identified.parameters.items())


def typed_cells(values: Iterable[float], unit: str, typed: Typed) -> list[Cell]:
    """Numbers with their SI unit; those without one in the unit that was typed, such as %."""
    scale = None if unit else typed.get(unit)
    return [Cell(scale.of(one), scale.label) if scale else Cell(one, unit) for one in values]


def comparison_table(identified: "Identified", comparison: "Comparison") -> Table:
    """What is held out of each signal, missed by both models."""
    units = {
        (fit.understood.log.name, name): one.unit
        for fit in identified.logs
        for name, one in fit.signals.items()
    }
    single = len(identified.logs) == 1
    rows = [
        [Cell(name if single else f"{name}, {log}"), *(Cell(one, units[log, name]) for one in both), Cell()]
        for (log, name), both in comparison.held_out.items()
    ]
    errors = (Column(name, digits=3) for name in (comparison.larger, comparison.smaller))
    title = "What is held out of each signal, missed by both scenarios (rms)."
    return Table("comparison", (Column("signal"), *errors, UNIT), rows, title)


def proposal_table(proposal: "Proposal", typed: Typed) -> Table:
    """What would become of each interval."""
    rows = [
        [Cell(path), *typed_cells((one.low, one.high), one.unit, typed), Cell(), Cell(one.times)]
        for path, one in proposal.promises.items()
    ]
    title = f"What a log of the proposed command would tell: {proposal.name}."
    note = "From and to: 95 % interval that it would leave, about what was found."
    return Table("proposal", PROMISES, rows, title, note, typed=typed)


def log_finding(whole: UnderstoodLog, logs: Sequence[Path] = ()) -> Finding:
    """What a log says."""
    numbers = signal_numbers(whole)
    lacks = [] if COMMAND in whole.log.signals else ["the log has no command, which identify needs"]
    return Finding(
        f"Log {whole.log.name}",
        rate_lines(numbers),
        [*whole.remarks, *lacks],
        [Table("signals", COLUMNS, signal_rows(numbers["signals"]), "The signals of the log.")],
        [Picture("log", CAPTION, partial(draw_signals, whole))],
        numbers,
        logs=logs_in(logs),
    )


def draw_signals(whole: UnderstoodLog) -> "Plot":
    from hydroservo.figures.identified import plot_log

    return plot_log(whole)


def signal_numbers(whole: UnderstoodLog) -> dict[str, Any]:
    """All numbers of a log, in SI units."""
    signals = {TIME: whole.log.time, **whole.log.signals}
    return {
        "log": whole.log.name,
        "signals": {name: signal_summary(whole, name, values) for name, values in signals.items()},
        "period": float(np.median([one.period for one in whole.segments])),
        "stretches": [
            {"from": one.start, "to": float(one.time[-1]), "samples": one.samples} for one in whole.segments
        ],
        "unused": list(whole.log.unused),
        "remarks": list(whole.remarks),
        "version": __version__,
    }


def signal_summary(
    whole: UnderstoodLog, name: str, values: "np.ndarray[Any, np.dtype[np.float64]]"
) -> dict[str, Any]:
    """The column of a signal, and its range where it has samples."""
    samples = values[np.isfinite(values)]
    ends = {"lowest": float(samples.min()), "highest": float(samples.max())} if samples.size else {}
    column = whole.log.columns.get(name, "")
    return {"column": column, "unit": SIGNALS[name].unit, "samples": int(samples.size), **ends}


def signal_rows(signals: Mapping[str, Mapping[str, Any]]) -> list[list[Cell]]:
    """Of each signal its column, its number of samples, and the lowest and the highest."""
    return [
        [
            *(Cell(name), Cell(one["column"]), Cell(one["samples"])),
            *(Cell(one.get(end), one["unit"]) for end in ("lowest", "highest")),
            Cell(),
        ]
        for name, one in signals.items()
    ]


def rate_lines(numbers: Mapping[str, Any]) -> list[Line]:
    """How often a log is sampled, and where it has gaps."""
    period, stretches = numbers["period"], numbers["stretches"]
    rate = f"A sample every {1e3 * period:.6g} ms ({1.0 / period:.6g} Hz)"
    if len(stretches) == 1:
        return [Line(f"{rate}, without a gap of more than a few samples.")]
    spans = (f"{one['from']:.4g} to {one['to']:.4g} s" for one in stretches)
    return [Line(f"{rate}, in {len(stretches)} stretches between gaps: {', '.join(spans)}.")]


def identified_finding(
    identified: "Identified", further: FurtherAnswers = NO_FURTHER_ANSWERS, logs: Sequence[Path] = ()
) -> Finding:
    """What an identification says."""
    name = identified.scenario
    return Finding(
        title_of("Identification", name),
        [*lead_lines(identified), *further.verdict()],
        [*(one for one in identified.remarks if one != UNFIT), *further.remarks(identified)],
        finding_tables(identified, further),
        [*fit_pictures(identified)],
        {**identification_numbers(identified), **further.numbers()},
        {"scenario.toml": lambda path: write_text(path, identified.toml(final_place(path).parent))},
        [
            origin_of_loop(name, identified.fitted.assembly.loop),
            origin_of_loop(f"{name}, with what was found", identified.loop),
        ],
        logs_in(logs),
    )


def lead_lines(identified: "Identified") -> list[Line]:
    """The numbers that the logs tell, and those that they do not, in a sentence each."""
    sure = {path: one for path, one in identified.parameters.items() if one.identifiable}
    unsure = [path for path in identified.parameters if path not in sure]
    lines = [] if identified.fits else [Line(UNFIT, mark=Mark.BAD)]
    if sure:
        numbers = "; ".join(f"{path} is {estimate_text(one)}" for path, one in sure.items())
        lines.append(Line(f"{numbers}, with 95 % intervals."))
    if identified.fits and unsure:
        lines.append(Line("The logs do not tell", f" {', '.join(unsure)}.", Mark.DOUBTFUL))
    return lines


def estimate_text(one: "Estimate") -> str:
    value, low, high = (quantity(number, one.unit) for number in (one.value, one.low, one.high))
    return f"{value} ({low} to {high})"


def finding_tables(identified: "Identified", further: FurtherAnswers) -> list[Table]:
    """The numbers with their intervals, how each signal is met, and what else was asked."""
    judged = identified.horizon is None
    return [
        parameters_table(identified, further.typed),
        *(signals_table(i, fit, judged=judged) for i, fit in enumerate(identified.logs, 1)),
        *([effects_table(identified.effects)] if identified.effects else []),
        *further.tables(identified),
    ]


def parameters_table(identified: "Identified", typed: Typed) -> Table:
    """What was sought or freed, each with its interval where the model fits."""
    rows = []
    for path, one in {**identified.parameters, **identified.uncertain}.items():
        ends = (one.low, one.high) if identified.fits else (math.nan, math.nan)
        verdict = verdict_cell(one, freed=path in identified.uncertain)
        numbers = typed_cells((one.value, *ends), one.unit, typed)
        rows.append([Cell(path), *numbers, Cell(), verdict])
    notes = ["From and to: 95 % interval."] if identified.fits else []
    notes += ["Freed: within its [uncertainty]."] if identified.uncertain else []
    return Table("parameters", PARAMETERS, rows, SOUGHT, " ".join(notes), typed=typed)


def verdict_cell(one: "Estimate", *, freed: bool) -> Cell:
    """What the logs do of a number."""
    text = "freed" if freed else "tell it" if one.identifiable else "do not tell it"
    if one.at_end:
        return Cell(f"{text}, at an end of its range", mark=Mark.DOUBTFUL)
    return Cell(text, mark=None if freed else Mark.GOOD if one.identifiable else Mark.DOUBTFUL)


def signals_table(number: int, fit: "LogFit", *, judged: bool) -> Table:
    """How each signal of a log is met; whether the model fits it is judged of simulations alone."""
    columns = (*SIGNAL_COLUMNS, Column("model")) if judged else SIGNAL_COLUMNS
    rows = [signal_row(name, one)[: len(columns)] for name, one in fit.signals.items()]
    note = f"Delay of what is measured against the command: {quantity(fit.delay[0], 's')}. {WHITE}"
    return Table(
        f"signals-{number}", columns, rows, f"How well the model meets {fit.understood.log.name}.", note
    )


def signal_row(name: str, one: "SignalFit") -> list[Cell]:
    """How a signal is met, and whether the model fits it."""
    return [
        Cell(name),
        *(Cell(number, one.unit) for number in (one.rms, one.held_in, one.held_out, one.offset[0])),
        Cell(),
        Cell(100.0 * one.explained, "%"),
        Cell(one.whiteness),
        Cell("does not fit", mark=Mark.BAD) if one.problem else Cell("fits", mark=Mark.GOOD),
    ]


def effects_table(effects: "Sequence[LeftOutEffect]") -> Table:
    """What the model may miss."""
    rows = [
        [
            Cell(one.name),
            Cell(one.amount, one.unit),
            Cell(100.0 * one.share, "%"),
            Cell(not one.alike if i else None),
        ]
        for i, one in enumerate(effects)
    ]
    return Table("effects", EFFECTS, rows, "What the model may miss.", "Explains: share of what is left.")


def fit_pictures(identified: "Identified") -> Iterator[Picture]:
    """Each log as it is met and as it was understood."""
    for i, fit in enumerate(identified.logs, 1):
        name = fit.understood.log.name
        yield fit_picture(f"fit-{i}", fit)
        yield Picture(f"log-{i}", f"How {name} was understood.", partial(draw_signals, fit.understood))


def log_fit_finding(fit: "LogFit") -> Finding:
    """How one log of an identification is met."""
    table = signals_table(1, fit, judged=fit.horizon is None)
    return Finding(fit.understood.log.name, [], [], [table], [fit_picture("fit", fit)], log_numbers(fit))


def fit_picture(name: str, fit: "LogFit") -> Picture:
    shown = "simulated" if fit.horizon is None else "predicted"
    caption = f"How {fit.understood.log.name} is met: measured, and {shown} with what was found."
    return Picture(name, caption, partial(draw_fit, fit))


def draw_fit(fit: "LogFit") -> "Plot":
    from hydroservo.figures.identified import plot_fit

    return plot_fit(fit)


def identification_numbers(identified: "Identified") -> dict[str, Any]:
    """All numbers of an identification, in SI units."""
    ends = {} if identified.fits else {"low": None, "high": None}
    return {
        "scenario": identified.scenario,
        "hash": scenario_hash(identified.loop),
        "version": __version__,
        "fits": identified.fits,
        "parameters": {path: one._asdict() | ends for path, one in identified.parameters.items()},
        "uncertain": {path: one._asdict() | ends for path, one in identified.uncertain.items()},
        "effects": [one._asdict() for one in identified.effects],
        "correlations": identified.correlations.tolist(),
        "logs": [log_numbers(fit) for fit in identified.logs],
        "remarks": list(identified.remarks),
        "evaluations": identified.evaluations,
        "horizon": identified.horizon,
    }


def log_numbers(fit: "LogFit") -> dict[str, Any]:
    """How a log was understood and met."""
    segments = [
        {"start": one.start, "period": one.period, "samples": one.samples} for one in fit.understood.segments
    ]
    signals = {
        name: one._asdict() | {"offset": {"value": one.offset[0], "deviation": one.offset[1]}}
        for name, one in fit.signals.items()
    }
    delay = {"value": fit.delay[0], "deviation": fit.delay[1]}
    return {"log": fit.understood.log.name, "segments": segments, "delay": delay, "signals": signals}
