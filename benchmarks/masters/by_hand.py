"""Masters of a few lines around FMPy: in the order of the dependencies, unit by unit, all at once."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any

from benchmarks.masters.master import Master
from benchmarks.masters.system import SAMPLES, VELOCITY, System
from hydroservo.export.fmu import PARTS, FmiVersion
from hydroservo.export.unit import Part

__all__ = ["MASTERS"]


class Opened:
    """An FMU with its variables by name."""

    def __init__(self, system: System, part: Part) -> None:
        from fmpy import extract, read_model_description
        from fmpy.simulation import instantiate_fmu

        folder = system.folder / part
        if not folder.exists():
            extract(system.fmu(part), str(folder))
        about = read_model_description(folder)
        self.slave: Any = instantiate_fmu(folder, about, fmi_type="CoSimulation")
        self.references = {one.name: one.valueReference for one in about.modelVariables}
        self.newer = system.version is FmiVersion.FMI3

    def get(self, name: str) -> float:
        read = self.slave.getFloat64 if self.newer else self.slave.getReal
        return float(read([self.references[name]])[0])

    def set(self, name: str, value: float) -> None:
        write = self.slave.setFloat64 if self.newer else self.slave.setReal
        write([self.references[name]], [value])


Units = dict[Part, Opened]
Step = Callable[[System, Units, float], None]


@contextmanager
def opened(system: System, part: Part) -> Iterator[Opened]:
    unit = Opened(system, part)
    if not unit.newer:
        unit.slave.setupExperiment(startTime=0.0)
    unit.slave.enterInitializationMode()
    unit.slave.exitInitializationMode()
    yield unit
    unit.slave.terminate()
    unit.slave.freeInstance()


def run(step: Step, system: System) -> Sequence[float]:
    velocities = []
    with ExitStack() as stack:
        units = {part: stack.enter_context(opened(system, part)) for part in PARTS}
        for k in range(SAMPLES):
            velocities.append(units[Part.MACHINE].get(VELOCITY))
            step(system, units, k * system.period)
    return velocities


def in_order(system: System, units: Units, time: float) -> None:
    for start, end, name in system.connections:
        units[end].set(name, units[start].get(name))
    for unit in units.values():
        unit.slave.doStep(time, system.period)


def unit_by_unit(system: System, units: Units, time: float) -> None:
    for part in PARTS:
        for start, end, name in system.connections:
            if end is part:
                units[end].set(name, units[start].get(name))
        units[part].slave.doStep(time, system.period)


def at_once(system: System, units: Units, time: float) -> None:
    values = [units[start].get(name) for start, _, name in system.connections]
    for (_, end, name), value in zip(system.connections, values, strict=True):
        units[end].set(name, value)
    for unit in units.values():
        unit.slave.doStep(time, system.period)


MASTERS = tuple(
    Master(f"by hand: {name}", "fmpy", how, partial(run, step))
    for name, how, step in (
        ("in order", "connection by connection, command last; steps all", in_order),
        (
            "unit by unit",
            "sets a unit's inputs and steps it: controller, machine, demand",
            unit_by_unit,
        ),
        ("all at once", "reads all outputs, sets all inputs, steps all", at_once),
    )
)
