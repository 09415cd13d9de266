"""What the controller of a run is called."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from hydroservo.runs.results import scenario_of

if TYPE_CHECKING:
    import xarray as xr


def controller_name(dataset: "xr.Dataset") -> str:
    """The type of a run's law, whatever wraps it: what its colour follows."""
    return types_in(scenario_of(dataset)["controller"])[-1]


def controller_title(dataset: "xr.Dataset") -> str:
    """What plots call the controller of a run, such as "TSMC in ValveInversion"."""
    return law_title(scenario_of(dataset))


def law_title(tables: Mapping[str, Any]) -> str:
    """The law of a scenario with its wrappers, such as "TSMC in ValveInversion"."""
    return " in ".join(reversed(types_in(tables["controller"])))


def types_in(table: Mapping[str, Any]) -> list[str]:
    """The types of a law's wrappers, outermost first, and of the law inside them."""
    inner = table.get("controller")
    return [str(table["type"]), *(types_in(inner) if isinstance(inner, Mapping) else [])]
