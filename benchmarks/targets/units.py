"""The controllers that are measured: every law, and those of built-in scenarios, each combination once."""

from collections.abc import Iterator

import numpy as np

from hydroservo import Loop, Simulation
from hydroservo.export.c.vectors import made_vectors
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part, Precision, Unit
from hydroservo.scenario import load_scenario, scenarios
from hydroservo.testing.examples import example
from hydroservo.testing.places import signal_for
from tools.targets.laws import LAWS, types_in
from tools.targets.sources import Rows

__all__ = ["controllers", "units"]

LARGEST = 1e100  # of an input that a loop gives
PERIOD = 1e-4  # s, of the laws' loops


def controllers() -> dict[str, Loop]:
    """Loops by the names of their laws, then by those of their scenarios."""
    short = Simulation(period=PERIOD)
    laws = {
        name: example(Loop, short, controller=law, controls=signal_for(law)) for name, law in LAWS.items()
    }
    found: dict[tuple[type, ...], tuple[str, Loop]] = {}
    for name in sorted(scenarios(), key=lambda name: name.startswith("laws/")):  # those come last
        loop = load_scenario(name)
        found.setdefault(tuple(types_in(loop.controller)), (name, loop))
    return laws | dict(found.values())


def units(loops: dict[str, Loop]) -> Iterator[tuple[str, Unit, Rows]]:
    """Controllers in both precisions, with inputs that their loops give them."""
    for name, loop in loops.items():
        for precision in Precision:
            unit = exported_unit(loop, Part.CONTROLLER, prefix="unit", title=name, precision=precision)
            inputs = made_vectors(loop, Part.CONTROLLER, unit).inputs
            yield name, unit, inputs[(np.abs(inputs) < LARGEST).all(axis=1)]
