"""FMPy: its player of SSP files, its container, and one FMU of the whole loop."""

from collections.abc import Sequence
from pathlib import Path

from benchmarks.masters.master import Master
from benchmarks.masters.system import SAMPLES, VELOCITY, System
from hydroservo.export.fmu import PARTS
from hydroservo.export.unit import Part

__all__ = ["MASTERS", "played"]


def played(system: System, file: Path) -> Sequence[float]:
    """One FMU that holds all of the loop."""
    from fmpy import simulate_fmu

    result = simulate_fmu(
        str(file),
        stop_time=SAMPLES * system.period,
        step_size=system.period,
        output_interval=system.period,
        output=[VELOCITY],
    )
    return [float(value) for value in result[VELOCITY][:SAMPLES]]


def loop(system: System) -> Sequence[float]:
    return played(system, system.fmu(Part.LOOP))


def ssp(system: System) -> Sequence[float]:
    from fmpy.ssp.simulation import simulate_ssp

    result = simulate_ssp(str(system.ssp), stop_time=SAMPLES * system.period, step_size=system.period)
    (name,) = (name for name in result.dtype.names if name.endswith(VELOCITY))
    return [0.0, *(float(value) for value in result[name][: SAMPLES - 1])]  # it records after its steps


def container(system: System) -> Sequence[float]:
    """Takes the connections one by one, in the order in which they are listed."""
    from fmpy import read_model_description
    from fmpy.container_fmu.cli import create_container_fmu
    from fmpy.container_fmu.config import Component, Configuration, Connection
    from fmpy.model_description import CoSimulation, ModelDescription, ModelVariable

    abouts = {part: read_model_description(system.fmu(part)) for part in PARTS}
    known = {part: {one.name: one for one in about.modelVariables} for part, about in abouts.items()}
    units = {part: Component(part.value, system.fmu(part), abouts[part]) for part in PARTS}
    for variables in known.values():
        for one in variables.values():
            one.type = "Float64"  # as its configuration calls FMI 2's Real
    links = [
        Connection(units[start], [known[start][name]], units[end], [known[end][name]])
        for start, end, name in system.connections
    ]
    time = ModelVariable("time", 0, "Float64", causality="independent", variability="continuous")
    output = ModelVariable(VELOCITY, 1, "Float64", causality="output", initial="calculated")
    description = ModelDescription(
        fmiVersion="3.0",
        modelName="loop",
        instantiationToken="loop",
        modelVariables=[time, output],
        coSimulation=CoSimulation(fixedInternalStepSize=system.period),
    )
    mapping = {output: [(units[Part.MACHINE], known[Part.MACHINE][VELOCITY])]}
    file, folder = system.folder / "fmpy-container.fmu", system.folder / "fmpy-container"
    folder.mkdir()
    create_container_fmu(Configuration(False, description, [*units.values()], links, mapping), folder, file)
    return played(system, file)


MASTERS = (
    Master("FMPy: loop as one FMU", "fmpy", "no coupling", loop),
    Master(
        "FMPy container_fmu",
        "fmpy",
        "connection by connection as listed, command last; steps all",
        container,
    ),
    Master("FMPy simulate_ssp", "fmpy", "sets the inputs of all, steps all, reads the outputs of all", ssp),
)
