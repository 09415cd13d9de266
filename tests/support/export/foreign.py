"""Loops whose load or machine is an FMU."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hydroservo.loop import Loop
from hydroservo.scenario import load_scenario
from tools.reference_fmus import reference_fmu

__all__ = ["DAMPING", "SPRING", "STIFFNESS", "built", "folder", "foreign_load", "with_changes"]

STIFFNESS, DAMPING = 20e3, 400.0
SPRING = {  # a StateSpace without states: F = D (x, v)
    "signals": {"position": "u[1]", "velocity": "u[2]", "force": "y[1]"},
    "parameters": {"m": 2, "n": 0, "r": 1, "D": [STIFFNESS, DAMPING]},
}
OPEN_LOOP = {
    "simulation.duration": "0.1 s",
    "simulation.period": "1 ms",
    "simulation.substeps": 8,
    "controls.type": "Command",
    "controller.type": "OpenLoop",
    "reference.type": "Sine",
    "reference.amplitude": "3 V",
    "reference.frequency": "5 Hz",
}


@cache
def built(model: str) -> Path:
    """A Reference FMU, built once for all tests of a process."""
    return reference_fmu(model, Path(folder(model).name))


@cache
def folder(_name: str) -> "TemporaryDirectory[str]":
    """A folder for each name, which goes when the process ends."""
    return TemporaryDirectory()


def with_changes(load: Mapping[str, Any], **more: Any) -> Loop:
    """A single-rod axis in open loop with a load."""
    return load_scenario("axis/position", OPEN_LOOP | {"load": load} | more, plugins=[built("StateSpace")])


def foreign_load(load: Mapping[str, Any] = SPRING, **more: Any) -> Loop:
    """A single-rod axis whose load is a spring and a damper in the FMU StateSpace."""
    return with_changes({"type": "FMU", "file": str(built("StateSpace")), **load}, **more)
