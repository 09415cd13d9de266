"""Studies whose truth is known: errors that are drawn, of laws that are as good as they are said to be."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from hydroservo.studies.trials import Trials, paired_difference

Draw = Callable[[np.random.Generator, Any], NDArray[np.float64]]


def normal(rng: np.random.Generator, shape: Any) -> NDArray[np.float64]:
    """So that errors are lognormal; of variance 1."""
    return rng.standard_normal(shape)


def student(rng: np.random.Generator, shape: Any) -> NDArray[np.float64]:
    """Of long tails: three degrees of freedom, variance 1."""
    return rng.standard_t(3, shape) / np.sqrt(3.0)


class Spreads(NamedTuple):
    """Standard deviations of the logarithm of the error."""

    conditions: float = 0.5  # that all laws meet alike
    own: float = 0.15  # of how one law does on a condition


USUAL = Spreads()


def trials(
    rng: np.random.Generator,
    levels: Mapping[str, float],
    conditions: int = 200,
    spreads: Spreads = USUAL,
    draw: Draw = normal,
) -> dict[str, Trials]:
    """The runs of laws whose errors are, in the geometric mean, of the levels."""
    common = spreads.conditions * draw(rng, conditions)
    found = {}
    for law, level in levels.items():
        log = np.log(level) + common + spreads.own * draw(rng, conditions)
        none, calm = np.zeros(conditions, dtype=np.bool_), np.ones(conditions)
        found[law] = Trials(np.arange(conditions), np.exp(log), none, calm, np.zeros(conditions))
    return found


def with_lost(one: Trials, lost: NDArray[np.bool_]) -> Trials:
    """The same, but for some runs that are lost."""
    return one._replace(lost=lost, error=np.where(lost, np.nan, one.error))


def rows(one: Trials, law: str, cell: str, **columns: Any) -> pd.DataFrame:
    """The table of a law's runs with the gains of one point of its front."""
    plain = {
        "law": law,
        "cell": cell,
        "search_seed": 0,
        "point": 0,
        "candidates": 64,
        "moved": 0.0,
        "split": "test",
        "condition": one.conditions,
        "scale": np.nan,
        "error": np.where(one.lost, np.inf, one.error),
        "activity": one.activity,
        "swing": one.swing,
        "lost": one.lost,
        "parameters": "{}",
    }
    return pd.DataFrame(plain | columns)


def manifest(laws: Mapping[str, Mapping[str, str]], reference: str = "pi") -> dict[str, Any]:
    """What study.json says of laws: if nothing else, a family of its own, and sensors VP."""
    usual = {"observer": "", "wrapper": "", "class": "VP", "without": ""}
    return {
        "laws": {name: {"family": name} | usual | dict(own) for name, own in laws.items()},
        "reference": reference,
        "kinds": ["sine", "square"],
        "search": {"levels": [0.5, 1.0, 2.0]},
    }


def coverage(studies: int, conditions: int, spreads: Spreads, draw: Draw) -> float:
    """The share of studies in which the interval of two laws' ratio of errors, 95 %, holds the true one."""
    rng = np.random.default_rng(11)
    held = 0
    for _ in range(studies):
        runs = trials(rng, {"a": 0.9, "b": 1.0}, conditions, spreads, draw)
        found = paired_difference(runs["a"].logs(), runs["b"].logs())
        held += bool(found.low <= np.log(0.9) <= found.high)
    return held / studies
