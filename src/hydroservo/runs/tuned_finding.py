"""What a search for gains says."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from hydroservo._version import __version__
from hydroservo.core.formatting import quantity
from hydroservo.runs.aims import geometric_mean
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.provenance import origin_of_loop
from hydroservo.runs.run_finding import steps_line
from hydroservo.runs.titles import controller_title
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import title_of

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot
    from hydroservo.runs.tuned import Tuned

CAPTION = "The metric with the values the scenarios have, and with the best ones."
FRONT = "The least error that candidates within the bounds have for the activity of their command."
RANGES = "The best values, and the ranges that were searched."
DIVERGED = Cell("diverged", mark=Mark.BAD)


def tuned_finding(
    tuned: "Tuned", scenarios: Sequence[str] = (), command: str = "", replay: str = ""
) -> Finding:
    """What a search for gains says.

    Args:
        tuned: what ``tune`` returned.
        scenarios: that were tuned together, by name.
        command: that searched.
        replay: the command that runs the best values.
    """
    runs = [*zip(tuned.names, tuned.tables, strict=True)]
    seed = " and the first seed" if tuned.aim.seeds > 1 else ""
    tables = [gains_table(tuned), metrics_table(tuned)]
    return Finding(
        title_of("Gains", ", ".join(scenarios) or controller_title(tuned.tables[0])),
        [
            change_line(tuned),
            *verdicts(tuned),
            Line(f"{tuned.runs:,} closed loops were simulated."),
            *([Line(f"With these values{seed}:", command=replay)] if replay else []),
            *(
                line._replace(lead=f"{name}: {line.lead}")
                for name, run in runs
                for line in steps_line(run.attrs)
            ),
        ],
        [f"{name}: {line}" for name, run in runs for line in warnings_of(run)],
        [*tables, tuned.margins[0].table(tuned.margins)] if tuned.margins else tables,
        [
            Picture("tuned", CAPTION, lambda: drawn(tuned)),
            Picture("front", FRONT, lambda: drawn_front(tuned)),
        ],
        numbers_of(tuned, command),
        origins=[origin_of_loop(*one) for one in zip(tuned.names, tuned.aim.loops, strict=False)],
    )


def drawn(tuned: "Tuned") -> "Plot":
    from hydroservo.figures.tuned import plot_tuned

    return plot_tuned(tuned)


def drawn_front(tuned: "Tuned") -> "Plot":
    from hydroservo.figures.tuned import plot_front

    return plot_front(tuned)


def unit_of(tuned: "Tuned", name: str) -> str:
    """The SI unit of a metric, or of a number that was searched."""
    return str(tuned.tables[0][name].attrs["units"])


def weights_of(tuned: "Tuned") -> Sequence[float]:
    """The weight of each loop."""
    return list(tuned.aim.weights) or [1.0] * len(tuned.names)


def means_of(tuned: "Tuned") -> list[float]:
    """The geometric mean of the metric over the loops, before and after."""
    return [geometric_mean(weights_of(tuned), one) for one in (tuned.before, tuned.after)]


def change_line(tuned: "Tuned") -> Line:
    """What became of the metric."""
    count, unit = len(tuned.names), unit_of(tuned, tuned.metric)
    what = f"Geometric mean of {tuned.metric} over {count} loops" if count > 1 else tuned.metric
    before, after = ("diverged" if math.isinf(one) else quantity(one, unit) for one in means_of(tuned))
    return Line(f"{what}: {before} before, {after} after.")


def verdicts(tuned: "Tuned") -> list[Line]:
    """Why the values may not be the best there are, and what loops do with them or did before."""
    lines = []
    if tuned.interrupted:
        text = f" after {tuned.candidates:,} candidates; these are the best values so far."
        lines.append(Line("The search was interrupted", text, Mark.DOUBTFUL))
    if tuned.no_better:
        text = " than what the scenario has; give the search more candidates."
        lines.append(Line("No better", text, Mark.DOUBTFUL))
    if tuned.edges:
        text = f", so a wider one may hold better: {', '.join(tuned.edges)}."
        lines.append(Line("At an end of its range", text, Mark.DOUBTFUL))
    if tuned.unstable:
        lines.append(Line("Unstable for small motions", f": {'; '.join(tuned.unstable)}.", Mark.BAD))
    if not tuned.own.within:
        lines.append(Line("What the scenario has is beyond the bounds."))
    swings = {one.name: one.before.oscillation_command for one in tuned.margins}
    return lines + [before_line(name, swing) for name, swing in swings.items() if swing > 0.0]


def before_line(name: str, swing: float) -> Line:
    """What a machine did with the scenario's own values."""
    if math.isinf(swing):
        return Line(f"{name} diverged before.")
    return Line(f"{name} oscillated before", f", by {quantity(swing, 'V')} of command.")


def gains_table(tuned: "Tuned") -> Table:
    """The best values, those before, a first guess from the machine, and the ranges."""
    shown = {
        "before": tuned.own.parameters,
        "first guess": tuned.guess.parameters if tuned.guess else {},
        "best": tuned.parameters,
        "from": {path: low for path, (low, _) in tuned.ranges.items()},
        "to": {path: high for path, (_, high) in tuned.ranges.items()},
    }
    shown = {name: values for name, values in shown.items() if values}
    rows = [
        [Cell(path), *(Cell(values[path], unit_of(tuned, path)) for values in shown.values()), Cell()]
        for path in tuned.parameters
    ]
    columns = (Column("parameter"), *(Column(name, digits=5) for name in shown), UNIT)
    return Table("gains", columns, rows, RANGES, typed=tuned.typed)


def metrics_table(tuned: "Tuned") -> Table:
    """The metric of each loop before and after."""
    unit, seeds = unit_of(tuned, tuned.metric), tuned.aim.seeds
    columns = (
        *(Column("loop"), Column("weight")),
        *(Column(name, unit, right=True) for name in ("before", "after")),
        Column("change", "%", digits=3),
    )
    each = zip(tuned.names, weights_of(tuned), tuned.before, tuned.after, strict=True)
    rows = [[Cell(name), Cell(weight), *metric_cells(pair, unit)] for name, weight, *pair in each]
    if len(rows) > 1:
        rows.append([Cell("geometric mean"), Cell(), *metric_cells(means_of(tuned), unit)])
    means = f", mean over {seeds} seeds" if seeds > 1 else ""
    return Table("metrics", columns, rows, f"{tuned.metric} before and after{means}.")


def metric_cells(pair: Sequence[float], unit: str) -> list[Cell]:
    """A metric before and after, and how much larger it became, in per cent."""
    before, after = pair
    change = 100.0 * (after / before - 1.0) if 0.0 < before < math.inf else math.nan
    return [*(DIVERGED if math.isinf(one) else Cell(one, unit) for one in pair), Cell(change, "%")]


def numbers_of(tuned: "Tuned", command: str) -> dict[str, Any]:
    """All numbers of a search, in SI units."""
    each = zip(tuned.names, weights_of(tuned), tuned.before, tuned.after, strict=True)
    return {
        "command": command,
        "version": __version__,
        "parameters": dict(tuned.parameters),
        "metric": tuned.metric,
        "scenarios": [
            {"scenario": name, "weight": weight, "before": before, "after": after}
            for name, weight, before, after in each
        ],
        "geometric_mean": tuned.cost,
        "runs": tuned.runs,
        "edges": list(tuned.edges),
        "bounds": tuned.bounds._asdict() if tuned.bounds else None,
        "margins": [
            {"scenario": one.name, "before": one.before._asdict(), "after": one.after._asdict()}
            for one in tuned.margins
        ],
        "first_guess": tuned.guess._asdict() if tuned.guess else None,
        "front": [one._asdict() for one in tuned.front],
        "interrupted": tuned.interrupted,
        "unstable": list(tuned.unstable),
    }
