"""CoFMPy's master, Jacobi and Gauss-Seidel.

Its coordinator orders the units of a loop by the hashes of their names, another way in each process; so the
master is given an order here.
"""

from collections.abc import Sequence
from functools import partial

from benchmarks.masters.master import Master
from benchmarks.masters.system import SAMPLES, VELOCITY, System
from hydroservo.export.fmu import PARTS
from hydroservo.export.unit import Part

__all__ = ["MASTERS"]


def velocities(system: System, method: str) -> Sequence[float]:
    from cofmupy.master import DefaultMaster

    units = [{"id": part.value, "path": str(system.fmu(part)), "initialization": {}} for part in PARTS]
    links = {(start.value, name): [(end.value, name)] for start, end, name in system.connections}
    loop, rest = [Part.CONTROLLER.value, Part.MACHINE.value], [Part.DEMAND.value]
    master = DefaultMaster(units, links, [loop, rest], cosim_method=method)
    master.init_simulation()
    for _ in range(SAMPLES - 1):
        master.do_step(system.period)
    values = master.get_results()[Part.MACHINE.value, VELOCITY]
    return [0.0, *(float(value) for value in values)]  # it records after its steps


MASTERS = (
    Master(
        "CoFMPy gauss_seidel",
        "cofmupy",
        "unit by unit as listed: controller, machine, demand; inputs are 0 at first",
        partial(velocities, method="gauss_seidel"),
    ),
    Master(
        "CoFMPy jacobi",
        "cofmupy",
        "steps all, hands all outputs over; inputs are 0 at first",
        partial(velocities, method="jacobi"),
    ),
)
