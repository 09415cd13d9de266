"""In what runs differ besides their controllers, and which of them may be called the best."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hydroservo.runs.arguments import checked_runs
from hydroservo.runs.results import best_runs, metric_fields, metrics_of, scenario_of

if TYPE_CHECKING:
    import xarray as xr

Table = Mapping[str, Any]

NO_CONDITION = ("controller", "simulation.record_period")  # what a comparison is of, and what no metric sees
ESTIMATES = ("estimate_rms_error_1", "estimate_rms_error_2")  # of disturbances against the law's own model


def differences(runs: Sequence["xr.Dataset"]) -> dict[str, tuple[Any, ...]]:
    """In what some runs differ besides their controllers: what must be empty for a fair comparison.

    The controller is the law with its wrappers, gains and model. All else is a condition: the machine, the
    demand and the load, sensors, the hold, sampling, integration, the seed; but not how often a run was
    recorded.

    Args:
        runs: a list of what ``simulate`` returned, at least one: ``differences([one, other])``.

    Returns:
        What each run has by dotted path in SI units. Where blocks differ in their type that is the names of
        the types, and of recorded signals a digest.

    Raises:
        ParameterError: they are something else.

    Fails to see that a condition has no effect, such as another seed where nothing is random.
    """
    return {
        path: values
        for path, values in unequal("", [as_asked(run) for run in checked_runs(runs)])
        if not any(within(path, other) for other in NO_CONDITION)
    }


def winners(runs: Sequence["xr.Dataset"]) -> dict[str, set[int]]:
    """By metric, which runs have its best value; never one that diverged.

    None where more is not worse, where all are equal, and where runs differ in more than their controllers.
    An observer's errors are those of one quantity only where the models agree too.

    Args:
        runs: a list of what ``simulate`` returned, at least one.

    Raises:
        ParameterError: they are something else.
    """
    runs = checked_runs(runs)
    metrics, fair = [metrics_of(run) for run in runs], not differences(runs)
    same_model = not any(True for _ in unequal("", [model_of(run) for run in runs]))
    judged = {name for run in runs for name, field in metric_fields(run).items() if field.smaller_is_better}
    return {
        name: best_runs(metrics, name) if fair and (same_model or name not in ESTIMATES) else set()
        for name in judged
    }


def model_of(run: "xr.Dataset") -> Table:
    """The model that the law of a run believes in, an empty table if it has none."""
    table = scenario_of(run)["controller"]
    while "model" not in table and "controller" in table:
        table = table["controller"]
    found: Table = table.get("model", {"type": ""})
    return found


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
    types = [(table.get("type", ", ".join(table)), table.get("module")) for table in values]
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
