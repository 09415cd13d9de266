"""A workbench for electro-hydraulic servo actuators."""

import sys

from hydroservo._version import __version__

TYPE_CHECKING = False  # as typing has it, which takes longer to import than all the rest here
if TYPE_CHECKING:
    from types import ModuleType

    from hydroservo.batch import simulate_batch
    from hydroservo.block import Field, replace
    from hydroservo.errors import HydroservoError, HydroservoWarning, LoopError, ParameterError, ScenarioError
    from hydroservo.loop import AUTO, Loop, Simulation
    from hydroservo.simulate import simulate

__all__ = [
    "AUTO",
    "Field",
    "HydroservoError",
    "HydroservoWarning",
    "Loop",
    "LoopError",
    "ParameterError",
    "ScenarioError",
    "Simulation",
    "__version__",
    "replace",
    "simulate",
    "simulate_batch",
]

HOMES = {
    "AUTO": "loop",
    "Field": "block",
    "HydroservoError": "errors",
    "HydroservoWarning": "errors",
    "Loop": "loop",
    "LoopError": "errors",
    "ParameterError": "errors",
    "ScenarioError": "errors",
    "Simulation": "loop",
    "replace": "block",
    "simulate_batch": "batch",
}


class Package(type(sys)):  # type: ignore[misc]
    """The package, whose ``simulate`` is the function, of which the import system would make the module."""

    @property
    def simulate(self) -> object:
        return imported("simulate").simulate

    @simulate.setter
    def simulate(self, module: object) -> None:
        pass


def __getattr__(name: str) -> object:
    """What the package offers, and its modules, each imported when first asked for."""
    if name in HOMES:
        return getattr(imported(HOMES[name]), name)
    try:
        return imported(name)
    except ModuleNotFoundError as error:
        if error.name != f"{__name__}.{name}":
            raise
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__


def imported(name: str) -> "ModuleType":
    """A module of the package."""
    from importlib import import_module

    return import_module(f"{__name__}.{name}")


sys.modules[__name__].__class__ = Package
