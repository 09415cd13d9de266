"""In what runs differ besides their controllers, and which of them may be called the best."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hydroservo.metrics import SMALLER_IS_BETTER
from hydroservo.results import best_runs, metrics_of, scenario_of

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["differences", "winners"]

Table = Mapping[str, Any]

NO_CONDITION = ("controller", "simulation.record_period")  # what a comparison is of, and what no metric sees
MODEL = "nominal"  # follows the controller's own model; only estimates are measured against it
ESTIMATES = ("estimate_rms_error_1", "estimate_rms_error_2")


def differences(runs: Sequence["xr.Dataset"]) -> dict[str, tuple[Any, ...]]:
    """In what some runs differ besides their controllers: what must be empty for a fair comparison.

    The controller is the law with its wrappers, gains and model. All else is a condition: the machine, the
    demand and the load, sensors, the hold, sampling, integration, the seed; but not how often a run was
    recorded.

    Args:
        runs: what ``simulate`` returned for each.

    Returns:
        What each run has by dotted path in SI units. Where blocks differ in their type that is the names of
        the types, and of recorded signals a digest.

    Fails to see that a condition has no effect, such as another seed where nothing is random.
    """
    return {path: values for path, values in all_differences(runs).items() if not within(path, MODEL)}


def winners(runs: Sequence["xr.Dataset"]) -> dict[str, set[int]]:
    """By metric, which runs have its best value; never one that diverged.

    None where more is not worse, where all are equal, and where runs differ in more than their controllers.
    An observer's errors are those of one quantity only where the models agree too.

    Args:
        runs: what ``simulate`` returned for each.
    """
    paths, metrics = all_differences(runs), [metrics_of(run) for run in runs]
    fair, same_model = not any(not within(path, MODEL) for path in paths), not paths
    return {
        name: best_runs(metrics, name) if (same_model if name in ESTIMATES else fair) else set()
        for name in SMALLER_IS_BETTER
    }


def all_differences(runs: Sequence["xr.Dataset"]) -> dict[str, tuple[Any, ...]]:
    """As :func:`differences`, that of the models against which disturbances are defined included."""
    return {
        path: values
        for path, values in unequal("", [as_asked(run) for run in runs])
        if not any(within(path, other) for other in NO_CONDITION)
    }


def as_asked(run: "xr.Dataset") -> Table:
    """The scenario of a run, its substeps "auto" where the run chose them."""
    scenario = scenario_of(run)
    return scenario | {
        "simulation": scenario["simulation"] | ({"substeps": "auto"} if "substeps" in run.attrs else {})
    }


def unequal(path: str, values: Sequence[Any]) -> Iterator[tuple[str, tuple[Any, ...]]]:
    """What is not the same everywhere in nested tables, by path; one entry for tables of several types."""
    first = values[0]
    if not isinstance(first, Mapping):
        if not all(same(first, value) for value in values):
            yield path, tuple(values)
        return
    types = [(table["type"], table.get("module")) for table in values]
    if len(set(types)) > 1:
        distinct = len({name for name, _ in types}) == len(set(types))
        yield path, tuple(name if distinct or not module else f"{module}.{name}" for name, module in types)
        return
    for name in first:
        if name not in ("type", "module"):
            yield from unequal(f"{path}.{name}" if path else name, [table[name] for table in values])


def same(one: Any, other: Any) -> bool:
    return bool(one == other or (one != one and other != other))  # noqa: PLR0124 - not a number is itself


def within(path: str, part: str) -> bool:
    return path == part or path.startswith(f"{part}.")
