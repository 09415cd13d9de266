"""The outcome of a search for gains."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

from hydroservo.core.formatting import Scale
from hydroservo.runs.aims import Aim
from hydroservo.runs.tuned_finding import tuned_finding
from hydroservo.show import Finding
from hydroservo.show.html import html_of


class Tried(NamedTuple):
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
    own: Tried
    best: Tried
    guess: Tried | None = None
    front: Sequence[Tried] = ()
    interrupted: bool = False
    unstable: Sequence[str] = ()
    margins: Sequence[Any] = ()  # of hydroservo.linear, which is above this
    aim: Aim = Aim(())
    ranges: Mapping[str, tuple[float, float]] = MappingProxyType({})
    bounds: Any = None  # of hydroservo.linear too
    typed: Mapping[str, Scale] = MappingProxyType({})

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
        return [f"{self.runs:,} closed loops were simulated"]

    def remarks(self) -> list[str]:
        """Warnings, each a phrase."""
        edges = [f"at an end of its range: {', '.join(self.edges)}"] if self.edges else []
        unstable = [f"unstable for small motions: {'; '.join(self.unstable)}"] if self.unstable else []
        return [*(["the search was interrupted"] if self.interrupted else []), *edges, *unstable]
