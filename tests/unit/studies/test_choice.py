"""The effort is chosen on validation, and on nothing else."""

import numpy as np
import pandas as pd
import pytest

from hydroservo.errors import HydroservoError
from hydroservo.studies.choice import chosen, of_choice
from hydroservo.studies.columns import judged_columns


def table(errors, lost=(), split="validation"):
    """One search; the errors of each effort on its conditions."""
    rows = [
        {"effort": effort, "condition": i, "error": error, "lost": (effort, i) in lost, "split": split}
        for effort, own in errors.items()
        for i, error in enumerate(own)
    ]
    search = {"law": "a", "cell": "c", "optimiser": "de", "search_seed": 0, "budget": 64}
    return pd.DataFrame(rows).assign(**search, scale=np.nan, activity=1.0)


def effort_of(*tables):
    (effort,) = chosen(judged_columns(pd.concat(tables)))["effort"]
    return effort


def test_least_geometric_mean():
    assert effort_of(table({0.0: [1.0, 100.0], 0.1: [9.0, 9.0]})) == 0.1  # the arithmetic mean says so too
    assert effort_of(table({0.0: [0.1, 100.0], 0.1: [9.0, 9.0]})) == 0.0  # and here it does not


def test_test_runs_have_no_say():
    seen = table({0.0: [1.0], 0.1: [2.0]})
    unseen = table({0.0: [9.0], 0.1: [0.1]}, split="test")
    assert effort_of(seen, unseen) == 0.0


def test_fewest_lost_first():
    errors = {0.0: [1.0, 1.0], 0.1: [5.0, 5.0], 0.2: [4.0, 4.0]}
    assert effort_of(table(errors, lost={(0.0, 1)})) == 0.2
    assert effort_of(table(errors, lost={(0.0, 0), (0.0, 1), (0.1, 1), (0.2, 0)})) == 0.2
    everything = {(effort, i) for effort in errors for i in (0, 1)}
    assert effort_of(table(errors, lost=everything)) == 0.0


def test_each_budget_has_its_own_choice():
    early, late = table({0.0: [1.0], 0.1: [2.0]}), table({0.0: [1.0], 0.1: [0.5]}).assign(budget=128)
    unseen = [one.assign(split="test") for one in (early, late)]
    runs = judged_columns(pd.concat([early, late, *unseen]))
    found = chosen(runs)
    assert found.set_index("budget")["effort"].to_dict() == {64: 0.0, 128: 0.1}
    assert of_choice(runs, found, "test").set_index("budget")["error"].to_dict() == {64: 1.0, 128: 0.5}


def test_one_effort_needs_no_validation():
    assert effort_of(table({0.1: [1.0]}, split="test")) == 0.1


def test_several_efforts_need_it():
    with pytest.raises(HydroservoError, match=r"law a, cell c, effort 0.1: no validation runs"):
        effort_of(table({0.0: [1.0]}), table({0.0: [1.0], 0.1: [1.0]}, split="test"))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (table({0.0: [1.0]}).drop(columns="lost"), "no column lost"),
        (table({0.0: [1.0]})[:0], "no rows"),
        (table({0.0: [-1.0]}), r"law a, cell c, validation condition 0: error = -1: must be positive"),
        (table({0.0: [np.nan]}), "error = nan: must be positive"),
    ],
)
def test_what_is_refused(wrong, message):
    with pytest.raises(HydroservoError, match=message):
        judged_columns(wrong)


def test_an_infinite_error_is_a_lost_run():
    assert judged_columns(table({0.0: [np.inf]}))["lost"].all()
