"""The part of a batch's result that fits on a screen."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from rich.markup import escape
from rich.table import Table

from hydroservo.cli.tables import as_text, show
from hydroservo.field import Field
from hydroservo.formatting import Scale, scales_of
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.results import metric_fields
from hydroservo.runs.spreads import Spread, spreads_of
from hydroservo.scenario.ranges import typed_scales
from hydroservo.scenario.sampling import Variation

if TYPE_CHECKING:
    import xarray as xr


class BatchSummary(NamedTuple):
    """What identifies a batch, what varied, and how its metrics are spread; what ``--json`` has."""

    scenario: str  # as the user named it
    hash: str
    version: str
    seed: int  # of the draws
    runs: int
    varied: Mapping[str, tuple[float, float]]
    metrics: Mapping[str, Spread]
    diverged: int
    stroke_left: int
    oscillating: int
    warnings: Sequence[str]
    typed: Mapping[str, Scale]  # units in which ranges were typed, by SI unit

    def as_tables(self) -> dict[str, Any]:
        """What ``--json`` prints."""
        metrics = {name: spread._asdict() for name, spread in self.metrics.items()}
        return {name: one for name, one in self._asdict().items() if name != "typed"} | {"metrics": metrics}


def batch_summary(
    scenario: str,
    seed: int,
    table: "xr.Dataset",
    varied: Mapping[str, tuple[float, float]],
    entries: Sequence[Variation],
) -> BatchSummary:
    """The summary of a batch, from its table."""
    return BatchSummary(
        scenario=scenario,
        hash=table.attrs["hash"],
        version=table.attrs["version"],
        seed=seed,
        runs=table.sizes["run"],
        varied=varied,
        metrics=spreads_of(table),
        diverged=int(table["diverged"].sum()),
        stroke_left=int(table["stroke_left"].sum()) if "stroke_left" in table else 0,
        oscillating=int((table["oscillation_command"] > 0.0).sum()) if "oscillation_command" in table else 0,
        warnings=warnings_of(table),
        typed=typed_scales((one.entry, table[one.path].attrs["units"]) for one in entries),
    )


def remarkable_run(table: "xr.Dataset", metric: str) -> tuple[int, str]:
    """The run that one would look at first, and why: the first that diverged, else the worst."""
    lost = np.flatnonzero(table["diverged"].values)
    if lost.size:
        return int(lost[0]), "diverged"
    values = table[metric].values
    if not np.isfinite(values).any():
        return 0, "is the first"
    least = metric_fields(table)[metric].least_is_worst
    worst = np.nanargmin(values) if least else np.nanargmax(values)
    return int(worst), f"has the worst {metric}"


def show_batch(summary: BatchSummary, table: "xr.Dataset", seconds: float, computed: int) -> None:
    """What varied, how the metrics are spread, how many runs failed, and how fast they were computed."""
    fields = metric_fields(table)
    show(ranges_table(summary, table), spreads_table(summary, fields), *verdicts(summary, fields))
    if computed:
        there = f"; {summary.runs - computed:,} were there before" if computed < summary.runs else ""
        speed = f"{rate(computed / seconds)} runs per second, compilation included"
        show(f"{seconds:.3g} s, {speed}{there}")
    else:
        show("all runs were there before")


def rate(value: float) -> str:
    """Runs per second: three digits, and no power of ten."""
    return f"{value:,.0f}" if value >= 99.5 else f"{value:.3g}"


def ranges_table(summary: BatchSummary, table: "xr.Dataset") -> Table:
    """Between which ends what varied was drawn, in the units in which that was typed."""
    runs = "1 run" if summary.runs == 1 else f"{summary.runs:,} runs"
    heading = f"{escape(summary.scenario)}   (hash {summary.hash}, {runs}, drawn with seed {summary.seed})"
    shown = Table(title=heading, title_justify="left")
    shown.add_column("varied", no_wrap=True)
    for name in ("from", "to"):
        shown.add_column(name, justify="right", no_wrap=True)
    shown.add_column("unit", no_wrap=True)
    shown.add_column("meaning")
    rows = ((table[path].attrs["units"], ends) for path, ends in summary.varied.items())
    scales = scales_of(rows, summary.typed)
    for path, ends in summary.varied.items():
        about = table[path].attrs
        scale = scales[about["units"]]
        shown.add_row(escape(path), *(as_text(end, scale) for end in ends), scale.label, about["long_name"])
    return shown


def spreads_table(summary: BatchSummary, fields: Mapping[str, Field]) -> Table:
    """How the metrics are spread over the runs."""
    note = "of the runs that did not diverge" if summary.diverged else None
    shown = Table(caption=note, caption_justify="left")
    shown.add_column("metric", no_wrap=True)
    for name in ("5 %", "median", "95 %", "worst"):
        shown.add_column(name, justify="right", no_wrap=True)
    shown.add_column("unit", no_wrap=True)
    shown.add_column("meaning")
    scales = scales_of((fields[name].unit, values) for name, values in summary.metrics.items())
    for name, values in summary.metrics.items():
        field = fields[name]
        scale = scales[field.unit]
        shown.add_row(name, *(as_text(value, scale) for value in values), scale.label, field.meaning)
    return shown


def verdicts(summary: BatchSummary, fields: Mapping[str, Field]) -> list[str]:
    """In a line each: how many runs diverged, left the stroke, and oscillate to the end."""
    lines = []
    if summary.diverged:
        tally = share(summary.diverged, summary.runs)
        lines.append(f"[bold red]DIVERGED[/]: {tally}: {fields['diverged'].meaning}.")
    if summary.stroke_left:
        lines.append(f"[bold yellow]LEFT THE STROKE[/]: {share(summary.stroke_left, summary.runs)}.")
    if summary.oscillating:
        lines.append(f"[bold yellow]OSCILLATES[/] to the end: {share(summary.oscillating, summary.runs)}.")
    if lines:
        return lines
    stroke = ", and no piston left its stroke" if "stroke_left" in fields else ""
    return [f"[green]No run diverged{stroke}.[/]"]


def share(count: int, runs: int) -> str:
    return f"{count:,} of {runs:,} runs ({100.0 * count / runs:.3g} %)"
