"""OMSimulator of OpenModelica: weakly coupled systems."""

from collections.abc import Sequence

from benchmarks.masters.master import Master
from benchmarks.masters.system import SAMPLES, VELOCITY, System
from hydroservo.export.unit import Part

__all__ = ["MASTERS"]


def velocities(system: System) -> Sequence[float]:
    from OMSimulator import SSP, CRef

    model = SSP(str(system.ssp)).instantiate()
    model.setResultFile("")
    model.setStopTime(SAMPLES * system.period)
    model.setFixedStepSize(system.period)
    model.initialize()
    velocity = CRef("loop", Part.MACHINE.value, VELOCITY)
    values = [model.getValue(velocity)]
    for k in range(1, SAMPLES):
        model.stepUntil(k * system.period)
        values.append(model.getValue(velocity))
    model.terminate()
    model.delete()
    return values


MASTERS = (
    Master(
        "OMSimulator",
        "OMSimulator",
        "connection by connection, as they depend on each other; steps all",
        velocities,
    ),
)
