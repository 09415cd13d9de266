"""What a log says as it is understood: its signals and their ranges, its rate and its gaps."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hydroservo._version import __version__
from hydroservo.identification.segments import Understood
from hydroservo.identification.signals import COMMAND, SIGNALS, TIME
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Picture, Table
from hydroservo.show.finding import logs_of

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot

COLUMNS = (*map(Column, ("signal", "column", "samples", "lowest", "highest")), UNIT)
CAPTION = "Each signal over time, as it is understood. Crosses: samples that stand out alone."


def log_finding(whole: Understood, logs: Sequence[Path] = ()) -> Finding:
    """What a log says.

    Args:
        whole: the log.
        logs: its file.
    """
    numbers = numbers_of(whole)
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


def numbers_of(whole: Understood) -> dict[str, Any]:
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
