"""Ecos, whose library wants that of oneTBB (``pip install tbb``) on the loader's path."""

from collections.abc import Sequence

from benchmarks.masters.master import Master
from benchmarks.masters.system import SAMPLES, VELOCITY, System
from hydroservo.export.unit import Part

__all__ = ["MASTERS"]


def velocities(system: System) -> Sequence[float]:
    from ecospy import EcosSimulation

    values = []
    with EcosSimulation(step_size=system.period, ssp_path=str(system.ssp)) as simulation:
        simulation.init()
        for _ in range(SAMPLES):
            values.append(simulation.get_real(f"{Part.MACHINE}::{VELOCITY}"))
            simulation.step()
    return values


MASTERS = (Master("Ecos", "ecospy", "steps all, hands all outputs over", velocities),)
