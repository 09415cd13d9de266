"""The report's tables of conditions, verdicts, metrics and strokes, each number as it is read."""

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

from hydroservo import show
from hydroservo.control.metrics import METRIC_FIELDS
from hydroservo.core.field import Field
from hydroservo.core.formatting import column, measured, number, quantity, yes_or_no
from hydroservo.papers.tsmc_eha_2021.claims import (
    CLAIMS,
    CONTROLLERS,
    DEMANDS,
    LITERAL,
    PERIODS,
    READINGS,
    REALISATIONS,
    REPRODUCED,
    SCALES,
    VALVES,
    Claim,
    Condition,
    Judgement,
    Results,
    condition_runs,
)
from hydroservo.papers.tsmc_eha_2021.report.names import (
    DELTAS,
    FLAGS,
    NAMES,
    Trajectories,
    condition_name,
    run_name,
)
from hydroservo.papers.tsmc_eha_2021.report.verdict_map import colour_class
from hydroservo.papers.tsmc_eha_2021.study import PaperStudy, Verdict
from hydroservo.runs.results import best_runs, metric_fields, metrics_of, scenario_tables

SETTLED = {
    "error": Field("m/s", "largest velocity error once settled"),
    "s1": Field("m/s", "largest |s1| once settled"),
    "s2": Field("N", "largest |s2| once settled"),
    "xi1": Field("m/s", "largest |xi1| once settled"),
    "xi2": Field("m/s^2", "largest |xi2| once settled"),
    "miss1": Field("m/s^2", "largest error of the estimate of d_L1 once settled"),
    "miss2": Field("N/s", "largest error of the estimate of d_L2 once settled"),
}
TemplateRows = list[dict[str, Any]]

HOLDS = {True: show.Cell("holds", mark=show.Mark.GOOD), False: show.Cell("fails", mark=show.Mark.BAD)}

LISTED = (
    "rms_error",
    "steady_rms_error",
    "max_error",
    "settling_time",
    "overshoot",
    "control_total_variation",
    "estimate_rms_error_1",
    "estimate_rms_error_2",
    "disturbance_max_2",
)


def worst_case(claim: Claim, results: Results) -> str:
    """What decides a claim under one condition: its worst run, what was measured and what is allowed."""
    judgement = claim.judge(results)
    demand, controller, name, measured, allowed, rival = judgement
    if not math.isfinite(measured) or not 0.0 < allowed < math.inf:
        return without_numbers(judgement, results)
    field = SETTLED[name] if name in SETTLED else METRIC_FIELDS[name]
    limit = quantity(allowed, field.unit)
    against = f"{NAMES[rival]}'s {limit}" if rival else f"the {limit} allowed"
    digits = 5 if abs(judgement.ratio - 1.0) < 0.005 else 3  # enough to tell a ratio from 1
    return (
        f"{run_name(demand, controller)}: {quantity(measured, field.unit)} ({field.meaning}), "
        f"{number(judgement.ratio, digits)} times {against}"
    )


def without_numbers(judgement: Judgement, results: Results) -> str:
    """Why a ratio is zero or infinite."""
    lost = [run_name(*key) for key, run in results.items() if run.metrics["diverged"]]
    if not lost:
        return "no finite ratio: a number is missing, or the rival's is 0"
    return f"{', '.join(lost)} diverged" + (", so no rival is left" if judgement.ratio == 0.0 else "")


def condition_grid() -> TemplateRows:
    """The values that a condition combines."""
    return [
        {"name": "reading of the print", "values": READINGS},
        {"name": "the six uncertain parameters", "values": [DELTAS[one] for one in SCALES]},
        {"name": "sgn in the observer", "values": list(REALISATIONS)},
        {"name": "valve", "values": list(VALVES)},
        {"name": "sample period", "values": list(PERIODS)},
    ]


def verdict_summary(study: PaperStudy) -> str:
    total, many = study.verdicts[0].total, len(study.verdicts)
    reproduced = sum(verdict.reproduced for verdict in study.verdicts)
    literal = sum(verdict.to_the_letter for verdict in study.verdicts)
    always = sum(verdict.holds == total for verdict in study.verdicts)
    never = sum(verdict.holds == 0 for verdict in study.verdicts)
    return (
        f"Of {many} claims, {reproduced} hold as reproduced and {literal} to the letter of the print. "
        f"{always} hold under all {total} conditions, {many - always - never} under some, {never} under none."
    )


def verdict_table(verdicts: Sequence[Verdict]) -> show.Table:
    """The paper's claims, each judged as reproduced, to the letter of the print and over all conditions."""
    columns = map(
        show.Column, ("claim", "what it says", "as reproduced", "to the letter", "over all conditions")
    )
    rows = [
        [
            *(show.Cell(one.claim), show.Cell(one.title)),
            *(HOLDS[one.reproduced], HOLDS[one.to_the_letter]),
            show.Cell(f"holds in {one.holds} of {one.total}"),
        ]
        for one in verdicts
    ]
    return show.Table("verdicts", [*columns], rows)


def verdict_rows(study: PaperStudy) -> TemplateRows:
    """A row for each claim: its verdicts, and what decides it as reproduced and to the letter."""
    return [
        {
            "verdict": verdict,
            "judged": [
                {"holds": verdict.reproduced, "why": deciding_reason(study, claim, REPRODUCED)},
                {"holds": verdict.to_the_letter, "why": deciding_reason(study, claim, LITERAL)},
            ],
        }
        for claim, verdict in zip(CLAIMS, study.verdicts, strict=True)
    ]


def deciding_reason(study: PaperStudy, claim: Claim, condition: Condition) -> str:
    return worst_case(claim, {key: study.outcomes[run] for key, run in condition_runs(condition).items()})


def metric_rows(trajectories: Trajectories) -> TemplateRows:
    """A row for each metric, a column for each run shown; the best of each demand is marked."""
    runs = [metrics_of(run) for run in trajectories.values()]
    rows = []
    fields = {name: field for run in trajectories.values() for name, field in metric_fields(run).items()}
    for name, field in fields.items():
        values = [run.get(name, math.nan) for run in runs]
        unit, texts = column(values, field.unit)
        if name in FLAGS:
            texts = [yes_or_no(value) for value in values]
        marks = best_marks(runs, name) if field.smaller_is_better else [False] * len(runs)
        rows.append({"meaning": field.meaning, "unit": unit, "cells": list(zip(texts, marks, strict=True))})
    return rows


def best_marks(runs: Sequence[Mapping[str, float | bool]], name: str) -> list[bool]:
    """Which runs have the best value of a metric on their demand."""
    size = len(CONTROLLERS)
    groups = [runs[start : start + size] for start in range(0, len(runs), size)]
    return [i in best_runs(group, name) for group in groups for i in range(size)]


def stroke(study: PaperStudy) -> dict[str, Any]:
    """Which runs left the stroke, of those shown and of all."""
    first = next(iter(study.trajectories.values()))
    limit = scenario_tables(first)["plant"]["stroke"]
    shown = [stroke_row(study, *key) for key in product(DEMANDS, CONTROLLERS)]
    left = ", ".join(one["name"] for one in shown if one["left"])
    every = study.metrics["stroke_left"]
    return {
        "sentence": f"{int(every.sum())} of the {every.size} runs left the stroke of "
        f"{1e3 * limit:g} mm; of the six shown: {left or 'none'}.",
        "shown": shown,
    }


def stroke_row(study: PaperStudy, demand: str, controller: str) -> dict[str, Any]:
    run = study.trajectories[f"{demand}-{controller}"]
    metrics = study.metrics
    every = metrics[(metrics["demand"] == demand) & (metrics["controller"] == controller)]["stroke_left"]
    return {
        "name": run_name(demand, controller),
        "low": measured(run, "position_min"),
        "high": measured(run, "position_max"),
        "left": bool(run["stroke_left"]),
        "count": int(every.sum()),
        "total": every.size,
    }


def ratio_rows(study: PaperStudy) -> TemplateRows:
    """A row for each condition, a ratio and its colour for each claim."""
    rows: dict[Condition, list[float]] = {}
    for *key, ratio in study.claims[[*Condition._fields, "ratio"]].itertuples(index=False, name=None):
        rows.setdefault(Condition(*key), []).append(ratio)
    return [
        {
            "condition": condition_name(condition),
            "cells": [{"text": number(ratio), "colour": colour_class(ratio)} for ratio in ratios],
        }
        for condition, ratios in rows.items()
    ]


def listed_rows(study: PaperStudy) -> dict[str, Any]:
    """Every run with its most telling metrics, each column in one unit."""
    metrics = study.metrics
    columns = {name: column(metrics[name].tolist(), METRIC_FIELDS[name].unit) for name in LISTED}
    cells = zip(*(texts for _, texts in columns.values()), strict=True)
    flags = zip(*(map(yes_or_no, metrics[name]) for name in FLAGS[1:]), strict=True)
    return {
        "headers": [f"{METRIC_FIELDS[name].meaning} [{unit}]" for name, (unit, _) in columns.items()],
        "rows": [
            {
                "run": [run.demand, NAMES[run.controller], *condition_name(run)],
                "cells": texts,
                "flags": raised,
            }
            for run, texts, raised in zip(study.outcomes, cells, flags, strict=True)
        ],
    }
