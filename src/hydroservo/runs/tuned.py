"""The outcome of a search for gains."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from hydroservo.formatting import column, quantity
from hydroservo.html_tables import Strong, html_remarks, html_table
from hydroservo.runs.tried import Tried


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

    def __repr__(self) -> str:
        lines = [f"{path} = {value:g}" for path, value in self.parameters.items()]
        metrics = zip(self.names, self.before, self.after, strict=True)
        lines += [f"{name}: {before:.3g} -> {after:.3g}" for name, before, after in metrics]
        lines += [str(one) for one in self.margins]
        return "\n".join([*lines, "; ".join([*self.runs_line(), *self.remarks()])])

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        about = {path: self.tables[0][path].attrs for path in self.parameters}
        values = [
            (path, Strong(quantity(value, about[path]["units"])), about[path]["long_name"])
            for path, value in self.parameters.items()
        ]
        unit = self.tables[0][self.metric].attrs["units"]
        label, each = column([*self.before, *self.after], unit)
        count = len(self.before)
        metrics = zip(self.names, each[:count], map(Strong, each[count:]), strict=True)
        heads = ("loop", f"{self.metric} before [{label}]", "after")
        remarks = [*map(str, self.margins), *map(Strong, self.remarks()), *self.runs_line()]
        return (
            html_table(("parameter", "best", "meaning"), values)
            + html_table(heads, metrics)
            + html_remarks(remarks)
        )

    def runs_line(self) -> list[str]:
        return [f"{self.runs:,} closed loops were simulated"]

    def remarks(self) -> list[str]:
        """Warnings, each a phrase."""
        edges = [f"at an end of its range: {', '.join(self.edges)}"] if self.edges else []
        unstable = [f"unstable for small motions: {'; '.join(self.unstable)}"] if self.unstable else []
        return [*(["the search was interrupted"] if self.interrupted else []), *edges, *unstable]
