"""Who wins a cell; regret; what sensors are worth."""

import math

import numpy as np
import pytest

from hydroservo.studies.cell_verdict import (
    NONE,
    Area,
    best_law,
    law_areas,
    regrets,
    sensor_prices,
    sensor_ranks,
)
from hydroservo.studies.law_pairs import pairs_of
from hydroservo.studies.law_standing import law_standing
from hydroservo.studies.trials import Rules
from tools.planted import trials, with_lost

RULES = Rules()


def cell(lost=(), seed=0, of_200=30, **levels):
    runs = trials(np.random.default_rng(seed), levels)
    some = np.arange(200) < of_200
    runs |= {law: with_lost(runs[law], some) for law in lost}
    return {law: law_standing(one, math.nan, RULES) for law, one in runs.items()}, pairs_of(runs, RULES)


def test_one_law_wins():
    found = best_law(*cell(a=0.8, b=1.0, c=1.2), {"a": "A", "b": "B", "c": "B"}, RULES)
    assert (found.law, found.ties, found.families, found.state) == ("a", ["a"], ["A"], "won")
    assert found.next_family == "b"
    assert found.margin == pytest.approx(1.25, rel=0.05)
    assert found.margin_low < 1.25 < found.margin_high


def test_a_tie_within_a_family_is_won_by_it():
    found = best_law(*cell(a=1.0, b=1.0, c=1.2), {"a": "A", "b": "A", "c": "B"}, RULES)
    assert (found.ties, found.state, found.next_family) == (["a", "b"], "won", "c")


def test_a_tie_of_families():
    found = best_law(*cell(a=1.0, b=1.0, c=1.2), {"a": "A", "b": "B", "c": "B"}, RULES)
    assert (found.ties, found.families, found.state) == (["a", "b"], ["A", "B"], "tie")


def test_who_loses_too_many_is_out_of_the_running():
    families = {"a": "A", "b": "B"}
    assert best_law(*cell(a=0.5, b=1.0, lost="a"), families, RULES)[:4] == ("b", ["b"], ["B"], "won")
    assert best_law(*cell(a=0.5, b=1.0, lost="ab"), families, RULES) == NONE


def test_less_error_is_not_best_where_runs_are_lost():
    found = best_law(*cell(a=0.5, b=1.0, c=1.2, lost="a", of_200=14), {"a": "A", "b": "B", "c": "C"}, RULES)
    assert (found.law, found.next_family) == ("b", "a")
    assert found.margin == pytest.approx(0.5, rel=0.05)


def test_a_single_law():
    found = best_law(*cell(a=1.0), {"a": "A"}, RULES)
    assert found[:5] == ("a", ["a"], ["A"], "won", "")
    assert math.isnan(found.margin)


def test_regret():
    found = regrets(*cell(a=0.5, b=1.0, c=1.2, lost="a"), RULES)
    assert found == {"a": math.inf, "b": 1.0, "c": pytest.approx(1.2, rel=0.05)}
    nothing = regrets(*cell(a=0.5, b=1.0, lost="ab"), RULES)
    assert all(math.isnan(one) for one in nothing.values())


def test_areas():
    found = law_areas(
        {
            "1": {"a": 1.0, "b": 1.05},
            "2": {"a": 1.0, "b": 1.5},
            "3": {"a": math.inf, "b": 1.0},
            "4": {"a": math.nan, "b": math.nan},
            "5": {"b": 1.0},
        },
        RULES,
    )
    assert found["a"] == Area(0.5, 0.25, 4, 1.0)
    assert found["b"] == Area(0.75, 0.0, 4, 1.5)


def test_ranks_are_among_the_same_sensors():
    _, pairs = cell(a=0.8, b=1.0, c=1.0, d=1.2)
    assert sensor_ranks(pairs, dict.fromkeys("abcd", "VP")) == {"a": 1, "b": 2, "c": 2, "d": 4}
    assert sensor_ranks(pairs, {"a": "VPX", "b": "VP", "c": "V", "d": "VP"}) == {
        "a": 1,
        "b": 1,
        "c": 1,
        "d": 2,
    }


def test_prices_of_sensors():
    standings, pairs = cell(a=0.8, b=1.0, c=1.0, d=1.2)
    (found,) = sensor_prices(standings, pairs, {"a": "VPX", "b": "V", "c": "VPX", "d": "V"}, RULES)
    assert found[:4] == ("V", "VPX", "b", "a")
    assert found.low < found.ratio < found.high
    assert found.ratio == pytest.approx(1.25, rel=0.05)
    assert sensor_prices(standings, pairs, dict.fromkeys("abcd", "V"), RULES) == []
