"""Logs of an axis that a command moves to and fro under a load, as a bench would have recorded them."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

import hydroservo as hs
from hydroservo.identification import Identified
from hydroservo.identification.experiment import experiment, predict_traces
from hydroservo.identification.log import OUTPUTS
from hydroservo.identification.segments import Segment
from tests.support.axes import AXIS, COMMANDED, step

PERIOD = 5e-3  # [s]
SAMPLES = 800
LOADED = COMMANDED | {
    "load": {"type": "Constant", "amplitude": "2 kN"},
    "reference": step("0 V", "0 V", "0.1 s"),
    "valve.type": "FirstOrderValve",
    "valve.time_constant": "30 ms",
    "simulation.substeps": "auto",
    "simulation.tolerance": 1e-4,
}
NOISE = {"position": 1e-5, "velocity": 1e-4}

Signals = dict[str, NDArray[np.float64]]


def moves(
    changes: Mapping[str, object] = {},
    late: int = 0,
    signals: tuple[str, ...] = ("position",),
    volts: float = 0.5,
    samples: int = SAMPLES,
    quiet: bool = False,
) -> Signals:
    """A log of steps at random, with noise.

    Args:
        changes: what makes the axis, over LOADED.
        late: samples by which what is measured comes late.
        signals: that are measured.
        volts: of the largest step.
        samples: of the log.
        quiet: whether there is no noise.
    """
    rng = np.random.default_rng(0)
    jumps = np.sort(rng.choice(samples, samples // 40, replace=False))
    levels = volts * rng.choice([-1.0, -0.5, 0.5, 1.0], jumps.size + 1)
    levels[0] = 0.0
    command = levels[np.searchsorted(jumps, np.arange(samples), side="right")]
    loop = hs.load_scenario(AXIS, LOADED | changes)
    one = experiment(loop, Segment(0, 0.0, PERIOD, {"command": command}, {}), ("plant.stroke",), 40)
    shown = predict_traces(one, {"plant.stroke": np.array([loop.plant.stroke])}, 1)[:, :, 0]
    log = {"time": PERIOD * np.arange(samples), "command": command}
    for name in signals:
        values = shown[:, list(OUTPUTS).index(name)]
        there = np.concatenate([np.full(late, values[0]), values[: samples - late]])
        log[name] = there if quiet else there + NOISE[name] * rng.normal(size=samples)
    return log


def fit(
    log: Signals, ranges: Mapping[str, str], changes: Mapping[str, object] = {}, **options: object
) -> Identified:
    """What a log tells of the axis, of which some numbers are believed to be others."""
    return hs.identify(AXIS, log, ranges, changes=LOADED | changes, **{"threads": 1} | options)  # type: ignore[arg-type]
