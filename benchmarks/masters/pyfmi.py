"""PyFMI's Master: Jacobi steps."""

from collections.abc import Sequence

from benchmarks.masters.master import Master
from benchmarks.masters.system import SAMPLES, VELOCITY, System
from hydroservo.export.fmu import PARTS
from hydroservo.export.unit import Part

__all__ = ["MASTERS"]


def velocities(system: System) -> Sequence[float]:
    from pyfmi import Master as Coupled
    from pyfmi import load_fmu

    logs = {part: str(system.folder / f"{part}.log") for part in PARTS}
    units = {part: load_fmu(str(system.fmu(part)), log_file_name=logs[part]) for part in PARTS}
    links = [(units[start], name, units[end], name) for start, end, name in system.connections]
    coupled = Coupled(list(units.values()), links)
    options = coupled.simulate_options()
    options["step_size"] = system.period
    options["result_handling"] = "memory"
    result = coupled.simulate(final_time=SAMPLES * system.period, options=options)
    return [float(value) for value in result[PARTS.index(Part.MACHINE)][VELOCITY][:SAMPLES]]


MASTERS = (Master("PyFMI Master", "PyFMI", "reads all outputs, sets all inputs, steps all", velocities),)
