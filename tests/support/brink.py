"""Gains with which machines of ``axis/`` hunt, or stand within a few decibels of it."""

from collections.abc import Mapping
from pathlib import Path

import tomli_w

from hydroservo import load_scenario
from hydroservo.control.loop import Loop
from hydroservo.scenario.scenario_files import nest_changes

INNER = "controller.controller"
PID = f"{INNER}.controller"
BRINK: Mapping[str, Mapping[str, object]] = {
    "axis/position": {
        f"{INNER}.threshold": "0.38807 V",
        f"{PID}.proportional_gain": "2889.9 V/m",
        f"{PID}.integral_gain": "17907 V/(m s)",
        f"{PID}.rate_feedforward": "30.381 V s/m",
    },
    "axis/position-adrc": {
        f"{INNER}.threshold": "0.56022 V",
        f"{PID}.input_gain": "0.031665 m/(s V)",
        f"{PID}.bandwidth": "293.15 rad/s",
        f"{PID}.observer_bandwidth": "71.914 rad/s",
    },
    "axis/force": {f"{INNER}.proportional_gain": "1.0685 V/kN", f"{INNER}.integral_gain": "89.404 V/(kN s)"},
    "axis/pump-controlled": {
        f"{INNER}.proportional_gain": "1994 V/m",
        f"{INNER}.integral_gain": "9648.5 V/(m s)",
        f"{INNER}.rate_feedforward": "77.85 V s/m",
    },
    "axis/crane": {
        f"{INNER}.type": "PID",
        f"{INNER}.proportional_gain": "413.53 V/m",
        f"{INNER}.integral_gain": "1875.1 V/(m s)",
        f"{INNER}.rate_feedforward": "10.53 V s/m",
        f"{INNER}.anti_windup": "5 1/s",
    },
}


def at_the_brink(name: str) -> Loop:
    """A scenario with such gains."""
    return load_scenario(name, BRINK.get(name, {}))


def brink_file(folder: Path, name: str) -> Path:
    """Such a scenario as a file."""
    file = folder / f"{name.rpartition('/')[2]}.toml"
    file.write_text(f'base = "{name}"\n{tomli_w.dumps(nest_changes(dict(BRINK[name])))}', encoding="utf-8")
    return file
