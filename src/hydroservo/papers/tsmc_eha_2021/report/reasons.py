"""Each verdict in words: which run decides a claim, what was measured in it and what is allowed."""

import math

from hydroservo.field import Field
from hydroservo.formatting import number, quantity
from hydroservo.metrics import METRIC_FIELDS
from hydroservo.papers.tsmc_eha_2021.claims import Claim, Judgement, Results
from hydroservo.papers.tsmc_eha_2021.report.names import NAMES, run_name

SETTLED = {
    "error": Field("m/s", "largest velocity error once settled"),
    "s1": Field("m/s", "largest |s1| once settled"),
    "s2": Field("N", "largest |s2| once settled"),
    "xi1": Field("m/s", "largest |xi1| once settled"),
    "xi2": Field("m/s^2", "largest |xi2| once settled"),
    "miss1": Field("m/s^2", "largest error of the estimate of d_L1 once settled"),
    "miss2": Field("N/s", "largest error of the estimate of d_L2 once settled"),
}


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
