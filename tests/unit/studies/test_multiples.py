"""The laws of a cell beside the limits of its conditions."""

import numpy as np
import pandas as pd
import pytest

from hydroservo.studies.multiples import BELOW, limit_of
from hydroservo.studies.trials import Trials

LIMITS = pd.DataFrame(
    {
        "cell": "all",
        "condition": [4, 0, 2, 3],
        "clairvoyant": [2.0, 1.0, 0.0, 5.0],
        "causal": [4.0, 2.0, 1.0, 5.0],
        "converged": [True, True, True, False],
    }
)


def trials(errors, lost=()):
    """Runs under the conditions 0 to 4, a row a search; those that are lost by row and column."""
    error = np.array(errors, dtype=float)
    gone = np.zeros(error.shape, dtype=bool)
    for place in lost:
        gone[place] = True
    return Trials(np.arange(5), np.where(gone, np.nan, error), gone, np.ones_like(error))


def test_a_multiple_is_of_the_conditions_that_have_a_limit():
    law = trials([[2, 9, 9, 9, 16], [1, 9, 9, 9, 2], [9, 1, 1, 1, 18]])
    found = limit_of({"law": law}, LIMITS)
    assert (found.conditions, found.open, found.below) == ([0, 4], 2, 0)
    assert (found.clairvoyant, found.causal) == pytest.approx((np.sqrt(2.0), np.sqrt(8.0)))
    one = found.laws["law"]  # searches leave sqrt(2 8) = 4, sqrt(1 1) = 1 and sqrt(9 9) = 9 times the limit
    assert one.clairvoyant == pytest.approx(4.0)
    assert (one.low, one.high) == pytest.approx((2.5, 6.5))
    assert one.causal == pytest.approx(2.0)
    assert (one.lost, one.runs) == (0, 6)


def test_lost_runs_are_counted_and_in_no_mean():
    law = trials([[2, 9, 9, 9, 16], [2, 9, 9, 9, 1]], lost=[(0, 4), (1, 0), (1, 4), (0, 1)])
    one = limit_of({"law": law}, LIMITS).laws["law"]
    assert (one.clairvoyant, one.low, one.high) == pytest.approx((2.0, 2.0, 2.0))
    assert (one.lost, one.runs) == (3, 4)


def test_a_law_that_lost_all_has_no_multiple():
    law = trials([[2, 9, 9, 9, 16]], lost=[(0, 0), (0, 4)])
    one = limit_of({"law": law}, LIMITS).laws["law"]
    assert np.isnan([one.clairvoyant, one.low, one.high, one.causal]).all()
    assert (one.lost, one.runs) == (2, 2)


def test_runs_below_the_limit_are_counted():
    law = trials([[1.0 - 2.0 * BELOW, 9, 9, 9, 2.0 - BELOW], [0.5, 9, 9, 9, 9]])
    assert limit_of({"law": law, "other": law}, LIMITS).below == 4


def test_where_no_search_ended_there_is_no_limit():
    found = limit_of({"law": trials([[1, 1, 1, 1, 1]])}, LIMITS.assign(converged=False))
    assert (found.conditions, found.open, found.laws) == ([], 4, {})
    none = limit_of({"law": trials([[1, 1, 1, 1, 1]])}, LIMITS[:0])
    assert (none.conditions, none.open, none.laws) == ([], 0, {})
