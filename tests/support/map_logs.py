"""Logs of the experiments in examples/maps, as a bench would have recorded them."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import hydroservo as hs

FOLDER = Path(__file__).parents[2] / "examples" / "maps"
COLUMNS = {
    "command": "controller.u",
    "position": "plant.position",
    "pressure_a": "plant.pressure_a",
    "pressure_b": "plant.pressure_b",
}
NOISE = {"position": 5e-7, "pressure_a": 8e3, "pressure_b": 8e3}  # standard deviations
RESOLUTION = {"position": 1e-6, "pressure_a": 4e3, "pressure_b": 4e3}

Signals = dict[str, NDArray[np.float64]]


def scenario(name: str) -> str:
    """The file of an experiment."""
    return str(FOLDER / f"{name}.toml")


@cache
def exact(name: str, changes: tuple[tuple[str, object], ...] = ()) -> Mapping[str, NDArray[np.float64]]:
    """What the machine does, without error."""
    run = hs.simulate(hs.load_scenario(scenario(name), dict(changes)))
    return {"time": run.time.values, **{key: run[path].values for key, path in COLUMNS.items()}}


def seen(name: str, seed: int, changes: tuple[tuple[str, object], ...] = ()) -> Signals:
    """The same with noise and quantisation."""
    rng = np.random.default_rng(seed)
    found = dict(exact(name, changes))
    for key, noise in NOISE.items():
        noisy = found[key] + rng.normal(scale=noise, size=found[key].size)
        found[key] = RESOLUTION[key] * np.round(noisy / RESOLUTION[key])
    return found
