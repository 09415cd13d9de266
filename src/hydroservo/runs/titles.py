"""What the controller of a run is called."""

from typing import TYPE_CHECKING

from hydroservo.runs.results import scenario_of

if TYPE_CHECKING:
    import xarray as xr


def controller_name(dataset: "xr.Dataset") -> str:
    """The type of a run's law, whatever wraps it: what its colour follows."""
    return controller_types(dataset)[-1]


def controller_title(dataset: "xr.Dataset") -> str:
    """What plots call the controller of a run, such as "TSMC in ValveInversion"."""
    return " in ".join(reversed(controller_types(dataset)))


def controller_types(dataset: "xr.Dataset") -> list[str]:
    """The types of a run's wrappers, outermost first, and of the law inside them."""
    table = scenario_of(dataset)["controller"]
    found = [str(table["type"])]
    while isinstance(table := table.get("controller"), dict):
        found.append(str(table["type"]))
    return found
