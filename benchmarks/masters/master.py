"""What a master is: a tool, one way to use it, and the velocities that the machine has under it."""

from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import NamedTuple

from benchmarks.masters.system import System

__all__ = ["Master"]


class Master(NamedTuple):
    """One way to couple the FMUs of a system.

    Attributes:
        name: as the table calls it.
        package: the distribution that must be installed.
        how: what it does between the units, for people.
        velocities: the machine's velocity at each sample of a system [m/s]. Raises what the tool raises.
    """

    name: str
    package: str
    how: str
    velocities: Callable[[System], Sequence[float]]

    def version(self) -> str | None:
        """Of the package; None if it is not there."""
        try:
            return version(self.package)
        except PackageNotFoundError:
            return None
