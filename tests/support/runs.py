"""A short run, and what it records."""

import numpy as np
import xarray as xr

from hydroservo import Loop, Simulation, replace
from hydroservo.control.controllers import PI
from hydroservo.testing.examples import example

PATHS = ["plant.velocity", "controller.u", "plant.hydraulic_force"]
LOOP = example(Loop, simulation=Simulation(0.05, 1e-4, 1, 1e-3), controller=PI(0.3, 100.0))
EVERY_SAMPLE = replace(LOOP, {"simulation.record_period": 1e-4})


def trace(result: xr.Dataset) -> np.ndarray:
    return np.column_stack([result[path].values for path in PATHS])
