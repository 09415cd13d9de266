"""What a result says, and its picture, whatever question returned it."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from hydroservo.control.metrics import default_metric
from hydroservo.core.block import is_block
from hydroservo.core.errors import ParameterError, one_of
from hydroservo.runs.arguments import checked_runs, is_result
from hydroservo.runs.results import metric_fields

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.audits import Audit
    from hydroservo.figures.style import Plot
    from hydroservo.identification import Identified, LogFit
    from hydroservo.identification.maps import StaticMap
    from hydroservo.limits import Limits, LimitsOverPeriods
    from hydroservo.linear import Linearization
    from hydroservo.runs.tuned import Tuned
    from hydroservo.scenario.part_sheets import Part
    from hydroservo.show import Finding
    from hydroservo.studies.study import StudyResult

    Records: TypeAlias = (
        Audit
        | Identified
        | LogFit
        | StaticMap
        | Limits
        | LimitsOverPeriods
        | Linearization
        | Tuned
        | Part
        | StudyResult
    )
    Runs = xr.Dataset | Sequence[xr.Dataset] | Mapping[str, xr.Dataset]

WANTED = (
    "must be what simulate or simulate_batch returned, several of simulate in a list or by name, or what "
    "bode, linearize, tune, identify, map_logs, limit, limit_over_periods, audit, study or part returned"
)


def finding(results: "Runs | Records") -> "Finding":
    """What results say, as their commands and notebooks show it.

    Args:
        results: as :func:`~hydroservo.plot` takes them.

    Raises:
        ParameterError: they are none of these.
    """
    if runs := runs_by_name(results):
        from hydroservo.runs.comparison import comparison_finding

        return comparison_finding([*runs.values()], [*runs], [*runs])
    if not is_result(results):
        return record_with_finding(results).finding()
    if "frequency" in results.dims:
        from hydroservo.linear.finding import bode_finding

        return bode_finding(results)
    if "run" not in results.dims:
        from hydroservo.runs.run_finding import run_finding

        return run_finding(results)
    from hydroservo.runs.batch_finding import batch_finding

    return batch_finding(results)


def runs_by_name(results: Any) -> "dict[str, xr.Dataset]":
    """Several runs by their names; none where it is something else."""
    if isinstance(results, Mapping) and not is_result(results):
        return dict(zip(map(str, results), checked_runs([*results.values()], "results"), strict=True))
    if isinstance(results, list | tuple) and not is_block(results):
        runs = checked_runs(results, "results")
        return dict(zip(run_names(runs), runs, strict=True))
    return {}


def record_with_finding(results: Any) -> "Records":
    """A result that is a record, which says its finding itself."""
    if not hasattr(results, "finding"):
        raise ParameterError("results", results, WANTED)
    found: Records = results
    return found


def plot(results: "Runs | Records", metric: str | None = None) -> "Plot":
    """The picture of a run, of several runs on common axes, or of whatever another question returned.

    A run shows what is controlled and its demand, error and command, and with an observer what it estimates;
    several show the first three, and say where they differ in more than their controllers. A table shows a
    metric against each number that varied; frequency responses are shown by
    :func:`~hydroservo.figures.bode.plot_bode`, a linear model by its poles, a search by the metric before and
    after, an identification by how its first log is met, a map by its curve and its scatter, limits by the
    best commands beside the law's, an audit by its margins, a study by its fronts of error and command
    activity, and a part by the curves of its data sheet.
    Notebooks show the picture, and ``save`` writes it: ``hs.plot(run).save("run.pdf", width="one-column")``.

    Args:
        results: what ``simulate`` returned; a list of these, or several by the names that the legend is to
            have; what ``simulate_batch``, ``bode``, ``linearize``, ``tune``, ``identify``, ``map_logs``,
            ``limit``, ``limit_over_periods``, ``audit``, ``study`` or ``part`` returned; or one of the logs
            of an identification.
        metric: of a table, the one to show; the error, or what a table without one has.

    Raises:
        ParameterError: it is none of these, has no such metric, or nothing that a picture shows.
        HydroservoError: a signal that the picture shows was not recorded.
    """
    from hydroservo.figures.batch import plot_batch
    from hydroservo.figures.bode import plot_bode
    from hydroservo.figures.run import plot_comparison, plot_run

    if runs := runs_by_name(results):
        return plot_comparison([*runs.values()], [*runs])
    if not is_result(results):
        if pictures := record_with_finding(results).finding().pictures:
            return pictures[0].draw()
        raise ParameterError("results", type(results).__name__, "has nothing that a picture shows")
    if "frequency" in results.dims:
        return plot_bode(results)
    if "run" not in results.dims:
        return plot_run(results)
    known = metric_fields(results)
    metric = default_metric(known, "rms_error") if metric is None else metric
    if not isinstance(metric, str) or metric not in known:
        raise ParameterError("metric", metric, one_of(str(metric), known))
    numbers = [str(name) for name in results.data_vars if "." in str(name)]
    return plot_batch(results, [name for name in numbers if name != "simulation.seed"], metric)


def run_names(runs: "Sequence[xr.Dataset]") -> list[str]:
    """What each run's controller is called, numbered where it comes again."""
    from hydroservo.runs.run_finding import controller_title

    types = [controller_title(run) for run in runs]
    again, met = Counter(types), Counter[str]()
    names = []
    for name in types:
        met[name] += 1
        names.append(f"{name} {met[name]}" if again[name] > 1 else name)
    return names
