"""The picture of whatever a question returned."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from hydroservo.block import is_block
from hydroservo.errors import ParameterError
from hydroservo.metrics import default_metric
from hydroservo.nearest import one_of
from hydroservo.runs.arguments import checked_runs, is_result
from hydroservo.runs.results import metric_fields

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from hydroservo.audits import Audit
    from hydroservo.identification import Identified, LogFit
    from hydroservo.identification.maps import StaticMap
    from hydroservo.limits import Limits
    from hydroservo.linear import Linearization
    from hydroservo.runs.tuned import Tuned
    from hydroservo.studies.running import Studied

    Records: TypeAlias = Audit | Identified | LogFit | StaticMap | Limits | Linearization | Tuned | Studied
    Runs = xr.Dataset | Sequence[xr.Dataset] | Mapping[str, xr.Dataset]


def plot(results: "Runs | Records", metric: str | None = None) -> "Figure":
    """The picture of a run, of several runs on common axes, or of whatever another question returned.

    A run shows what is controlled and its demand, error and command, and with an observer what it estimates;
    several show the first three, and say where they differ in more than their controllers. A table shows a
    metric against each number that varied; frequency responses are shown by
    :func:`~hydroservo.figures.bode.plot_bode`, a linear model by its poles, a search by the metric before and
    after, an identification by how its first log is met, a map by its curve and its scatter, limits by the
    best commands beside the law's, an audit by its margins, and a study by its fronts of error and
    command activity.
    Notebooks show the picture; ``savefig`` writes it.

    Args:
        results: what ``simulate`` returned; a list of these, or several by the names that the legend is to
            have; what ``simulate_batch``, ``bode``, ``linearize``, ``tune``, ``identify``, ``map_logs``,
            ``limit``, ``audit`` or ``study`` returned; or one of the logs of an identification.
        metric: of a table, the one to show; the error, or what a table without one has.

    Raises:
        ParameterError: it is none of these, or has no such metric.
        HydroservoError: a signal that the picture shows was not recorded.
    """
    from hydroservo.figures.batch import plot_batch
    from hydroservo.figures.bode import plot_bode
    from hydroservo.figures.comparison import plot_comparison
    from hydroservo.figures.run import plot_run

    if (drawn := picture_of_record(results)) is not None:
        return drawn
    if isinstance(results, Mapping) and not is_result(results):
        return plot_comparison(checked_runs([*results.values()], "results"), [*map(str, results)])
    if isinstance(results, list | tuple) and not is_block(results):
        runs = checked_runs(results, "results")
        return plot_comparison(runs, names_of(runs))
    if not is_result(results):
        wanted = (
            "must be what simulate or simulate_batch returned, several of simulate in a list or by name, or "
            "what bode, linearize, tune, identify, map_logs, limit, audit or study returned"
        )
        raise ParameterError("results", results, wanted)
    if "frequency" in results.dims:
        return plot_bode(results)
    if "run" not in results.dims:
        return plot_run(results)
    known = metric_fields(results)
    if metric is None:
        metric = default_metric(known, "rms_error")
    if not isinstance(metric, str) or metric not in known:
        raise ParameterError("metric", metric, one_of(str(metric), known))
    numbers = [str(name) for name in results.data_vars if "." in str(name)]
    return plot_batch(results, [name for name in numbers if name != "simulation.seed"], metric)


def picture_of_record(results: "Runs | Records") -> "Figure | None":
    """The picture of what is no Dataset but a record of its own; None of anything else."""
    from hydroservo.audits import Audit
    from hydroservo.figures.comparison import plot_comparison
    from hydroservo.figures.identified import plot_fit
    from hydroservo.figures.margins import plot_margins
    from hydroservo.figures.poles import plot_poles
    from hydroservo.figures.static_map import plot_static_map
    from hydroservo.figures.tuned import plot_tuned
    from hydroservo.identification import Identified, LogFit
    from hydroservo.identification.maps import StaticMap
    from hydroservo.limits import Limits
    from hydroservo.linear import Linearization
    from hydroservo.runs.tuned import Tuned
    from hydroservo.studies.report.findings import findings
    from hydroservo.studies.report.pictures import fronts
    from hydroservo.studies.running import Studied

    pictures: dict[type, Callable[[Any], Figure]] = {
        Audit: lambda found: plot_margins([one for one in found.assumptions() if one.holds is not None]),
        Identified: lambda found: plot_fit(found.logs[0]),
        Limits: lambda found: plot_comparison([*found], [*found._fields]),
        Linearization: plot_poles,
        LogFit: plot_fit,
        StaticMap: plot_static_map,
        Studied: lambda found: fronts(findings(found.manifest, found.verdicts)),
        Tuned: plot_tuned,
    }
    draw = pictures.get(type(results))
    return draw(results) if draw else None


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
