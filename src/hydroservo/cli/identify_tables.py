"""What an identification found: on the terminal, and as JSON."""

from typing import Any

from rich.markup import escape
from rich.table import Table

from hydroservo._version import __version__
from hydroservo.cli.tables import show
from hydroservo.formatting import common_unit
from hydroservo.identification import Identified, LogFit
from hydroservo.runs.provenance import scenario_hash

__all__ = ["as_tables", "show_identified"]


def as_tables(found: Identified) -> dict[str, Any]:
    """The result as nested tables, in SI units."""
    return {
        "scenario": found.scenario,
        "hash": scenario_hash(found.loop),
        "version": __version__,
        "parameters": {path: one._asdict() for path, one in found.parameters.items()},
        "correlations": found.correlations.tolist(),
        "logs": [log_tables(fit) for fit in found.logs],
        "remarks": list(found.remarks),
        "evaluations": found.evaluations,
    }


def log_tables(fit: LogFit) -> dict[str, Any]:
    """How one log was understood and met."""
    segments = [
        {"start": one.start, "period": one.period, "samples": one.samples} for one in fit.understood.segments
    ]
    return {
        "log": fit.understood.log.name,
        "segments": segments,
        "delay": {"value": fit.delay[0], "deviation": fit.delay[1]},
        "signals": {
            name: {
                **one._asdict(),
                "offset": {"value": one.offset[0], "deviation": one.offset[1]},
            }
            for name, one in fit.signals.items()
        },
    }


def show_identified(found: Identified) -> None:
    """The numbers with their intervals, and how each signal is met."""
    show(parameters_table(found), *(signals_table(fit) for fit in found.logs))


def parameters_table(found: Identified) -> Table:
    shown = Table(title=escape(found.scenario), title_justify="left")
    shown.add_column("parameter", overflow="fold")
    for name in ("value", "from", "to", "unit"):
        shown.add_column(name, justify="right" if name != "unit" else "left", no_wrap=True)
    shown.add_column("the logs")
    for path, one in found.parameters.items():
        unit, factor = common_unit([one.value], one.unit)
        numbers = (f"{factor * number:.4g}" for number in (one.value, one.low, one.high))
        said = "[green]tell it[/]" if one.identifiable else "[bold yellow]do not tell it[/]"
        shown.add_row(escape(path), *numbers, unit, said + (", at an end of its range" if one.at_end else ""))
    shown.caption = "from and to: 95 % interval"
    return shown


def signals_table(fit: LogFit) -> Table:
    title = f"{fit.understood.log.name}: {1e3 * fit.delay[0]:.3g} ms late"
    shown = Table(title=escape(title), title_justify="left")
    shown.add_column("signal", no_wrap=True)
    for name in ("left, rms", "fitted part", "held out", "offset", "unit"):
        shown.add_column(name, justify="right" if name != "unit" else "left", no_wrap=True)
    shown.add_column("explained", justify="right")
    shown.add_column("white", justify="right")
    for name, one in fit.signals.items():
        unit, factor = common_unit([one.rms], one.unit)
        numbers = (f"{factor * x:.3g}" for x in (one.rms, one.held_in, one.held_out, one.offset[0]))
        shown.add_row(name, *numbers, unit, f"{100.0 * one.explained:.4g} %", f"{one.whiteness:.2g}")
    return shown
