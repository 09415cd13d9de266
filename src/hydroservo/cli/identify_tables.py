"""What an identification found: on the terminal, and as JSON."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

from rich.markup import escape
from rich.table import Table

from hydroservo._version import __version__
from hydroservo.formatting import NONE, Scale, number, quantity, scales_of
from hydroservo.identification import Comparison, Identified, LogFit, Proposal
from hydroservo.identification.left_out import Effect
from hydroservo.identification.result import UNFIT, Estimate
from hydroservo.runs.provenance import scenario_hash
from hydroservo.scenario.ranges import typed_scales
from hydroservo.scenario.tables import Entry

LEAST = 1e-6  # probability of white residuals that is shown


class Further(NamedTuple):
    """What was asked beyond numbers and their intervals.

    Attributes:
        other: another scenario, fitted to the same logs.
        comparison: with it.
        proposal: for the next log.
        typed: the units in which ranges were typed, by SI unit.
    """

    other: Identified | None = None
    comparison: Comparison | None = None
    proposal: Proposal | None = None
    typed: Mapping[str, Scale] = MappingProxyType({})


def typed_units(found: Identified, ranges: Mapping[str, Entry]) -> dict[str, Scale]:
    """The units in which ranges were typed, by SI unit: those given, and those of the scenario."""
    every = {**found.fitted.assembly.log_ranges, **ranges}
    return typed_scales((every[path], one.unit) for path, one in found.parameters.items())


def as_tables(found: Identified, more: Further) -> dict[str, Any]:
    """The result as nested tables, in SI units."""
    comparison, proposal = more.comparison, more.proposal
    ends = {} if found.fits else {"low": None, "high": None}
    tables: dict[str, Any] = {
        "scenario": found.scenario,
        "hash": scenario_hash(found.loop),
        "version": __version__,
        "fits": found.fits,
        "parameters": {path: one._asdict() | ends for path, one in found.parameters.items()},
        "uncertain": {path: one._asdict() | ends for path, one in found.uncertain.items()},
        "effects": [one._asdict() for one in found.effects],
        "correlations": found.correlations.tolist(),
        "logs": [log_tables(fit) for fit in found.logs],
        "remarks": list(found.remarks),
        "evaluations": found.evaluations,
        "horizon": found.horizon,
    }
    if comparison:
        held = {" ".join(key): list(both) for key, both in comparison.held_out.items()}
        tables["comparison"] = comparison._asdict() | {"held_out": held}
    if proposal:
        promises = {path: one._asdict() for path, one in proposal.promises.items()}
        kept = {"promises": promises, "reached": proposal.reached, "bounds": proposal.bounds}
        tables["proposal"] = {"name": proposal.name, "asked": list(proposal.asked), **kept}
    return tables


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


def tables_of(found: Identified, more: Further) -> dict[str, Table]:
    """The numbers with their intervals, how each signal is met, and what else was asked, by name."""
    tables = {"parameters": parameters_table(found, more.typed)}
    tables |= {
        f"signals-{i}": signals_table(fit, judged=found.horizon is None)
        for i, fit in enumerate(found.logs, 1)
    }
    if found.effects:
        tables["effects"] = effects_table(found.effects)
    if more.comparison:
        tables["comparison"] = comparison_table(found, more.comparison)
    if more.proposal:
        tables["proposal"] = proposal_table(more.proposal, more.typed)
    return tables


def comparison_table(found: Identified, comparison: Comparison) -> Table:
    """What is held out of each signal, missed by both models; the verdict below."""
    shown = Table(title="held out, missed by rms", title_justify="left")
    shown.add_column("signal", no_wrap=True)
    for name in (comparison.larger, comparison.smaller):
        shown.add_column(escape(name), justify="right", overflow="fold")
    shown.add_column("unit", no_wrap=True)
    units = {
        (fit.understood.log.name, name): one.unit for fit in found.logs for name, one in fit.signals.items()
    }
    scales = scales_of((units[key], both) for key, both in comparison.held_out.items())
    for key, both in comparison.held_out.items():
        scale = scales[units[key]]
        label = key[1] if len(found.logs) == 1 else f"{key[1]}, {key[0]}"
        shown.add_row(escape(label), *(number(scale.of(value)) for value in both), scale.label)
    shown.caption, shown.caption_justify = escape(str(comparison)), "left"
    return shown


def proposal_table(proposal: Proposal, typed: Mapping[str, Scale]) -> Table:
    """What would become of each interval."""
    shown = Table(title=escape(f"proposed: {proposal.name}"), title_justify="left")
    shown.add_column("parameter", overflow="fold")
    for name in ("from", "to", "unit", "narrower"):
        shown.add_column(name, justify="right" if name != "unit" else "left", no_wrap=True)
    scales = scales_of(((one.unit, (one.low, one.high)) for one in proposal.promises.values()), typed)
    for path, one in proposal.promises.items():
        scale = scales[one.unit]
        numbers = (number(scale.of(value), 4) for value in (one.low, one.high))
        shown.add_row(escape(path), *numbers, scale.label, f"{number(one.times)} times")
    shown.caption = "from and to: 95 % interval that a log of it would leave, about what was found"
    return shown


def parameters_table(found: Identified, typed: Mapping[str, Scale]) -> Table:
    shown = Table(title=escape(found.scenario), title_justify="left")
    shown.add_column("parameter", overflow="fold")
    for name in ("value", "from", "to", "unit"):
        shown.add_column(name, justify="right" if name != "unit" else "left", no_wrap=True)
    shown.add_column("the logs")
    every = {**found.parameters, **found.uncertain}
    scales = scales_of(((one.unit, [one.value]) for one in every.values()), typed)
    for path, one in every.items():
        scale = scales[one.unit]
        numbers = [number(scale.of(value), 4) for value in (one.value, one.low, one.high)]
        if not found.fits:
            numbers[1:] = [NONE, NONE]
        last = path in found.parameters and path == [*found.parameters][-1]
        shown.add_row(
            escape(path), *numbers, scale.label, verdict(one, path in found.uncertain), end_section=last
        )
    shown.caption = "from and to: 95 % interval" if found.fits else UNFIT
    return shown


def verdict(one: Estimate, uncertain: bool) -> str:
    """What the logs do of a number."""
    end = ", [bold yellow]at an end of its range[/]" if one.at_end else ""
    if uncertain:
        return f"freed within its \\[uncertainty]{end}"
    return ("[green]tell it[/]" if one.identifiable else "[bold yellow]do not tell it[/]") + end


def effects_table(effects: Sequence[Effect]) -> Table:
    """What the model may miss."""
    shown = Table(title="What the model may miss", title_justify="left")
    shown.add_column("effect", overflow="fold")
    for name in ("amount", "explains"):
        shown.add_column(name, justify="right", no_wrap=True)
    shown.add_column("apart from the first")
    for i, one in enumerate(effects):
        amount = NONE if math.isnan(one.amount) else quantity(one.amount, one.unit)
        apart = "" if not i else "no" if one.alike else "yes"
        shown.add_row(escape(one.name), amount, f"{number(100.0 * one.share, 2)} %", apart)
    shown.caption = "explains: of what is left"
    return shown


def signals_table(fit: LogFit, *, judged: bool) -> Table:
    """How each signal of a log is met; whether the model fits it is judged of simulations alone."""
    title = f"{fit.understood.log.name}: {number(1e3 * fit.delay[0])} ms late"
    shown = Table(title=escape(title), title_justify="left")
    shown.add_column("signal", no_wrap=True)
    for name in ("left, rms", "fitted part", "held out", "offset", "unit"):
        shown.add_column(name, justify="right" if name != "unit" else "left", no_wrap=True)
    shown.add_column("explained", justify="right")
    shown.add_column("white", justify="right")
    shown.add_column("model")
    scales = scales_of((one.unit, [one.rms]) for one in fit.signals.values())
    for name, one in fit.signals.items():
        scale = scales[one.unit]
        numbers = (number(scale.of(x)) for x in (one.rms, one.held_in, one.held_out, one.offset[0]))
        explained = number(100.0 * one.explained, 4)
        white = number(one.whiteness, 2) if one.whiteness >= LEAST else f"< {number(LEAST)}"
        model = ("[bold yellow]does not fit[/]" if one.problem else "fits") if judged else NONE
        shown.add_row(name, *numbers, scale.label, f"{explained} %", white, model)
    return shown
