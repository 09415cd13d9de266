"""What an identification says, and what a log says as it is understood."""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hydroservo._version import __version__
from hydroservo.core.formatting import quantity
from hydroservo.core.outputs import final_place, write_text
from hydroservo.identification.further import NOTHING_FURTHER, Further, Typed, cells
from hydroservo.identification.log import COMMAND, SIGNALS, TIME
from hydroservo.identification.segments import Understood
from hydroservo.runs.provenance import origin_of_loop, scenario_hash
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import logs_of, title_of

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot
    from hydroservo.identification.left_out import Effect
    from hydroservo.identification.result import Estimate, Identified, LogFit, SignalFit

COLUMNS = (*map(Column, ("signal", "column", "samples", "lowest", "highest")), UNIT)
CAPTION = "Each signal over time, as it is understood. Crosses: samples that stand out alone."
UNFIT = "THE MODEL DOES NOT FIT the logs, so they tell none of its numbers."
PARAMETERS = (
    Column("parameter"),
    *(Column("value"), Column("from"), Column("to"), UNIT),
    Column("the logs"),
)
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


def log_finding(whole: Understood, logs: Sequence[Path] = ()) -> Finding:
    """What a log says."""
    numbers = numbers_of_signals(whole)
    lacks = [] if COMMAND in whole.log.signals else ["the log has no command, which identify needs"]
    return Finding(
        f"Log {whole.log.name}",
        rate_lines(numbers),
        [*whole.remarks, *lacks],
        [Table("signals", COLUMNS, signal_rows(numbers["signals"]), "The signals of the log.")],
        [Picture("log", CAPTION, partial(drawn_log, whole))],
        numbers,
        logs=logs_of(logs),
    )


def drawn_log(whole: Understood) -> "Plot":
    from hydroservo.figures.identified import plot_log

    return plot_log(whole)


def numbers_of_signals(whole: Understood) -> dict[str, Any]:
    """All numbers of a log, in SI units."""
    signals = {TIME: whole.log.time, **whole.log.signals}
    return {
        "log": whole.log.name,
        "signals": {name: about(whole, name, values) for name, values in signals.items()},
        "period": float(np.median([one.period for one in whole.segments])),
        "stretches": [
            {"from": one.start, "to": float(one.time[-1]), "samples": one.samples} for one in whole.segments
        ],
        "unused": list(whole.log.unused),
        "remarks": list(whole.remarks),
        "version": __version__,
    }


def about(whole: Understood, name: str, values: "np.ndarray[Any, np.dtype[np.float64]]") -> dict[str, Any]:
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
    identified: "Identified", further: Further = NOTHING_FURTHER, logs: Sequence[Path] = ()
) -> Finding:
    """What an identification says."""
    name = identified.scenario
    return Finding(
        title_of("Identification", name),
        [*lead_of(identified), *further.verdict()],
        [*(one for one in identified.remarks if one != UNFIT), *further.remarks(identified)],
        tables_of(identified, further),
        [*pictures(identified)],
        {**numbers_of(identified), **further.numbers()},
        {"scenario.toml": lambda path: write_text(path, identified.toml(final_place(path).parent))},
        [
            origin_of_loop(name, identified.fitted.assembly.loop),
            origin_of_loop(f"{name}, with what was found", identified.loop),
        ],
        logs_of(logs),
    )


def lead_of(identified: "Identified") -> list[Line]:
    """The numbers that the logs tell, and those that they do not, in a sentence each."""
    sure = {path: one for path, one in identified.parameters.items() if one.identifiable}
    unsure = [path for path in identified.parameters if path not in sure]
    lines = [] if identified.fits else [Line(UNFIT, mark=Mark.BAD)]
    if sure:
        numbers = "; ".join(f"{path} is {with_interval(one)}" for path, one in sure.items())
        lines.append(Line(f"{numbers}, with 95 % intervals."))
    if identified.fits and unsure:
        lines.append(Line("The logs do not tell", f" {', '.join(unsure)}.", Mark.DOUBTFUL))
    return lines


def with_interval(one: "Estimate") -> str:
    value, low, high = (quantity(number, one.unit) for number in (one.value, one.low, one.high))
    return f"{value} ({low} to {high})"


def tables_of(identified: "Identified", further: Further) -> list[Table]:
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
        verdict = verdict_on(one, freed=path in identified.uncertain)
        numbers = cells((one.value, *ends), one.unit, typed)
        rows.append([Cell(path), *numbers, Cell(), verdict])
    notes = ["From and to: 95 % interval."] if identified.fits else []
    notes += ["Freed: within its [uncertainty]."] if identified.uncertain else []
    return Table("parameters", PARAMETERS, rows, SOUGHT, " ".join(notes), typed=typed)


def verdict_on(one: "Estimate", *, freed: bool) -> Cell:
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


def effects_table(effects: "Sequence[Effect]") -> Table:
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


def pictures(identified: "Identified") -> Iterator[Picture]:
    """Each log as it is met and as it was understood."""
    for i, fit in enumerate(identified.logs, 1):
        name = fit.understood.log.name
        yield fit_picture(f"fit-{i}", fit)
        yield Picture(f"log-{i}", f"How {name} was understood.", partial(drawn_log, fit.understood))


def log_fit_finding(fit: "LogFit") -> Finding:
    """How one log of an identification is met."""
    table = signals_table(1, fit, judged=fit.horizon is None)
    return Finding(fit.understood.log.name, [], [], [table], [fit_picture("fit", fit)], numbers_of_log(fit))


def fit_picture(name: str, fit: "LogFit") -> Picture:
    """How a log is met."""
    shown = "simulated" if fit.horizon is None else "predicted"
    caption = f"How {fit.understood.log.name} is met: measured, and {shown} with what was found."
    return Picture(name, caption, partial(drawn_fit, fit))


def drawn_fit(fit: "LogFit") -> "Plot":
    from hydroservo.figures.identified import plot_fit

    return plot_fit(fit)


def numbers_of(identified: "Identified") -> dict[str, Any]:
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
        "logs": [numbers_of_log(fit) for fit in identified.logs],
        "remarks": list(identified.remarks),
        "evaluations": identified.evaluations,
        "horizon": identified.horizon,
    }


def numbers_of_log(fit: "LogFit") -> dict[str, Any]:
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
