"""Runs the study under all conditions and judges the paper's claims."""

import os
from collections.abc import Callable
from concurrent.futures import CancelledError, ThreadPoolExecutor, as_completed
from threading import Event
from typing import TYPE_CHECKING, NamedTuple

from hydroservo.control.loop import Loop
from hydroservo.papers.tsmc_eha_2021.claims import (
    CLAIMS,
    CONTROLLERS,
    DEMANDS,
    LITERAL,
    REPRODUCED,
    Condition,
    PaperRun,
    RunOutcome,
    all_conditions,
    all_runs,
    condition_runs,
    run_outcome,
)
from hydroservo.papers.tsmc_eha_2021.printed import printed
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import simulate
from hydroservo.scenario import load_scenario

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

PaperProgress = Callable[[int, int, str], None]  # done, of how many, what


class Verdict(NamedTuple):
    """How one claim fares: as reproduced, to the letter of the print, and over all conditions."""

    claim: str
    title: str
    test: str
    reproduced: bool
    ratio_reproduced: float
    to_the_letter: bool
    ratio_to_the_letter: float
    holds: int
    total: int
    where: str


class PaperStudy(NamedTuple):
    """Everything that the report shows."""

    trajectories: "dict[str, xr.Dataset]"  # the built-in scenarios' runs by name, such as "sine-tsmc"
    metrics: "pd.DataFrame"  # one row a run: its condition, then its metrics in SI units
    claims: "pd.DataFrame"  # one row a claim and condition: ratio (measured/allowed) and holds (ratio < 1)
    verdicts: list[Verdict]  # one for each claim
    outcomes: dict[PaperRun, RunOutcome]  # what each run came to


def run_study(progress: PaperProgress | None = None) -> PaperStudy:
    """Simulate all runs on all cores and judge every claim under every condition."""
    runs = all_runs()
    shown = set(condition_runs(REPRODUCED).values())
    outcomes: dict[PaperRun, RunOutcome] = {}
    trajectories: dict[str, xr.Dataset] = {}
    pool, stop = ThreadPoolExecutor(os.cpu_count()), Event()
    try:
        waiting = {pool.submit(simulate_run, run, stop): run for run in runs}
        for done, future in enumerate(as_completed(waiting), 1):
            run, data = waiting.pop(future), future.result()
            outcomes[run] = run_outcome(data, run.demand)
            if run in shown:
                trajectories[f"{run.demand}-{run.controller}"] = data
            del future, data  # or the last trajectory of each kind would stay in memory
            if progress is not None:
                progress(done, len(runs), f"{run.demand}, {run.controller}, {run.valve} valve, {run.period}")
    finally:
        stop.set()
        pool.shutdown(cancel_futures=True)
    ordered = {run: outcomes[run] for run in runs}
    names = [f"{demand}-{controller}" for demand in DEMANDS for controller in CONTROLLERS]
    claims = judge_claims(ordered)
    return PaperStudy(
        {name: trajectories[name] for name in names},
        metrics_frame(ordered),
        claims,
        claim_verdicts(claims),
        ordered,
    )


def simulate_run(run: PaperRun, stop: Event) -> "xr.Dataset":
    """The run's result; given up between two chunks of samples once ``stop`` is set."""

    def heed(_: float) -> None:
        if stop.is_set():
            raise CancelledError

    return quietly(simulate)(loop_of(run), strict=True, progress=heed)  # strict: the same verdicts everywhere


def loop_of(run: PaperRun) -> Loop:
    loop = load_scenario(run.scenario(), run.changes())
    return printed(loop) if run.reading == "as printed" else loop


def metrics_frame(outcomes: dict[PaperRun, RunOutcome]) -> "pd.DataFrame":
    import pandas as pd

    return pd.DataFrame([run._asdict() | dict(result.metrics) for run, result in outcomes.items()])


def judge_claims(outcomes: dict[PaperRun, RunOutcome]) -> "pd.DataFrame":
    import pandas as pd

    rows = []
    for condition in all_conditions():
        results = {key: outcomes[run] for key, run in condition_runs(condition).items()}
        for claim in CLAIMS:
            ratio = claim.judge(results).ratio
            rows.append({"claim": claim.name} | condition._asdict() | {"ratio": ratio, "holds": ratio < 1.0})
    return pd.DataFrame(rows)


def claim_verdicts(claims: "pd.DataFrame") -> list[Verdict]:
    found = []
    for claim in CLAIMS:
        rows = claims[claims["claim"] == claim.name]
        reproduced, literal = (ratio_under(rows, condition) for condition in (REPRODUCED, LITERAL))
        found.append(
            Verdict(
                claim.name,
                claim.title,
                claim.test,
                reproduced < 1.0,
                reproduced,
                literal < 1.0,
                literal,
                int(rows["holds"].sum()),
                len(rows),
                where_it_holds(rows),
            )
        )
    return found


def ratio_under(rows: "pd.DataFrame", condition: Condition) -> float:
    chosen = rows[rows[list(Condition._fields)].apply(tuple, axis=1) == tuple(condition)]
    return float(chosen["ratio"].iloc[0])


def where_it_holds(rows: "pd.DataFrame") -> str:
    """In words: everywhere, nowhere, or how often under each value of each condition."""
    if rows["holds"].all():
        return "everywhere"
    if not rows["holds"].any():
        return "nowhere"
    parts = []
    for name in Condition._fields:
        counts = rows.groupby(name, sort=False)["holds"].agg(["sum", "count"])
        if counts["sum"].nunique() > 1:
            shares = (
                f"{value_label(name, value)} {int(c['sum'])}/{int(c['count'])}"
                for value, c in counts.iterrows()
            )
            parts.append(", ".join(shares))
    return "; ".join(parts) or f"in {int(rows['holds'].sum())} of {len(rows)}, whatever the condition"


def value_label(name: str, value: object) -> str:
    return {-1: "-Delta", 0: "nominal", 1: "+Delta"}[int(str(value))] if name == "delta" else str(value)
