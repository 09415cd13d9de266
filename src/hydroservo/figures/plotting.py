"""The picture of whatever a simulation returned."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from hydroservo.errors import HydroservoError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["plot"]


def plot(
    results: "xr.Dataset | Sequence[xr.Dataset] | Mapping[str, xr.Dataset]", metric: str = "rms_error"
) -> "Figure":
    """The picture of a run, of several runs on common axes, or of a table of many.

    A run shows velocity and demand, error and command, and with an observer what it estimates; several show
    the first three, and say where they differ in more than their controllers. A table shows a metric against
    each number that varied. Notebooks show the picture; ``savefig`` writes it.

    Args:
        results: what ``simulate`` returned; a list of these, or several by the names that the legend is to
            have; or what ``simulate_batch`` returned.
        metric: of a table, the one to show.

    Raises:
        HydroservoError: it is none of these, or a signal that the picture shows was not recorded.
    """
    import xarray as xr

    from hydroservo.figures.batch import plot_batch
    from hydroservo.figures.comparison import plot_comparison
    from hydroservo.figures.run import plot_run

    if not isinstance(results, xr.Dataset):
        named = (
            results if isinstance(results, Mapping) else dict(zip(names_of(results), results, strict=True))
        )
        return plot_comparison([*named.values()], [*named])
    if "run" not in results.dims:
        return plot_run(results)
    if metric not in results:
        raise HydroservoError(f"{metric!r} is no metric of this table")
    numbers = [str(name) for name in results.data_vars if "." in str(name)]
    return plot_batch(results, [name for name in numbers if name != "simulation.seed"], metric)


def names_of(runs: "Sequence[xr.Dataset]") -> list[str]:
    """What each run's controller is called, numbered where it comes again."""
    from hydroservo.figures.trace import controller_title

    types = [controller_title(run) for run in runs]
    again, met = Counter(types), Counter[str]()
    names = []
    for name in types:
        met[name] += 1
        names.append(f"{name} {met[name]}" if again[name] > 1 else name)
    return names
