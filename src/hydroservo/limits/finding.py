"""What the limits of a law say."""

import math
from functools import partial
from typing import TYPE_CHECKING, Any

from hydroservo.core.formatting import measured, number, quantity
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.provenance import origin_of, origin_of_loop, scenario_hash
from hydroservo.runs.results import save
from hydroservo.runs.run_finding import controller_title, steps_line
from hydroservo.show import Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import title_of

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot
    from hydroservo.limits.least_error import Limits
    from hydroservo.limits.over_periods import LimitsAtPeriod, LimitsOverPeriods

MEANINGS = {
    "law": "the scenario's law",
    "causal": "the best command, jumps unknown until they come",
    "clairvoyant": "the best command, all known",
}
CAPTION = "The law, and the best commands: what is controlled, error and command."
STAR = "* No limit: the search did not end in an optimum."
NOTE = "Multiple: how many times this error the law leaves."


def limits_finding(limits: "Limits", scenario: str = "") -> Finding:
    """What the limits of a law say."""
    law = limits.law
    multiples = {name: one for name, one in limits.multiples().items() if not math.isnan(one)}
    times = " and ".join(f"{number(one)} times the {name} limit" for name, one in multiples.items())
    times = times or "and no limit was found"
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
        [
            Cell(name if run.attrs.get("converged", True) else f"{name} *"),
            *(Cell(float(run["rms_error"])), Cell(multiples.get(name)), Cell(MEANINGS[name])),
        ]
        for name, run in limits._asdict().items()
    ]
    stars = "" if all(run.attrs["converged"] for run in limits[1:]) else f" {STAR}"
    return Table("limits", columns, rows, "What each command leaves.", NOTE + stars)


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


OVER_PERIODS = "What the law leaves, and the least that a command can leave, over the sample period."


def over_periods_finding(found: "LimitsOverPeriods", scenario: str = "") -> Finding:
    """What limits over sample periods say."""
    return Finding(
        title_of("Limits over sample periods", scenario),
        over_periods_lines(found),
        [f"{quantity(one.period, 's')}: {line}" for one in found.at for line in one.warnings],
        [over_periods_table(found)],
        [Picture("limits", OVER_PERIODS, lambda: draw_over_periods(found))],
        over_periods_numbers(found, scenario),
        origins=[origin_of_loop(scenario, found.loop)],
    )


def over_periods_lines(found: "LimitsOverPeriods") -> list[Line]:
    """The law's error and its multiple of the causal limit at the shortest and at the longest period."""
    known = [one for one in found.at if one.law > 0.0 and one.causal > 0.0]
    texts = [
        f"{quantity(one.law, found.error.unit)} at {quantity(one.period, 's')}, "
        f"{number(one.multiples()['causal'])} times the causal limit"
        for one in (known if len(known) < 2 else (known[0], known[-1]))
    ]
    return [Line(f"The law leaves {', and '.join(texts)}.")] if texts else []


def over_periods_table(found: "LimitsOverPeriods") -> Table:
    """The errors at each period."""
    unit, remarks = found.error.unit, any(one.reason for one in found.at)
    columns = (
        Column("sample period", "s", digits=3),
        *(Column(name, unit, digits=3) for name in MEANINGS),
        *(Column(f"law over {name}", digits=3) for name in ("causal", "clairvoyant")),
        *([Column("remark")] if remarks else []),
    )
    rows = [
        [
            *(Cell(value) for value in (one.period, one.law, one.causal, one.clairvoyant)),
            *(Cell(value) for value in one.multiples().values()),
            *([Cell(one.reason, mark=Mark.DOUBTFUL)] if remarks else []),
        ]
        for one in found.at
    ]
    note = f"Law, causal, clairvoyant: {found.error.meaning} with {'; '.join(MEANINGS.values())}."
    return Table("limits", columns, rows, OVER_PERIODS, note)


def draw_over_periods(found: "LimitsOverPeriods") -> "Plot":
    from hydroservo.figures.limits import plot_over_periods

    return plot_over_periods(found)


def over_periods_numbers(found: "LimitsOverPeriods", scenario: str) -> dict[str, Any]:
    """All numbers of limits over sample periods, in SI units."""
    return {
        "scenario": scenario,
        "hash": scenario_hash(found.loop),
        "unit": found.error.unit,
        "periods": [at_period_numbers(one) for one in found.at],
    }


def at_period_numbers(one: "LimitsAtPeriod") -> dict[str, Any]:
    errors = {name: getattr(one, name) for name in MEANINGS}
    return {
        "period": one.period,
        "rms_error": errors,
        "multiple": one.multiples(),
        "reason": one.reason,
        "warnings": list(one.warnings),
    }
