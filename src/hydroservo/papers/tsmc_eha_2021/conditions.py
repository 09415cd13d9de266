"""The conditions under which the paper's claims are judged, and the runs that they need."""

from itertools import product
from typing import Any, NamedTuple

from hydroservo.papers.tsmc_eha_2021.machine import VALVE_LAG

DEMANDS = ("sine", "square")
CONTROLLERS = ("pi", "backstepping", "tsmc")
READINGS = ("corrected", "as printed")
SCALES = (-1, 0, 1)
REALISATIONS = {"explicit": "Explicit", "boundary layer": "BoundaryLayer", "implicit": "Implicit"}
VALVES: dict[str, dict[str, object]] = {
    "static": {"valve.type": "StaticValve"},
    "10 ms lag": {"valve.type": "FirstOrderValve", "valve.time_constant": VALVE_LAG},
}
PERIODS = {"10 us": 1e-5, "100 us": 1e-4, "1 ms": 1e-3}
STEP = 1e-5  # [s] the machine is integrated with this step whatever the sample period


class Condition(NamedTuple):
    """One way to read, perturb, realise and sample the study."""

    reading: str
    delta: int  # the six uncertain parameters are at nominal + delta Delta
    realisation: str
    valve: str
    period: str


REPRODUCED = Condition("corrected", 1, "boundary layer", "static", "10 us")  # as reproduced
LITERAL = Condition("as printed", 1, "explicit", "static", "10 us")  # to the letter


class Run(NamedTuple):
    """One closed loop; ``realisation`` is "" for laws without an observer."""

    demand: str
    controller: str
    reading: str
    delta: int
    realisation: str
    valve: str
    period: str

    def scenario(self) -> str:
        """The built-in scenario that this run varies."""
        return f"paper/{self.demand}-{self.controller}"

    def changes(self) -> dict[str, Any]:
        """What this run changes in its scenario, as ``--set`` would; its reading is no part of that."""
        period = PERIODS[self.period]
        changes: dict[str, Any] = {
            "uncertainty.scale": float(self.delta),
            "simulation.period": period,
            "simulation.substeps": round(period / STEP),
        } | VALVES[self.valve]
        if self.realisation:
            changes["controller.observer.realisation.type"] = REALISATIONS[self.realisation]
        return changes


def all_conditions() -> list[Condition]:
    """All conditions: readings x signs of Delta x realisations x valves x sample periods."""
    return [Condition(*one) for one in product(READINGS, SCALES, REALISATIONS, VALVES, PERIODS)]


def runs_of(condition: Condition) -> dict[tuple[str, str], Run]:
    """The six runs of a condition by demand and controller."""
    reading, delta, realisation, valve, period = condition
    return {
        (demand, controller): Run(
            demand,
            controller,
            reading,
            delta,
            realisation if controller == "tsmc" else "",
            valve,
            period,
        )
        for demand, controller in product(DEMANDS, CONTROLLERS)
    }


def all_runs() -> list[Run]:
    """Every run that some condition needs, once, the longest first."""
    runs = dict.fromkeys(run for condition in all_conditions() for run in runs_of(condition).values())
    return sorted(runs, key=lambda run: PERIODS[run.period])
