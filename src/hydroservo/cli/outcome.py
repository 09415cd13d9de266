"""What a run came to, as a JSON object, as tables in files and as tables on a terminal."""

import csv
import io
import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.metrics import METRIC_FIELDS
from hydroservo.results import metrics_of, plain

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Outcome", "as_json", "as_object", "metrics_csv", "outcome_of"]


class Outcome(NamedTuple):
    """The part of a run's result that fits on a screen."""

    scenario: str  # as the user named it
    hash: str
    version: str
    seed: int
    metrics: Mapping[str, float | bool]


def outcome_of(scenario: str, dataset: "xr.Dataset") -> Outcome:
    """The outcome of a run, from what ``simulate`` returned."""
    about = dataset.attrs
    return Outcome(scenario, about["hash"], about["version"], int(about["seed"]), metrics_of(dataset))


def as_object(outcome: Outcome) -> dict[str, Any]:
    """What ``--json`` prints: SI units, null for what is not finite."""
    return {**outcome._asdict(), "metrics": plain(outcome.metrics)}


def as_json(thing: object) -> str:
    """Text of a JSON object."""
    return json.dumps(thing, indent=2, allow_nan=False)


def metrics_csv(outcomes: Sequence[Outcome]) -> str:
    """One row for each metric, one column for each run, in SI units."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["metric", "unit", "meaning", *(outcome.scenario for outcome in outcomes)])
    for name, field in METRIC_FIELDS.items():
        table.writerow(
            [name, field.unit, field.meaning, *(cell(outcome.metrics[name]) for outcome in outcomes)]
        )
    return text.getvalue()


def cell(value: float | bool) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value)
