"""Pareto's front, how far it moves, and which of its points are judged."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.studies.fronts import MOST, evenly_spaced, front_shift, fronts_of, on_front
from hydroservo.studies.trials import Rules, judged_columns, trials_of
from tools.planted import rows, trials, with_lost


def test_a_known_front():
    points = [[1, 3], [2, 2], [3, 1], [2, 3], [3, 3], [2, 2]]
    assert on_front(points).tolist() == [True, True, True, False, False, True]
    assert on_front(np.empty((0, 3))).size == 0


@given(st.lists(st.tuples(*[st.integers(0, 3)] * 3), min_size=1, max_size=12))
def test_what_is_off_the_front_is_beaten_by_a_member(costs):
    members = [one for one, member in zip(costs, on_front(costs), strict=True) if member]
    assert members
    for one, member in zip(costs, on_front(costs), strict=True):
        beaten = [m for m in members if m != one and all(x <= y for x, y in zip(m, one, strict=True))]
        assert bool(beaten) is not member


def test_a_front_moves_by_what_its_points_gain_in_both():
    before = np.array([[2.0, 0.0], [1.0, 1.0], [0.0, 2.0]])
    assert front_shift(before, before) == 0.0
    assert front_shift(before, before - 0.1) == pytest.approx(0.1)
    steep = np.array([[9.0, 0.0], [1.0, 0.1]])  # another point between has an error of its own, and is near
    assert front_shift(steep, np.array([[5.0, 0.06]])) == pytest.approx(0.04)
    assert front_shift(before, np.array([[9.0, -9.0]])) == MOST
    assert front_shift(before, np.array([[3.0, 3.0]])) == 0.0


def test_points_are_spaced_over_activities_and_lie_on_the_front():
    random = np.random.default_rng(0)
    activity = random.uniform(0.0, 5.0, 400)
    points = np.stack([5.0 - activity + random.exponential(0.5, 400), activity], axis=1)
    found = evenly_spaced(points, 12)
    assert on_front(points)[found].all()
    assert found.size <= 12
    own = np.sort(points[found, 1])
    assert own[0] == points[on_front(points), 1].min()
    assert np.diff(own).max() < 1.0
    assert evenly_spaced(points[:1], 12).tolist() == [0]


def study(lost=None):
    """The reference with three points, of which the middle one is its own, and a law with two."""
    runs = trials(np.random.default_rng(0), {"pi": 1.0, "law": 1.0}, conditions=40)
    parts = []
    for law, points in {"pi": [(4.0, 0.1), (1.0, 1.0), (0.98, 2.0)], "law": [(0.8, 0.9), (0.9, 1.5)]}.items():
        for number, (error, activity) in enumerate(points):
            one = runs[law]._replace(error=error * runs[law].error, activity=np.full(40, activity))
            if lost is not None and (law, number) == lost:
                one = with_lost(one, np.arange(40) == 3)
            parts.append(rows(one, law, "c", point=number, moved=0.01 * number))
    import pandas as pd

    table = judged_columns(pd.concat(parts, ignore_index=True))
    choice = pd.DataFrame(
        [("pi", "c", 0, 1, 1.0), ("pi", "c", 0, 2, 2.0), ("law", "c", 0, 1, 2.0)],
        columns=["law", "cell", "search_seed", "point", "level"],
    )
    base = table[(table["law"] == "pi") & (table["point"] == 1)]
    return fronts_of(table, choice, {"c": trials_of(base)}, Rules())["c"]


def test_fronts_are_beside_the_reference_at_its_own_activity():
    found = study()
    pi, law = found["pi"].points, found["law"].points
    assert [one.activity for one in pi] == pytest.approx([0.1, 1.0, 2.0])
    assert [one.ratio.value for one in pi] == pytest.approx([4.0, 1.0, 0.98])
    assert [one.level for one in pi] == pytest.approx([math.nan, 1.0, 2.0], nan_ok=True)
    assert found["pi"].moved == 0.02
    assert [one.activity for one in law] == pytest.approx([0.9, 1.5])  # the second was chosen, and is beaten
    assert law[0].ratio.low < 0.8 < law[0].ratio.high
    assert law[0].error_low < law[0].error < law[0].error_high


def test_a_point_that_lost_a_run_is_on_no_front():
    assert [one.activity for one in study(lost=("law", 1))["law"].points] == pytest.approx([0.9])
