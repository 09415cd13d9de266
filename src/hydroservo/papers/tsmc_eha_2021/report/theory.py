"""The report's tables of theory beside the runs: Lemmas 1 and 2, conditions (17) and (25)."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from hydroservo.control.controllers.tsmc import TSMC
from hydroservo.control.observers.tsm import TSMObserver
from hydroservo.core.formatting import NONE, number, quantity
from hydroservo.machine.theory import settling_bound
from hydroservo.papers.tsmc_eha_2021.claims import CONVERGED, DEMANDS, SURFACE_GAIN
from hydroservo.papers.tsmc_eha_2021.lemmas import condition_17, condition_25, lemma_2
from hydroservo.papers.tsmc_eha_2021.machine import AMPLITUDE, OBSERVER, TERMINAL
from hydroservo.papers.tsmc_eha_2021.printed import printed_settling_bound
from hydroservo.papers.tsmc_eha_2021.report.names import Trajectories
from hydroservo.papers.tsmc_eha_2021.report.tables import TemplateRows
from hydroservo.runs.results import scenario_tables

LEAST_XI2 = CONVERGED * SURFACE_GAIN * AMPLITUDE  # [m/s^2] below it the claims count xi2 as converged


class Surface(NamedTuple):
    """A sliding surface of a run and the reaching law it is meant to obey."""

    name: str
    path: str
    unit: str
    linear_gain: float
    power_gain: float
    exponent: float


class RunLaws(NamedTuple):
    """What ran in the computer of a run with TSMC."""

    controller: TSMC
    observer: TSMObserver
    period: float  # [s]


def bound_rows(trajectories: Trajectories) -> TemplateRows:
    """Lemma 1 from the largest value of each surface on: both bounds, and what is left there."""
    return [
        {"demand": demand, "name": surface.name} | bound_row(run, surface)
        for demand, run in finished_runs(trajectories)
        for surface in run_surfaces(run)
    ]


def bound_row(run: xr.Dataset, surface: Surface) -> dict[str, str]:
    time, size = run["time"].to_numpy(), np.abs(run[surface.path].to_numpy())
    first = int(np.argmax(size))
    alpha = 0.5 * (1.0 + surface.exponent)
    row = {"largest": quantity(size[first], surface.unit)}
    for form, bound_of in (("right", settling_bound), ("printed", printed_settling_bound)):
        bound = bound_of(
            linear_rate=2.0 * surface.linear_gain,
            power_rate=2.0**alpha * surface.power_gain,
            exponent=alpha,
            initial=0.5 * float(size[first]) ** 2,
        )
        after = int(np.searchsorted(time, time[first] + bound))
        row[form] = quantity(bound, "s")
        row[f"left_{form}"] = quantity(size[after], surface.unit) if after < size.size else "run is over"
    return row


def gain_rows(trajectories: Trajectories) -> TemplateRows:
    """Lemma 2 on both runs of TSMC, the law that has an observer."""
    rows = []
    for demand in DEMANDS:
        run = trajectories[f"{demand}-tsmc"]
        observer = run_laws(run).observer
        gains = (observer.switching_gain_1, observer.switching_gain_2)
        channels = zip(("d_L1", "d_L2"), ("m/s^2", "N/s"), gains, lemma_2(run, observer), strict=True)
        for channel, unit, gain, found in channels:
            rows.append(
                {
                    "demand": demand,
                    "channel": channel,
                    "gain": quantity(gain, unit),
                    "largest": quantity(found.largest, unit),
                    "margin": number(found.margin),
                    "holds": found.holds,
                }
            )
    return rows


def decrease_rows(trajectories: Trajectories) -> TemplateRows:
    """Conditions (17) and (25) along the two TSMC runs."""
    rows = []
    for demand, run in finished_runs(trajectories):
        controller, observer, period = run_laws(run)
        found = (*condition_17(run, observer, period), condition_25(run, controller, LEAST_XI2))
        for condition, name, one in zip(("(17)", "(17)", "(25)"), ("s1", "s2", "xi2"), found, strict=True):
            judged = int(one.judged.sum())
            rows.append(
                {
                    "demand": demand,
                    "condition": condition,
                    "name": name,
                    "judged": f"{judged} of {one.judged.size}",
                    "holds": int(one.holds.sum()),
                    "share": f"{number(100.0 * one.fraction)} %" if judged else NONE,
                }
            )
    return rows


def finished_runs(trajectories: Trajectories) -> Iterator[tuple[str, xr.Dataset]]:
    """The demands on which TSMC did not diverge, and its runs."""
    for demand in DEMANDS:
        run = trajectories[f"{demand}-tsmc"]
        if not run["diverged"]:
            yield demand, run


def run_surfaces(run: xr.Dataset) -> list[Surface]:
    c, o, _ = run_laws(run)
    return [
        Surface("s1", "controller.observer.s1", "m/s", o.linear_gain_1, o.power_gain_1, o.exponent),
        Surface("s2", "controller.observer.s2", "N", o.linear_gain_2, o.power_gain_2, o.exponent),
        Surface("xi2", "controller.xi2", "m/s^2", c.linear_gain_2, c.power_gain_2, c.exponent_2),
    ]


def run_laws(run: xr.Dataset) -> RunLaws:
    scenario = scenario_tables(run)
    controller = scenario["controller"]
    observer = with_numbers(OBSERVER, controller["observer"])
    law = with_numbers(TERMINAL._replace(observer=observer), controller)
    return RunLaws(law, observer, scenario["simulation"]["period"])


def with_numbers(block: Any, table: dict[str, Any]) -> Any:
    """A block with the numbers of its table in a scenario; blocks nested in it stay as they are."""
    return block._replace(
        **{name: table[name] for name in block._fields if isinstance(table.get(name), int | float)}
    )
