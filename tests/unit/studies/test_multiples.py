"""The laws of a cell beside the limits of its conditions."""

import numpy as np
import pandas as pd
import pytest

from hydroservo.studies.law_standing import BELOW, cell_limit
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
    """Runs under the conditions 0 to 4, and which of them are lost."""
    error = np.array(errors, dtype=float)
    gone = np.isin(np.arange(5), lost)
    return Trials(np.arange(5), np.where(gone, np.nan, error), gone, np.ones(5), np.zeros(5))


def test_a_multiple_is_of_the_conditions_that_have_a_limit():
    found = cell_limit({"law": trials([2, 9, 9, 9, 16])}, LIMITS)
    assert (found.conditions, found.open, found.below) == ([0, 4], 2, 0)
    assert (found.clairvoyant, found.causal) == pytest.approx((np.sqrt(2.0), np.sqrt(8.0)))
    one = found.laws["law"]  # sqrt(2 8) = 4 and sqrt(1 4) = 2 times the limits
    assert (one.clairvoyant, one.causal) == pytest.approx((4.0, 2.0))
    assert one.low < 4.0 < one.high
    assert (one.lost, one.runs) == (0, 2)


def test_lost_runs_are_counted_and_in_no_mean():
    one = cell_limit({"law": trials([2, 9, 9, 9, 16], lost=[1, 4])}, LIMITS).laws["law"]
    assert (one.clairvoyant, one.low, one.high) == pytest.approx((2.0, 0.0, np.inf))
    assert (one.lost, one.runs) == (1, 2)


def test_a_law_that_lost_all_has_no_multiple():
    one = cell_limit({"law": trials([2, 9, 9, 9, 16], lost=[0, 4])}, LIMITS).laws["law"]
    assert np.isnan([one.clairvoyant, one.causal]).all()
    assert (one.lost, one.runs) == (2, 2)


def test_runs_below_the_limit_are_counted():
    law = trials([1.0 - 2.0 * BELOW, 9, 9, 9, 2.0 - BELOW])
    assert cell_limit({"law": law, "other": law}, LIMITS).below == 2


def test_where_no_search_ended_there_is_no_limit():
    found = cell_limit({"law": trials([1, 1, 1, 1, 1])}, LIMITS.assign(converged=False))
    assert (found.conditions, found.open, found.laws) == ([], 4, {})
    none = cell_limit({"law": trials([1, 1, 1, 1, 1])}, LIMITS[:0])
    assert (none.conditions, none.open, none.laws) == ([], 0, {})
