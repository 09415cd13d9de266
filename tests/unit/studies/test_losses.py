"""Lost runs: their share, its interval, and who loses fewer."""

import numpy as np
import pytest
from scipy.stats import binomtest

from hydroservo.studies.losses import fewer_lost, lost_share, wilson

NONE, ALL = np.zeros((5, 200), dtype=bool), np.ones((5, 200), dtype=bool)


def on(conditions, searches=slice(None)):
    lost = NONE.copy()
    lost[searches, :conditions] = True
    return lost


@pytest.mark.parametrize(("lost", "runs"), [(0, 20), (3, 20), (20, 20), (1, 1000)])
def test_wilsons_interval_is_scipys(lost, runs):
    expected = binomtest(lost, runs).proportion_ci(0.95, method="wilson")
    assert wilson(lost / runs, runs, 0.95) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_none_and_all_are_not_certain():
    none, all_of_them = lost_share(NONE), lost_share(ALL)
    assert (none.lost, none.value, none.low) == (0, 0.0, 0.0)
    assert 0.01 < none.high < 0.03  # 200 conditions that went well say below 2 %
    assert (all_of_them.lost, all_of_them.value, all_of_them.high) == (1000, 1.0, 1.0)


def test_runs_that_are_lost_together_count_as_fewer():
    apart = np.random.default_rng(0).random(NONE.shape) < 0.2
    together, by_search = on(40), on(200, searches=0)
    widths = [one.high - one.low for one in map(lost_share, (apart, together, by_search))]
    assert widths[0] < 0.06 < widths[1] < 0.15 < widths[2]


@pytest.mark.parametrize(
    ("lost", "sure"),
    [(on(1), False), (on(4), False), (on(12), True), (on(200, searches=0), False), (ALL, True)],
)
def test_a_handful_or_one_bad_search_convinces_nobody(lost, sure):
    found = fewer_lost(lost, NONE)
    assert found.value == pytest.approx(lost.mean())
    assert (found.chance < 0.05) is sure
    assert fewer_lost(NONE, lost).chance == pytest.approx(found.chance)


def test_equal_losses_are_no_difference():
    assert fewer_lost(on(12), on(12)).chance == 1.0
    assert fewer_lost(ALL, ALL).chance == 1.0
