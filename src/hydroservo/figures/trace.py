"""The signals of a run that plots show."""

import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from hydroservo.errors import HydroservoError
from hydroservo.runs.cautions.unrecorded import Unrecorded, unrecorded_command
from hydroservo.runs.results import scenario_of

Samples = NDArray[np.float64]
CONTROLLED = "controlled.value"


class Trace(NamedTuple):
    """What a plot shows of a run, in SI units; a diverged run ends where it was lost."""

    time: Samples
    demand: Samples
    signal: Samples  # that the loop controls
    error: Samples  # demand less signal
    command: Samples
    disturbances: tuple[Samples, ...]  # d_L1 [m/s^2] and d_L2 [N/s]
    estimates: tuple[Samples, ...]  # of both; empty without an observer
    diverged: bool
    unrecorded: Unrecorded = Unrecorded()
    name: str = "velocity"  # of the controlled signal
    unit: str = "m/s"  # of it
    pressures: Mapping[str, Samples] = {}  # in both chambers, and of the supply where it is known; by name


def trace_of(dataset: xr.Dataset) -> Trace:
    """The signals that plots show."""
    missing = [path for path in (CONTROLLED, "reference.value", "controller.u") if path not in dataset]
    if missing:
        raise HydroservoError(f"a plot needs {', '.join(missing)}, which this run did not record")
    demand, signal = dataset["reference.value"].values, dataset[CONTROLLED].values
    diverged = bool(dataset["diverged"])
    end = length_shown(signal) if diverged else demand.size
    truths, estimates = pair(dataset, "disturbance"), pair(dataset, observer_path(dataset))
    both = bool(truths and estimates)
    return Trace(
        time=dataset["time"].values[:end],
        demand=demand[:end],
        signal=signal[:end],
        error=(demand - signal)[:end],
        command=dataset["controller.u"].values[:end],
        disturbances=tuple(values[:end] for values in truths if both),
        estimates=tuple(values[:end] for values in estimates if both),
        diverged=diverged,
        unrecorded=unrecorded_command(dataset, scenario_of(dataset)["simulation"]["period"]),
        name=dataset[CONTROLLED].attrs.get("long_name", ""),
        unit=dataset[CONTROLLED].attrs.get("units", ""),
        pressures={name: values[:end] for name, values in pressures(dataset).items()},
    )


def pressures(dataset: xr.Dataset) -> dict[str, Samples]:
    """The gauge pressures in the chambers and of the supply; empty where the chambers were not recorded."""
    chambers = {"chamber A": "plant.pressure_a", "chamber B": "plant.pressure_b"}
    if not set(chambers.values()) <= set(dataset.data_vars):
        return {}
    found = {name: dataset[path].values for name, path in chambers.items()}
    given = scenario_of(dataset)["supply"].get("supply_pressure")
    if "supply.pressure" in dataset:
        found["supply"] = dataset["supply.pressure"].values
    elif given is not None:
        found["supply"] = np.full(dataset["time"].size, float(given))
    return found


def length_shown(signal: Samples) -> int:
    """How many samples of a diverged run come before it was lost; at least two."""
    lost = ~np.isfinite(signal)
    return max(int(np.argmax(lost)) if lost.any() else signal.size, 2)


def observer_path(dataset: xr.Dataset) -> str:
    """The path of the first part of the controller that holds two estimates d1 and d2; "" without one."""
    names = (str(name) for name in dataset.data_vars)
    holders = (name.removesuffix(".d1") for name in names if re.fullmatch(r"controller\..*\bd1", name))
    return next((one for one in holders if f"{one}.d2" in dataset), "")


def pair(dataset: xr.Dataset, path: str) -> tuple[Samples, ...]:
    """The signals d1 and d2 at a path; nothing unless both were recorded."""
    names = (f"{path}.d1", f"{path}.d2")
    return tuple(dataset[name].values for name in names) if set(names) <= set(dataset.data_vars) else ()
