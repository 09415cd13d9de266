"""How far two laws are apart: against Student's paired test."""

import math

import numpy as np
import pytest
from scipy import stats

from hydroservo.studies.trials import UNKNOWN, exponentials, mean_estimate, paired_difference

RNG = np.random.default_rng(3)
COMMON, A, B = RNG.standard_normal((3, 40))


@pytest.mark.parametrize("confidence", [0.9, 0.95])
def test_it_is_students_paired_test(confidence):
    found = paired_difference(COMMON + A, COMMON + B, confidence)
    expected = stats.ttest_rel(COMMON + A, COMMON + B)
    interval = expected.confidence_interval(confidence)
    assert found == pytest.approx((np.mean(A - B), interval.low, interval.high, expected.pvalue), rel=1e-9)


def test_swapped_laws_swap_signs():
    there, back = paired_difference(COMMON + A, COMMON + B), paired_difference(COMMON + B, COMMON + A)
    assert there == pytest.approx((-back.value, -back.high, -back.low, back.chance))


def test_lost_runs_count_nowhere():
    a, b = COMMON + A, COMMON + B
    lost = a.copy()
    lost[7] = np.nan
    without = np.delete(np.arange(COMMON.size), 7)
    assert paired_difference(lost, b) == paired_difference(a[without], b[without])


def test_one_condition_says_nothing():
    assert mean_estimate(np.array([2.0])) == (2.0, -math.inf, math.inf, 1.0)
    assert exponentials(mean_estimate(np.array([0.0]))) == (1.0, 0.0, math.inf)
    assert mean_estimate(np.full(4, np.nan)) is UNKNOWN


def test_the_same_law_is_no_different():
    assert paired_difference(COMMON, COMMON) == (0.0, 0.0, 0.0, 1.0)
    assert 0.0 < paired_difference(COMMON + 1.0, COMMON).chance < 1e-9
