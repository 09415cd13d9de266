"""The table of a batch, with all that it takes to run each of its runs again."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from hydroservo.runs.results import as_json
from hydroservo.scenario.build import Argument
from hydroservo.scenario.sampling import Drawn

if TYPE_CHECKING:
    import xarray as xr


def table_of_runs(
    found: "xr.Dataset", drawn: Drawn, seed: int, arguments: Mapping[str, Argument]
) -> "xr.Dataset":
    """The table of a batch, with all that it takes to run each of its runs again.

    Args:
        found: what ``simulate_batch`` returned.
        drawn: what each run sets.
        seed: of the draws.
        arguments: what constructors take, by path.
    """
    deviations = {
        f"uncertainty.{path}": ("run", column, {"units": "", "long_name": f"relative deviation of {path}"})
        for path, column in drawn.deviations.items()
    }
    taken = {
        path: ("run", column, {"units": field.unit, "long_name": field.meaning})
        for path, column in drawn.values.items()
        if path in arguments and (field := arguments[path].field)
    }
    made = [path for path in drawn.parameters if path not in drawn.values]
    about = {"drawn_with_seed": seed, "varied": as_json(drawn.ranges)}
    table = found.drop_vars(made).assign(taken | deviations).assign_attrs(about)
    return table[[*drawn.values, *deviations, *(name for name in found if name not in drawn.parameters)]]
