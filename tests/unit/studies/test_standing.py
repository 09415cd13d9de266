"""One law in one cell by itself."""

import numpy as np
import pandas as pd
import pytest

from hydroservo.studies.rules import Rules
from hydroservo.studies.standing import standing_of, tails
from hydroservo.studies.stress import survived
from hydroservo.studies.trials import Trials
from tools.planted import with_lost


def known(errors):
    error = np.array(errors, dtype=float)
    return Trials(np.arange(error.shape[1]), error, np.zeros(error.shape, dtype=bool), 2.0 * error)


def test_the_error_is_the_median_search():
    found = standing_of(known([[1.0, 4.0], [1.0, 9.0], [4.0, 4.0]]), 1.5, Rules())
    assert (found.error_low, found.error, found.error_high) == pytest.approx((2.5, 3.0, 3.5))
    assert (found.activity, found.survived, found.searches, found.conditions) == (8.0, 1.5, 3, 2)


def test_tails_are_of_the_worst_conditions():
    hundred = known([np.arange(1.0, 101.0)])
    assert tails(hundred, 0.1) == (90.0, 95.5)
    assert tails(hundred, 0.05) == (90.0, 98.0)


def test_lost_runs_are_beyond_all():
    lost = np.zeros((1, 100), dtype=bool)
    lost[0, :5] = True
    few = with_lost(known([np.arange(1.0, 101.0)]), lost)
    assert tails(few, 0.1) == (95.0, np.inf)
    lost[0, :11] = True
    assert tails(with_lost(few, lost), 0.1) == (np.inf, np.inf)


def test_all_lost():
    one = with_lost(known([[1.0, 2.0], [3.0, 4.0]]), np.ones((2, 2), dtype=bool))
    found = standing_of(one, 0.0, Rules())
    assert found.lost.value == 1.0
    assert found.worst == np.inf
    assert np.isnan([found.error, found.error_low, found.activity]).all()


def strained(lost):
    """Runs that are lost of some seeds at some scales."""
    places = [(seed, scale, i) for seed in (0, 1, 2) for scale in (1.0, 2.0, 3.0) for i in (0, 1)]
    rows = [(seed, scale, i, (seed, scale, i) in lost) for seed, scale, i in places]
    return pd.DataFrame(rows, columns=["search_seed", "scale", "condition", "lost"]).assign(optimiser="de")


@pytest.mark.parametrize(
    ("lost", "expected"),
    [
        (set(), 3.0),
        ({(0, 2.0, 1), (1, 3.0, 0)}, 2.0),
        ({(0, 2.0, 1), (1, 2.0, 0)}, 1.0),  # that they survive 3 does not help
        ({(0, 1.0, 1), (1, 1.0, 0)}, 0.0),
        ({(0, 1.0, 1)}, 3.0),
    ],
)
def test_survived(lost, expected):
    assert survived(strained(lost).sample(frac=1.0, random_state=1)) == expected


def test_nothing_is_known_without_stress_runs():
    assert np.isnan(survived(strained(set())[:0]))
