"""Lost runs: their share, its interval, and who loses fewer."""

import numpy as np
import pytest
from scipy.stats import binomtest

from hydroservo.studies.law_standing import fewer_lost, lost_share
from hydroservo.studies.trials import MeanEstimate


def on(conditions, count=200):
    return np.arange(count) < conditions


NONE, ALL = on(0), on(200)


@pytest.mark.parametrize(("lost", "runs"), [(0, 20), (3, 20), (20, 20), (1, 1000)])
def test_the_interval_is_wilsons(lost, runs):
    expected = binomtest(lost, runs).proportion_ci(0.95, method="wilson")
    found = lost_share(on(lost, runs))
    assert (found.lost, found.value) == (lost, lost / runs)
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high))


def test_none_and_all_are_not_certain():
    assert 0.01 < lost_share(NONE).high < 0.03  # 200 conditions that went well say below 2 %
    assert lost_share(ALL).low < 1.0


@pytest.mark.parametrize(("lost", "sure"), [(1, False), (4, False), (12, True), (200, True)])
def test_a_handful_convinces_nobody(lost, sure):
    found = fewer_lost(on(lost), NONE)
    assert found.value == pytest.approx(lost / 200)
    assert (found.chance < 0.05) is sure
    assert fewer_lost(NONE, on(lost)).chance == pytest.approx(found.chance)


@pytest.mark.parametrize(("more", "fewer"), [(1, 0), (7, 2), (60, 41), (100, 90)])
def test_the_signs_are_tested_exactly(more, fewer, monkeypatch):
    """With Student's t sure of it, the sign test of the conditions in which one law alone is lost is left."""
    sure = MeanEstimate(0.1, 0.05, 0.15, 0.0)
    monkeypatch.setattr("hydroservo.studies.law_standing.paired_difference", lambda *_: sure)
    found = fewer_lost(on(more), np.roll(on(fewer), -fewer))
    assert found.chance == pytest.approx(binomtest(fewer, more + fewer).pvalue, rel=1e-12)


def test_equal_losses_are_no_difference():
    assert fewer_lost(on(12), on(12)).chance == 1.0
    assert fewer_lost(ALL, ALL).chance == 1.0
