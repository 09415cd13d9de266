"""Logs of a simulated machine as a bench would have recorded it."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

import hydroservo as hs
from hydroservo.identification.log import SIGNALS

SCENARIO = "rig/1khz-pi-square"
SHORT = {  # in which its demand goes up and down at once, and steps are as long as its machine allows
    "simulation.duration": "2 s",
    "simulation.record_period": "1 ms",
    "simulation.substeps": 3,
    "reference.period": "0.4 s",
}
WRONG = {"plant.mass": 7.0, "valve.time_constant": 0.012}  # what a scenario believes before a fit
TOLD = ("plant.mass", "plant.damping", "plant.bulk_modulus", "valve.time_constant")
TOGETHER = ("valve.gain", "valve.orifice.discharge_coefficient")  # of which the product alone counts
SILENT = "plant.stroke"  # nothing depends on it
RANGES = dict.fromkeys((*TOLD, *TOGETHER), "-40%..+70%") | {SILENT: "-10%..+10%"}
LATE = 3  # samples
OUTLIERS = 8  # of each signal
NOISE = {"velocity": 2e-4, "hydraulic_force": 5.0}  # standard deviations
EXAMPLE = {**SHORT, "simulation.duration": "0.5 s", "reference.period": "0.2 s"}  # of examples/bench_log.csv
RESOLUTION = {"velocity": 1e-4, "hydraulic_force": 2.0}

Signals = dict[str, NDArray[np.float64]]


def exact_log(changes: Mapping[str, object] = SHORT, scenario: str = SCENARIO) -> Signals:
    """What the machine does, without error."""
    run = hs.simulate(hs.load_scenario(scenario, changes))
    return {
        "time": run.time.values,
        "command": run["controller.u"].values,
        "velocity": run["plant.velocity"].values,
        "hydraulic_force": run["plant.hydraulic_force"].values,
    }


def recorded(exact: Signals, seed: int) -> Signals:
    """The same with noise, quantisation, delay and outliers."""
    rng = np.random.default_rng(seed)
    found = dict(exact)
    for name, noise in NOISE.items():
        late = np.concatenate([np.full(LATE, exact[name][0]), exact[name][:-LATE]])
        seen = late + rng.normal(scale=noise, size=late.size)
        at = rng.choice(late.size, OUTLIERS, replace=False)
        seen[at] += rng.choice([-1.0, 1.0], OUTLIERS) * np.ptp(late) * rng.uniform(0.2, 1.0, OUTLIERS)
        found[name] = RESOLUTION[name] * np.round(seen / RESOLUTION[name])
    return found


def with_units(log: Signals) -> Signals:
    """The signals under headers that name their units, as a CSV file has them."""
    return {f"{name} [{SIGNALS[name].unit}]": values for name, values in log.items()}
