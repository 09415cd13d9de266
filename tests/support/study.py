"""Runs of the paper's study, made up: no loop is simulated."""

import math

import numpy as np
import xarray as xr

from hydroservo import Loop
from hydroservo.control.controllers import PI, TSMC, Backstepping
from hydroservo.control.metrics import declared_metrics, usual
from hydroservo.runs.provenance import provenance
from hydroservo.testing.examples import example

LAWS = {"pi": example(PI), "backstepping": example(Backstepping), "tsmc": example(TSMC)}
METRIC_FIELDS = {name: declared_metrics(usual(example(Loop, controller=law))) for name, law in LAWS.items()}
ERRORS = {"pi": 0.4e-3, "backstepping": 20e-3, "tsmc": -0.3e-3}
SIGNALS = {
    "controller.xi1": 1e-4,
    "controller.xi2": 1e-3,
    "controller.observer.s1": 1e-5,
    "controller.observer.s2": 10.0,
    "controller.observer.d1": 16.0,
    "controller.observer.d2": 1.1e4,
    "disturbance.d1": 16.1,
    "disturbance.d2": 1.2e4,
}


def made_up(demand, controller, scale=1.0):
    """A run with a known error, recorded every 2 ms, that looks like one of simulate's."""
    time = np.arange(4001) * 2e-3
    wave = np.sin(0.5 * np.pi * time)
    value = 0.03 * (wave if demand == "sine" else np.where(np.mod(time + 1e-9, 4.0) < 2.0, 1.0, -1.0))
    signals = {
        "controlled.value": value + ERRORS[controller] * wave,
        "reference.value": value,
        "controller.u": 0.03 * wave,
    }
    if controller == "tsmc":
        signals |= {name: size * wave for name, size in SIGNALS.items()}
    fields = METRIC_FIELDS[controller]
    metrics = {name: scale * (1 + i) * 1e-3 for i, name in enumerate(fields)}
    metrics |= {"stroke_left": False, "diverged": False}
    loop = example(Loop, controller=LAWS[controller])
    about = dict.fromkeys(signals, ("", "")) | {"controlled.value": ("m/s", "velocity")}
    return xr.Dataset(
        {
            name: ("time", values, {"units": about[name][0], "long_name": about[name][1] or name})
            for name, values in signals.items()
        }
        | {name: ((), metrics[name], {"units": field.unit}) for name, field in fields.items()},
        coords={"time": ("time", time, {"units": "s"})},
        attrs=provenance(loop, loop),
    )


def made_up_runs():
    return {f"{demand}-{name}": made_up(demand, name) for demand in ("sine", "square") for name in LAWS}


def lost(data):
    """The same run, diverged after a second: nan from there on."""
    time = data["time"].to_numpy()
    broken = data.copy(deep=True)
    for name in data.data_vars:
        if data[name].dims:
            broken[name].values[time > 1.0] = np.nan
    for name in METRIC_FIELDS["tsmc"].keys() & broken.keys():
        broken[name].values = np.array(math.inf if name.endswith("error") else math.nan)
    broken["diverged"].values, broken["stroke_left"].values = np.array(True), np.array(True)
    return broken
