"""One law in one cell by itself."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from hydroservo.studies.cell_verdict import kind_ratios, survived_scale
from hydroservo.studies.law_standing import law_standing
from hydroservo.studies.trials import Rules, Trials
from tools.planted import with_lost


def known(errors, swing=0.0):
    error = np.array(errors, dtype=float)
    return Trials(np.arange(error.size), error, np.zeros(error.size, bool), 2.0 * error, swing + 0.0 * error)


def standing(trials, worst=0.1):
    return law_standing(trials, 1.5, Rules(worst=worst))


def test_the_error_is_the_geometric_mean_with_students_interval():
    found = standing(known([1.0, 4.0, 2.0]))
    logs = np.log([1.0, 4.0, 2.0])
    interval = stats.ttest_1samp(logs, 0.0).confidence_interval(0.95)
    assert found.error == pytest.approx(2.0)
    assert (found.error_low, found.error_high) == pytest.approx((np.exp(interval.low), np.exp(interval.high)))
    assert (found.activity, found.survived, found.conditions) == (pytest.approx(4.0), 1.5, 3)


def test_each_kind_has_its_own_ratio_on_the_same_conditions():
    base = known([1.0, 5.0, 1.0, 10.0])
    assert kind_ratios(known([1.0, 5.0, 4.0, 5.0]), base, 2) == pytest.approx([2.0, 0.5**0.5])
    lost = with_lost(known([1.0, 5.0, 4.0, 5.0]), np.array([False, False, True, False]))
    assert kind_ratios(lost, base, 2) == pytest.approx([1.0, 0.5**0.5])
    assert kind_ratios(known([2.0]), known([1.0]), 2) == pytest.approx([2.0, np.nan], nan_ok=True)


def test_tails_are_of_the_worst_conditions():
    hundred = known(np.arange(1.0, 101.0))
    assert (standing(hundred).tail, standing(hundred).worst) == (90.0, 95.5)
    assert standing(hundred, worst=0.05).worst == 98.0


def test_lost_runs_are_beyond_all():
    hundred = known(np.arange(1.0, 101.0))
    few = standing(with_lost(hundred, np.arange(100) < 5))
    assert (few.tail, few.worst) == (95.0, np.inf)
    assert standing(with_lost(hundred, np.arange(100) < 11)).tail == np.inf


def test_hunting_is_a_share_of_the_runs_that_can_tell():
    swings = np.array([0.0, 0.2, np.nan, 0.0])
    assert standing(known([1.0, 1.0, 1.0, 1.0], swings)).hunting == pytest.approx(1 / 3)
    assert np.isnan(standing(known([1.0, 1.0], np.nan)).hunting)


def test_all_lost():
    found = standing(with_lost(known([1.0, 2.0]), np.ones(2, dtype=bool)))
    assert found.lost.value == 1.0
    assert found.worst == np.inf
    assert np.isnan([found.error, found.activity]).all()


def strained(lost):
    """Runs that are lost at some scales."""
    rows = [(scale, i, (scale, i) in lost) for scale in (1.0, 2.0, 3.0) for i in (0, 1)]
    return pd.DataFrame(rows, columns=["scale", "condition", "lost"])


@pytest.mark.parametrize(
    ("lost", "expected"),
    [
        (set(), 3.0),
        ({(3.0, 0)}, 2.0),
        ({(2.0, 1)}, 1.0),  # that it survives 3 does not help
        ({(1.0, 1)}, 0.0),
    ],
)
def test_survived(lost, expected):
    assert survived_scale(strained(lost).sample(frac=1.0, random_state=1)) == expected


def test_nothing_is_known_without_stress_runs():
    assert np.isnan(survived_scale(strained(set())[:0]))
