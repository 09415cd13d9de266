"""Searches for gains by ``hydroservo tune`` that take no time, and what they print."""

import shlex

import numpy as np

from hydroservo import simulate
from hydroservo.scenario import load_scenario, parse_override

NAMES = ("paper/sine-pi", "paper/square-pi")
GIVEN = (
    *("simulation.duration=50 ms", "simulation.period=1 ms", "simulation.substeps=4"),
    "tune.bounded=false",
    *("valve.type=FirstOrderValve", "valve.time_constant=10 ms"),
    *("sensors.type=RigSensors", "sensors.position={type='Encoder', resolution='1 um'}"),
    "sensors.velocity={type='FilteredDifference', time_constant='2 ms'}",
)
SHORT = [word for change in GIVEN for word in ("--set", change)]
GAIN, FILTER = "controller.proportional_gain", "sensors.velocity.time_constant"
VARIED = ("--vary", f"{GAIN}=0.3..30 V s/m", "--vary", f"{FILTER}=5e-05..0.2 s")
WINDUP = "controller.anti_windup"
RUNAWAY = ("--set", f"{WINDUP}=1e12", "--set", "controller.saturation.limit=50 mV")  # its integral overflows
FEW = ("--candidates", "64", "--seed", "2")
TUNE = ("tune", *NAMES, *SHORT, *VARIED, "--weights", "1,2.5", "--seeds", "3", *FEW)
QUICK = ("tune", NAMES[0], *SHORT, *FEW)


def again(scenario, parameters, metric="rms_error", seeds=3):
    """The mean of a metric over single runs, with values that are set as a user would."""
    changes = dict(map(parse_override, GIVEN)) | parameters
    runs = [load_scenario(scenario, changes | {"simulation.seed": seed}) for seed in range(seeds)]
    return np.mean([simulate(run, record=())[metric] for run in runs])


def flat(tables, prefix=""):
    for name, value in tables.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def rows_of(text):
    """The first cell of each row of the tables, and the others."""
    lines = (line.strip("│┃ ").replace("┃", "│") for line in text.splitlines() if line.startswith(("│", "┃")))
    return {row[0].strip(): [cell.strip() for cell in row[1:]] for row in (line.split("│") for line in lines)}


def replay_in(text, start="With these values: "):
    """The words of the command that replays what was found."""
    (line,) = (line for line in text.splitlines() if line.startswith("With these values"))
    assert line.startswith(start)
    return shlex.split(line.removeprefix(start))
