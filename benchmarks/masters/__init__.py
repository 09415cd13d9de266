"""What tools that couple FMUs make of a loop whose controller answers at once, a tool a file."""

from benchmarks.masters import by_hand, cofmpy, ecos, fmpy, fmucontainer, libcosim, omsimulator, pyfmi
from benchmarks.masters.master import Master

__all__ = ["ALL"]

ALL: tuple[Master, ...] = (
    *fmpy.MASTERS,
    *by_hand.MASTERS,
    *fmucontainer.MASTERS,
    *omsimulator.MASTERS,
    *libcosim.MASTERS,
    *ecos.MASTERS,
    *pyfmi.MASTERS,
    *cofmpy.MASTERS,
)
