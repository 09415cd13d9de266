"""What the paper's controllers, runs and conditions are called in the report."""

from collections.abc import Mapping

import xarray as xr

from hydroservo.formatting import MINUS, NONE
from hydroservo.papers.tsmc_eha_2021.conditions import Condition, Run
from hydroservo.papers.tsmc_eha_2021.report.typeset import plain_signs

Trajectories = Mapping[str, xr.Dataset]  # the six runs shown, by demand and controller, such as "sine-tsmc"

FLAGS = ("demand_jumps", "stroke_left", "diverged")  # the metrics that are true or false
NAMES = {"pi": "PI", "backstepping": "backstepping", "tsmc": "TSMC"}
DELTAS = {-1: f"{MINUS}Δ", 0: "nominal", 1: "+Δ"}  # the six uncertain parameters


def run_name(demand: str, controller: str) -> str:
    """A run of some condition, such as "PI on the sine"."""
    return f"{NAMES[controller]} on the {demand}"


def condition_name(condition: Condition | Run) -> list[str]:
    """The five parts of a condition, each as it is read."""
    return [
        condition.reading,
        DELTAS[condition.delta],
        condition.realisation or NONE,
        condition.valve,
        plain_signs(condition.period),
    ]
