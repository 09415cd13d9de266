"""What a result says, and its picture, whatever question returned it."""

from collections import Counter
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, TypeAlias

from hydroservo.block import is_block
from hydroservo.errors import ParameterError
from hydroservo.metrics import default_metric
from hydroservo.nearest import one_of
from hydroservo.runs.arguments import checked_runs, is_result
from hydroservo.runs.results import metric_fields

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.audits import Audit
    from hydroservo.figures.style import Plot
    from hydroservo.identification import Identified, LogFit
    from hydroservo.identification.maps import StaticMap
    from hydroservo.limits import Limits
    from hydroservo.linear import Linearization
    from hydroservo.runs.tuned import Tuned
    from hydroservo.show import Finding
    from hydroservo.studies.running import Studied

    Records: TypeAlias = Audit | Identified | LogFit | StaticMap | Limits | Linearization | Tuned | Studied
    Runs = xr.Dataset | Sequence[xr.Dataset] | Mapping[str, xr.Dataset]

RECORDS = {  # where the finding of a result is made, by the name of its class
    "Audit": "audits.finding.audit_finding",
    "Identified": "identification.finding.identified_finding",
    "Limits": "limits.finding.limits_finding",
    "Linearization": "linear.linearization_finding.linearization_finding",
    "LogFit": "identification.finding.log_fit_finding",
    "Margins": "linear.reading.margins_finding",
    "StaticMap": "identification.maps.finding.map_finding",
    "Studied": "studies.report.finding.study_finding",
    "Tuned": "runs.tuned_finding.tuned_finding",
}
WANTED = (
    "must be what simulate or simulate_batch returned, several of simulate in a list or by name, or what "
    "bode, linearize, tune, identify, map_logs, limit, audit or study returned"
)


def finding(results: "Runs | Records", metric: str | None = None) -> "Finding":
    """What results say, as their commands and notebooks show it.

    Args:
        results: as :func:`plot` takes them.
        metric: of a table, the one to picture.
    """
    if where := RECORDS.get(type(results).__name__):
        module, _, name = where.rpartition(".")
        made: Finding = getattr(import_module(f"hydroservo.{module}"), name)(results)
        return made
    if isinstance(results, Mapping) and not is_result(results):
        return compared(checked_runs([*results.values()], "results"), [*map(str, results)])
    if isinstance(results, list | tuple) and not is_block(results):
        runs = checked_runs(results, "results")
        return compared(runs, names_of(runs))
    if not is_result(results):
        raise ParameterError("results", results, WANTED)
    return finding_of_dataset(results, metric)


def finding_of_dataset(data: "xr.Dataset", metric: str | None = None) -> "Finding":
    """What a run, a table of many or frequency responses say."""
    if "frequency" in data.dims:
        from hydroservo.linear.bode_finding import bode_finding

        return bode_finding(data)
    if "run" not in data.dims:
        from hydroservo.runs.run_finding import run_finding

        return run_finding(data)
    from hydroservo.runs.batch_finding import batch_finding

    known = metric_fields(data)
    metric = default_metric(known, "rms_error") if metric is None else metric
    if not isinstance(metric, str) or metric not in known:
        raise ParameterError("metric", metric, one_of(str(metric), known))
    return batch_finding(data, metric=metric)


def compared(runs: "Sequence[xr.Dataset]", names: Sequence[str]) -> "Finding":
    from hydroservo.runs.comparison_finding import comparison_finding

    return comparison_finding(runs, names, names)


def plot(results: "Runs | Records", metric: str | None = None) -> "Plot":
    """The picture of a run, of several runs on common axes, or of whatever another question returned.

    A run shows what is controlled and its demand, error and command, and with an observer what it estimates;
    several show the first three, and say where they differ in more than their controllers. A table shows a
    metric against each number that varied; frequency responses are shown by
    :func:`~hydroservo.figures.bode.plot_bode`, a linear model by its poles, a search by the metric before and
    after, an identification by how its first log is met, a map by its curve and its scatter, limits by the
    best commands beside the law's, an audit by its margins, and a study by its fronts of error and
    command activity.
    Notebooks show the picture, and ``save`` writes it: ``hs.plot(run).save("run.pdf", width="one-column")``.

    Args:
        results: what ``simulate`` returned; a list of these, or several by the names that the legend is to
            have; what ``simulate_batch``, ``bode``, ``linearize``, ``tune``, ``identify``, ``map_logs``,
            ``limit``, ``audit`` or ``study`` returned; or one of the logs of an identification.
        metric: of a table, the one to show; the error, or what a table without one has.

    Raises:
        ParameterError: it is none of these, has no such metric, or nothing that a picture shows.
        HydroservoError: a signal that the picture shows was not recorded.
    """
    pictures = finding(results, metric).pictures
    if not pictures:
        raise ParameterError("results", type(results).__name__, "has nothing that a picture shows")
    return pictures[0].draw()


def names_of(runs: "Sequence[xr.Dataset]") -> list[str]:
    """What each run's controller is called, numbered where it comes again."""
    from hydroservo.runs.titles import controller_title

    types = [controller_title(run) for run in runs]
    again, met = Counter(types), Counter[str]()
    names = []
    for name in types:
        met[name] += 1
        names.append(f"{name} {met[name]}" if again[name] > 1 else name)
    return names
