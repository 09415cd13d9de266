"""What the limits of a law say."""

from functools import partial
from typing import TYPE_CHECKING, Any

from hydroservo.core.formatting import measured, number
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.provenance import origin_of
from hydroservo.runs.results import save
from hydroservo.runs.run_finding import controller_title, steps_line
from hydroservo.show import Cell, Column, Finding, Line, Picture, Table
from hydroservo.show.finding import title_of

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot
    from hydroservo.limits.least_error import Limits

MEANINGS = {
    "law": "the scenario's law",
    "causal": "the best command, jumps unknown until they come",
    "clairvoyant": "the best command, all known",
}
CAPTION = "The law, and the best commands: what is controlled, error and command."
NOTE = "Multiple: how many times this error the law leaves."


def limits_finding(limits: "Limits", scenario: str = "") -> Finding:
    """What the limits of a law say."""
    law = limits.law
    times = " and ".join(f"{number(one)} times the {name} limit" for name, one in limits.multiples().items())
    warnings = dict.fromkeys(line for run in limits for line in warnings_of(run))
    return Finding(
        title_of("Limits", scenario or controller_title(law)),
        [Line(f"The law leaves {measured(law, 'rms_error')} rms, {times}."), *steps_line(law.attrs)],
        list(warnings),
        [limits_table(limits)],
        [Picture("limit", CAPTION, lambda: draw_limits(limits))],
        limit_numbers(limits, scenario),
        {f"{name}.csv": partial(save, run) for name, run in limits._asdict().items()},
        [origin_of(scenario, law.attrs)],
    )


def limits_table(limits: "Limits") -> Table:
    """The error that each command leaves."""
    about, multiples = limits.law["rms_error"].attrs, limits.multiples()
    columns = (
        Column("command"),
        Column(about["long_name"], about["units"], digits=3),
        Column("multiple", digits=3),
        Column("meaning"),
    )
    rows = [
        [Cell(name), Cell(float(run["rms_error"])), Cell(multiples.get(name)), Cell(MEANINGS[name])]
        for name, run in limits._asdict().items()
    ]
    return Table("limits", columns, rows, "What each command leaves.", NOTE)


def draw_limits(limits: "Limits") -> "Plot":
    from hydroservo.figures.run import plot_comparison

    return plot_comparison([*limits], [*limits._fields])


def limit_numbers(limits: "Limits", scenario: str) -> dict[str, Any]:
    """All numbers of limits, in SI units."""
    law, best = limits.law, {"causal": limits.causal, "clairvoyant": limits.clairvoyant}
    return {
        "scenario": scenario,
        "hash": law.attrs["hash"],
        "unit": law["rms_error"].attrs["units"],
        "rms_error": {name: float(run["rms_error"]) for name, run in limits._asdict().items()},
        "multiple": limits.multiples(),
        "search": {
            name: {key: run.attrs[key] for key in ("iterations", "converged")} for name, run in best.items()
        },
    }
