"""libcosim of the Open Simulation Platform, through libcosimpy: its fixed-step algorithm."""

from collections.abc import Sequence

from benchmarks.masters.master import Master
from benchmarks.masters.system import SAMPLES, VELOCITY, System
from hydroservo.export.unit import Part

__all__ = ["MASTERS"]


def velocities(system: System) -> Sequence[float]:
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.FATAL)  # it wants a start value of the time, which FMI forbids
    execution = CosimExecution.from_ssp_file(str(system.ssp), round(1e9 * system.period))
    machine = execution.slave_index_from_instance_name(Part.MACHINE.value)
    variables = {one.name.decode(): one.reference for one in execution.slave_variables(machine)}
    observer = CosimObserver.create_time_series(SAMPLES)
    execution.add_observer(observer)
    observer.start_time_series(machine, variables[VELOCITY], CosimVariableType.REAL)
    if not execution.step(SAMPLES - 1):
        raise RuntimeError("a step failed")
    _, _, values = observer.time_series_real_samples(machine, variables[VELOCITY], 1, SAMPLES - 1)
    return [0.0, *values]  # it observes after its steps


MASTERS = (Master("libcosim", "libcosimpy", "steps all, hands all outputs over", velocities),)
