"""How far two laws are apart: against Student's and Welch's tests where one of the draws has no spread."""

import math

import numpy as np
import pytest
from scipy import stats

from hydroservo.studies.paired import UNKNOWN, difference, spread

RNG = np.random.default_rng(3)
COMMON, A, B = RNG.standard_normal((3, 40))
ROWS_A, ROWS_B = RNG.standard_normal((5, 1)), RNG.standard_normal((9, 1))


def test_equal_searches_leave_students_paired_test():
    a, b = np.tile(COMMON + A, (4, 1)), np.tile(COMMON + B, (7, 1))
    found = difference(a, b)
    expected = stats.ttest_rel(COMMON + A, COMMON + B)
    interval = expected.confidence_interval(0.95)
    assert found == pytest.approx((np.mean(A - B), interval.low, interval.high, expected.pvalue), rel=1e-9)


def test_equal_conditions_leave_welchs_test():
    found = difference(COMMON + ROWS_A, COMMON + ROWS_B, confidence=0.9)
    expected = stats.ttest_ind(ROWS_A[:, 0], ROWS_B[:, 0], equal_var=False)
    interval = expected.confidence_interval(0.9)
    mean = ROWS_A.mean() - ROWS_B.mean()
    assert found == pytest.approx((mean, interval.low, interval.high, expected.pvalue), rel=1e-9)


@pytest.mark.slow
def test_the_variance_is_that_of_many_studies():
    def one():
        return (
            0.3 * RNG.standard_normal((6, 1)) + RNG.standard_normal(15) + 2.0 * RNG.standard_normal((6, 15))
        )

    studies = [one() for _ in range(4000)]
    means = np.var([study.mean() for study in studies])
    # 4000 draws leave a variance uncertain by 2.2 %; one that is held at its parts is too large
    assert np.mean([spread(study) for study in studies]) == pytest.approx(means, rel=0.15)
    assert np.mean([spread(study) for study in studies]) > 0.95 * means


def test_swapped_laws_swap_signs():
    a, b = COMMON + A + ROWS_A, COMMON + B + ROWS_B
    there, back = difference(a, b), difference(b, a)
    assert there == pytest.approx((-back.value, -back.high, -back.low, back.chance))


def test_lost_runs_count_nowhere():
    a, b = COMMON + A + ROWS_A, COMMON + B + ROWS_B
    a[2, 3] = np.nan
    a[:, 7] = np.nan
    without = np.delete(np.arange(COMMON.size), 7)
    assert difference(a, b) == difference(a[:, without], b[:, without])
    assert np.isfinite(difference(a, b)).all()


@pytest.mark.parametrize("shape", [(1, 40), (5, 1), (1, 1)])
def test_one_search_or_one_condition_says_nothing(shape):
    a, b = RNG.standard_normal((2, *shape))
    found = difference(a, b)
    assert found == (pytest.approx(a.mean() - b.mean()), -math.inf, math.inf, 1.0)


def test_all_lost_says_nothing():
    lost = np.full((3, 4), np.nan)
    assert difference(lost, np.zeros((3, 4))) is UNKNOWN


def test_the_same_law_is_no_different():
    a = np.tile(COMMON, (3, 1))
    assert difference(a, a) == (0.0, 0.0, 0.0, 1.0)
    assert 0.0 < difference(a + 1.0, a).chance < 1e-9
