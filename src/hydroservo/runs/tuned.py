"""The outcome of a search for gains, and what it says."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo._version import __version__
from hydroservo.core.formatting import Scale, number, quantity
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.objective import Aim, geometric_mean
from hydroservo.runs.provenance import origin_of_loop
from hydroservo.runs.run_finding import controller_title, steps_line
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import title_of
from hydroservo.show.html import html_of

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot


class TriedValues(NamedTuple):
    """What one set of values does to the loops of a search.

    Attributes:
        parameters: the values by path, in SI units.
        error: weighted geometric mean of the loops' metric, in the metric's unit; inf where a run diverged.
        activity: likewise of the command's total variation [V]; nan where the loops do not have it.
        within: whether it keeps the bounds of the search.
    """

    parameters: Mapping[str, float]
    error: float
    activity: float
    within: bool

    def cost(self, effort: float) -> float:
        """The error, with a price on the activity: error activity^effort."""
        return self.error * (self.activity**effort if effort else 1.0)


class Tuned(NamedTuple):
    """The best values of a search, and what they do.

    Attributes:
        parameters: the best values by path, in SI units, rounded to five digits.
        before: the metric of each loop with its own values, mean over the seeds; inf where a run diverged.
        after: the same with the best values.
        cost: the weighted geometric mean of the metrics after, without effort.
        runs: how many closed loops the search simulated.
        edges: the paths whose best value lies within a hundredth of an end of its range.
        tables: the runs of each loop with the best values, one for each seed, as simulate_batch returns them.
        names: of the loops.
        metric: what was made small.
        own: the loops' own values; shown are those of the first.
        best: the best values.
        guess: a first guess from the machine's natural frequency; None where there is none.
        rule: what the guess is from, a :class:`~hydroservo.linear.first_guess.FirstGuess`, where there was no
            search; else None.
        front: the least errors of the candidates for the command's activity, from the calmest on.
        interrupted: whether the search ended before all its candidates were tried.
        unstable: names of loops that the best values leave unstable for small motions at one of the places
            where margins are judged; of a search without bounds.
        margins: those of each loop of a search with bounds, before and after.
        aim: what was to be small.
        ranges: the lowest and highest value of each number, by its path, in SI units.
        bounds: what the loops were to bear; None for none.
        typed: the units in which ranges were typed, by SI unit.
    """

    parameters: Mapping[str, float]
    before: Sequence[float]
    after: Sequence[float]
    cost: float
    runs: int
    edges: Sequence[str]
    tables: Sequence[Any]  # datasets of xarray, which is heavy to import
    names: Sequence[str]
    metric: str
    own: TriedValues
    best: TriedValues
    guess: TriedValues | None = None
    front: Sequence[TriedValues] = ()
    interrupted: bool = False
    unstable: Sequence[str] = ()
    margins: Sequence[Any] = ()  # of hydroservo.linear, which is above this
    aim: Aim = Aim(())
    ranges: Mapping[str, tuple[float, float]] = MappingProxyType({})
    bounds: Any = None  # of hydroservo.linear too
    typed: Mapping[str, Scale] = MappingProxyType({})
    rule: Any = None  # of hydroservo.linear too

    def __repr__(self) -> str:
        lines = [f"{path} = {value:g}" for path, value in self.parameters.items()]
        metrics = zip(self.names, self.before, self.after, strict=True)
        lines += [f"{name}: {before:.3g} -> {after:.3g}" for name, before, after in metrics]
        lines += [str(one) for one in self.margins]
        return "\n".join([*lines, "; ".join([*self.runs_line(), *self.remarks()])])

    def finding(self) -> Finding:
        """What it says, as commands and notebooks show it."""
        return tuned_finding(self)

    def _repr_html_(self) -> str:
        return html_of(self.finding())

    @property
    def candidates(self) -> int:
        """How many sets of values were tried."""
        return self.runs // (self.aim.seeds * len(self.names))

    @property
    def no_better(self) -> bool:
        """Whether the loops' own values keep the bounds and are better."""
        effort = self.aim.effort
        return self.own.within and self.best.cost(effort) > self.own.cost(effort)

    def runs_line(self) -> list[str]:
        if self.rule:
            return ["a first guess, without a search"]
        return [f"{self.runs:,} closed loops were simulated"]

    def remarks(self) -> list[str]:
        """Warnings, each a phrase."""
        edges = [f"at an end of its range: {', '.join(self.edges)}"] if self.edges else []
        unstable = [f"unstable for small motions: {'; '.join(self.unstable)}"] if self.unstable else []
        return [*(["the search was interrupted"] if self.interrupted else []), *edges, *unstable]


CAPTION = "The metric with the values the scenarios have, and with the best ones."
FRONT = "The least error that candidates within the bounds have for the activity of their command."
RULES = "A first guess, and the rule of each gain."
RANGES = "The best values, and the ranges that were searched."
DIVERGED = Cell("diverged", mark=Mark.BAD)


def tuned_finding(
    tuned: "Tuned", scenarios: Sequence[str] = (), command: str = "", replay: str = ""
) -> Finding:
    """What a search for gains says."""
    runs = [*zip(tuned.names, tuned.tables, strict=True)]
    seed = " and the first seed" if tuned.aim.seeds > 1 else ""
    tables = [tuned_gains_table(tuned), tuned_metrics_table(tuned)]
    return Finding(
        title_of("Gains", ", ".join(scenarios) or controller_title(tuned.tables[0])),
        [
            change_line(tuned),
            *tuned_verdicts(tuned),
            rule_line(tuned.rule) if tuned.rule else Line(f"{tuned.runs:,} closed loops were simulated."),
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
            Picture("tuned", CAPTION, lambda: draw_tuned(tuned)),
            Picture("front", FRONT, lambda: draw_tuned_front(tuned)),
        ],
        tuned_numbers(tuned, command),
        origins=[origin_of_loop(*one) for one in zip(tuned.names, tuned.aim.loops, strict=False)],
    )


def rule_line(rule: Any) -> Line:
    """What gains are from that no search found."""
    frequency, gain = rule.natural_frequency / (2.0 * math.pi), quantity(rule.velocity_gain, "m/(s V)")
    axis = f"{number(frequency)} Hz, damping ratio {number(rule.damping_ratio)}, K_q {gain}"
    return Line("No search", f": gains by rules, where the axis bears least, with {axis}.")


def draw_tuned(tuned: "Tuned") -> "Plot":
    from hydroservo.figures.tuned import plot_tuned

    return plot_tuned(tuned)


def draw_tuned_front(tuned: "Tuned") -> "Plot":
    from hydroservo.figures.tuned import plot_front

    return plot_front(tuned)


def searched_unit(tuned: "Tuned", name: str) -> str:
    """The SI unit of a metric, or of a number that was searched."""
    return str(tuned.tables[0][name].attrs["units"])


def weights_of(tuned: "Tuned") -> Sequence[float]:
    return list(tuned.aim.weights) or [1.0] * len(tuned.names)


def geometric_means_of(tuned: "Tuned") -> list[float]:
    """The geometric mean of the metric over the loops, before and after."""
    return [geometric_mean(weights_of(tuned), one) for one in (tuned.before, tuned.after)]


def change_line(tuned: "Tuned") -> Line:
    """What became of the metric."""
    count, unit = len(tuned.names), searched_unit(tuned, tuned.metric)
    what = f"Geometric mean of {tuned.metric} over {count} loops" if count > 1 else tuned.metric
    before, after = (
        "diverged" if math.isinf(one) else quantity(one, unit) for one in geometric_means_of(tuned)
    )
    return Line(f"{what}: {before} before, {after} after.")


def tuned_verdicts(tuned: "Tuned") -> list[Line]:
    """Why the values may not be the best there are, and what loops do with them or did before."""
    lines = []
    if tuned.interrupted:
        text = f" after {tuned.candidates:,} candidates; these are the best values so far."
        lines.append(Line("The search was interrupted", text, Mark.DOUBTFUL))
    if tuned.no_better:
        advice = "" if tuned.rule else "; give the search more candidates"
        text = f" than what the scenario has{advice}."
        lines.append(Line("No better", text, Mark.DOUBTFUL))
    if tuned.edges:
        text = f", so a wider one may hold better: {', '.join(tuned.edges)}."
        lines.append(Line("At an end of its range", text, Mark.DOUBTFUL))
    if tuned.unstable:
        lines.append(Line("Unstable for small motions", f": {'; '.join(tuned.unstable)}.", Mark.BAD))
    if tuned.rule and not tuned.best.within:
        lines.append(Line("The first guess is beyond the bounds.", mark=Mark.BAD))
    if not tuned.own.within:
        lines.append(Line("What the scenario has is beyond the bounds."))
    for change in tuned.margins:
        if math.isnan(change.after.oscillation_command):
            text = f" whether {change.name} oscillates with these values: give it a longer run."
            lines.append(Line("The run is too short to tell", text, Mark.DOUBTFUL))
        if change.before.oscillation_command > 0.0:
            lines.append(before_line(change.name, change.before.oscillation_command))
    return lines


def before_line(name: str, swing: float) -> Line:
    """What a machine did with the scenario's own values."""
    if math.isinf(swing):
        return Line(f"{name} diverged before.")
    return Line(f"{name} oscillated before", f", by {quantity(swing, 'V')} of command.")


def tuned_gains_table(tuned: "Tuned") -> Table:
    """The best values, those before, a first guess from the machine, and the ranges."""
    shown = {
        "before": tuned.own.parameters,
        "first guess": tuned.guess.parameters if tuned.guess else {},
        "best": {} if tuned.rule else tuned.parameters,
        "from": {path: low for path, (low, _) in tuned.ranges.items()},
        "to": {path: high for path, (_, high) in tuned.ranges.items()},
    }
    shown = {name: values for name, values in shown.items() if values}
    rules = tuned.rule.rules if tuned.rule else {}
    rows = [
        [
            Cell(path),
            *(Cell(values[path], searched_unit(tuned, path)) for values in shown.values()),
            Cell(),
            *([Cell(rules[path])] if rules else []),
        ]
        for path in tuned.parameters
    ]
    columns = (Column("parameter"), *(Column(name, digits=5) for name in shown), UNIT)
    columns += (Column("rule"),) if rules else ()
    return Table("gains", columns, rows, RULES if rules else RANGES, typed=tuned.typed)


def tuned_metrics_table(tuned: "Tuned") -> Table:
    """The metric of each loop before and after."""
    unit, seeds = searched_unit(tuned, tuned.metric), tuned.aim.seeds
    columns = (
        *(Column("loop"), Column("weight")),
        *(Column(name, unit, right=True) for name in ("before", "after")),
        Column("change", "%", digits=3),
    )
    each = zip(tuned.names, weights_of(tuned), tuned.before, tuned.after, strict=True)
    rows = [[Cell(name), Cell(weight), *metric_cells(pair, unit)] for name, weight, *pair in each]
    if len(rows) > 1:
        rows.append([Cell("geometric mean"), Cell(), *metric_cells(geometric_means_of(tuned), unit)])
    means = f", mean over {seeds} seeds" if seeds > 1 else ""
    return Table("metrics", columns, rows, f"{tuned.metric} before and after{means}.")


def metric_cells(pair: Sequence[float], unit: str) -> list[Cell]:
    """A metric before and after, and how much larger it became, in per cent."""
    before, after = pair
    change = 100.0 * (after / before - 1.0) if 0.0 < before < math.inf else math.nan
    return [*(DIVERGED if math.isinf(one) else Cell(one, unit) for one in pair), Cell(change, "%")]


def tuned_numbers(tuned: "Tuned", command: str) -> dict[str, Any]:
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
