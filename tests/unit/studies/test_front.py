"""Pareto's front, and curves of error against budget."""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.studies.curves import curve
from hydroservo.studies.front import Point, on_front, with_front
from tools.planted import rows, trials, with_lost


def test_a_known_front():
    assert on_front([[1, 3], [2, 2], [3, 1], [2, 3], [3, 3], [2, 2]]) == [
        True,
        True,
        True,
        False,
        False,
        True,
    ]
    assert on_front(np.empty((0, 3))) == []


@given(st.lists(st.tuples(*[st.integers(0, 3)] * 3), min_size=1, max_size=12))
def test_what_is_off_the_front_is_beaten_by_a_member(costs):
    members = [one for one, member in zip(costs, on_front(costs), strict=True) if member]
    assert members
    for one, member in zip(costs, on_front(costs), strict=True):
        beaten = [m for m in members if m != one and all(x <= y for x, y in zip(m, one, strict=True))]
        assert bool(beaten) is not member


def test_robustness_is_a_reason_to_stay_and_lost_runs_one_to_go():
    def point(law, error, survived, lost=0.0):
        return Point(law, 0.0, error, 1.0, survived, lost, front=False)

    points = [
        point("a", 1.0, 1.0),
        point("b", 2.0, 2.0),
        point("c", 3.0, 2.0),
        point("d", 0.1, 9.0, lost=0.5),
    ]
    assert [one.law for one in with_front(points, 0.1) if one.front] == ["a", "b"]
    unknown = [one._replace(survived=math.nan) for one in points]
    assert [one.law for one in with_front(unknown, 0.1) if one.front] == ["a"]


def test_curves():
    runs = [trials(np.random.default_rng(0), {"a": level}, searches=4)["a"] for level in (2.0, 1.0)]
    lost = np.zeros(runs[1].lost.shape, dtype=bool)
    lost[0, :100] = True
    runs[1] = with_lost(runs[1], lost)
    tables = [rows(one, "a", "c", budget=budget) for one, budget in zip(runs, (64, 128), strict=True)]
    early, late = curve(pd.concat(tables).sample(frac=1.0, random_state=0))
    assert (early.budget, early.searches, early.lost) == (64, 4, 0.0)
    assert (late.budget, late.lost) == (128, pytest.approx(1 / 8))
    means = np.exp(np.log(runs[0].error).mean(axis=1))
    assert (early.low, early.error, early.high) == pytest.approx(tuple(np.quantile(means, [0.25, 0.5, 0.75])))
    assert late.error < 0.6 * early.error
