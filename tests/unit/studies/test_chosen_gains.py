"""Gains are chosen on validation, at each level of activity, and on nothing else."""

import numpy as np
import pandas as pd
import pytest

from hydroservo.core.errors import HydroservoError
from hydroservo.studies.fronts import activities_of, choose_gains, front_points
from hydroservo.studies.trials import Rules, judged_columns

RULES = Rules()
PI = {0: ([2.0], 1.0), 1: ([1.04], 3.0), 2: ([1.0], 4.0)}  # error and activity of each point


def table(points, law="pi", lost=(), split="validation", cell="c", seed=0):
    """The points of a front; the errors of each on its conditions, and its activity."""
    rows = [
        {"point": point, "condition": i, "error": error, "activity": activity, "lost": (point, i) in lost}
        for point, (errors, activity) in points.items()
        for i, error in enumerate(errors)
    ]
    search = {"law": law, "cell": cell, "search_seed": seed, "split": split, "moved": 0.0}
    return pd.DataFrame(rows).assign(**search, scale=np.nan, swing=np.nan)


def choice(*tables, levels=(0.5, 1.0, 2.0)):
    found = choose_gains(judged_columns(pd.concat(tables)), "pi", levels, RULES)
    return {
        (law, level): point for law, level, point in zip(found.law, found.level, found.point, strict=True)
    }


def test_the_references_activity_is_that_of_its_calmest_point_that_ties_with_its_best():
    points = front_points(judged_columns(table(PI)), "validation")
    assert activities_of(points, "pi", RULES) == {"c": pytest.approx(3.0)}
    assert choice(table(PI)) == {("pi", 0.5): 0, ("pi", 1.0): 1, ("pi", 2.0): 2}


def test_a_law_takes_the_least_error_that_is_calm_enough_and_may_be_calmer():
    law = {0: ([9.0], 1.6), 1: ([0.5], 2.9), 2: ([0.4], 5.0), 3: ([0.6], 5.9)}
    found = choice(table(PI), table(law, "law"))
    assert ("law", 0.5) not in found  # it cannot be so calm
    assert (found["law", 1.0], found["law", 2.0]) == (1, 2)


def test_the_mean_is_geometric_and_fewest_lost_come_first():
    law = {0: ([0.1, 100.0], 1.0), 1: ([9.0, 9.0], 1.0), 2: ([0.1, 0.1], 1.0)}
    assert choice(table(PI), table(law, "law", lost={(2, 0)}), levels=(1.0,))["law", 1.0] == 0
    everything = {(point, i) for point in law for i in (0, 1)}
    assert choice(table(PI), table(law, "law", lost=everything), levels=(1.0,)).keys() == {("pi", 1.0)}


def test_test_runs_have_no_say():
    unseen = table({0: ([0.1], 0.1), 1: ([9.0], 9.0), 2: ([9.0], 9.0)}, split="test")
    assert choice(table(PI), unseen) == choice(table(PI))


def test_the_searches_of_a_law_are_one_front():
    law = {0: ([0.7], 2.0)}
    found = choose_gains(
        judged_columns(pd.concat([table(PI), table(law, "law"), table({0: ([0.5], 2.0)}, "law", seed=1)])),
        "pi",
        [1.0],
        RULES,
    )
    assert found[found["law"] == "law"]["search_seed"].tolist() == [1]


def test_each_cell_has_its_own_activity():
    other = {point: (errors, 10.0 * activity) for point, (errors, activity) in PI.items()}
    points = front_points(judged_columns(pd.concat([table(PI), table(other, cell="d")])), "validation")
    assert activities_of(points, "pi", RULES) == {"c": pytest.approx(3.0), "d": pytest.approx(30.0)}
    with pytest.raises(HydroservoError, match="cell d: the reference, pi, loses all its runs"):
        choice(table(PI), table(other, "law", cell="d"))


def test_without_validation_nothing_is_chosen():
    with pytest.raises(HydroservoError, match="no validation runs"):
        choice(table(PI, split="test"))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (table(PI).drop(columns="lost"), "no column lost"),
        (table(PI)[:0], "no rows"),
        (table({0: ([-1.0], 1.0)}), r"law pi, cell c, validation condition 0: error = -1: must be positive"),
        (table({0: ([np.nan], 1.0)}), "error = nan: must be positive"),
    ],
)
def test_what_is_refused(wrong, message):
    with pytest.raises(HydroservoError, match=message):
        judged_columns(wrong)


def test_an_infinite_error_is_a_lost_run():
    assert judged_columns(table({0: ([np.inf], 1.0)}))["lost"].all()
