"""The part of a run's result that fits on a screen."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.results import metrics_of

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["RunSummary", "run_summary"]


class RunSummary(NamedTuple):
    """A run's name, what identifies it, and its metrics in SI units; the fields of ``--json``."""

    scenario: str  # as the user named it
    hash: str
    version: str
    seed: int
    diverged_by: str  # the path of the number that was lost, the error, or nothing
    warnings: Sequence[str]
    metrics: Mapping[str, float | bool]


def run_summary(scenario: str, dataset: "xr.Dataset") -> RunSummary:
    """The summary of a run, from what ``simulate`` returned."""
    about = dataset.attrs
    name = (scenario, about["hash"], about["version"], int(about["seed"]))
    return RunSummary(*name, about["diverged_by"], warnings_of(dataset), metrics_of(dataset))
