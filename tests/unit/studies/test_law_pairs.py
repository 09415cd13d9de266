"""Who wins a pair, and by what."""

import math

import numpy as np
import pytest

from hydroservo.studies.law_pairs import pairs_of, ratio_between, rivals_of
from hydroservo.studies.trials import Rules
from tools.planted import Spreads, trials, with_lost


def planted(seed=0, **levels):
    return trials(np.random.default_rng(seed), levels)


def test_the_better_law_wins():
    (pair,) = pairs_of(planted(good=0.9, poor=1.0), Rules())
    assert (pair.a, pair.b, pair.winner, pair.by) == ("good", "poor", "good", "error")
    assert pair.low < 0.9 < pair.high
    assert pair.low < pair.ratio < pair.high < 1.0


def test_a_copy_ties():
    (pair,) = pairs_of(planted(one=1.0, other=1.0), Rules())
    assert (pair.winner, pair.by) == ("", "")
    assert pair.low < 1.0 < pair.high


def test_what_is_sure_and_small_ties():
    tight = Spreads(own=0.01)
    runs = trials(np.random.default_rng(0), {"good": 0.97, "poor": 1.0}, spreads=tight)
    (pair,) = pairs_of(runs, Rules())
    assert pair.high < 1.0
    assert pair.winner == ""
    assert pairs_of(runs, Rules(margin=1.01))[0].winner == "good"


def test_no_error_makes_up_for_lost_runs():
    runs = planted(good=0.5, poor=1.0)
    lost = np.arange(200) < 12
    (pair,) = pairs_of(runs | {"good": with_lost(runs["good"], lost)}, Rules())
    assert (pair.winner, pair.by) == ("poor", "lost runs")
    assert (pair.conditions, pair.only_a_lost, pair.only_b_lost) == (188, 12, 0)
    assert pair.more_lost == pytest.approx(0.06)
    assert pair.ratio == pytest.approx(0.5, rel=0.05)


def test_one_lost_run_shows_and_does_not_decide():
    runs = planted(good=0.8, poor=1.0)
    lost = np.arange(200) == 3
    (pair,) = pairs_of(runs | {"good": with_lost(runs["good"], lost)}, Rules())
    assert (pair.winner, pair.by) == ("good", "error")
    assert (pair.conditions, pair.only_a_lost, pair.more_lost) == (199, 1, pytest.approx(0.005))


def test_who_loses_all_loses():
    runs = planted(good=0.8, poor=1.0)
    (pair,) = pairs_of(runs | {"good": with_lost(runs["good"], np.ones(200, dtype=bool))}, Rules())
    assert (pair.winner, pair.by, pair.conditions) == ("poor", "lost runs", 0)
    assert math.isnan(pair.ratio)
    assert (pair.low, pair.high) == (0.0, math.inf)


def test_both_losing_all_tie():
    everything = np.ones(200, dtype=bool)
    runs = {law: with_lost(one, everything) for law, one in planted(good=0.8, poor=1.0).items()}
    assert pairs_of(runs, Rules())[0].winner == ""


def test_other_laws_change_no_interval_and_raise_chances():
    few, many = planted(a=0.9, b=1.0), planted(a=0.9, b=1.0, c=1.1, d=1.2)
    (alone,), among = pairs_of(few, Rules()), pairs_of(many, Rules())[0]
    assert alone[4:7] == among[4:7]
    assert alone.chance < among.chance


def test_ratios_either_way():
    pairs = pairs_of(planted(a=0.9, b=1.0), Rules())
    there, back = ratio_between(pairs, "a", "b"), ratio_between(pairs, "b", "a")
    assert back == pytest.approx((1.0 / there[0], 1.0 / there[2], 1.0 / there[1]))
    assert ratio_between(pairs, "a", "a") == (1.0, 1.0, 1.0)
    one = {law: type(own)(*(of[:1] for of in own)) for law, own in planted(a=1.0, b=1.1).items()}
    assert ratio_between(pairs_of(one, Rules()), "b", "a")[1:] == (0.0, math.inf)


def test_rivals():
    pairs = pairs_of(planted(a=0.8, b=1.0, c=1.0), Rules())
    assert rivals_of(pairs, "a") == ([], [])
    assert rivals_of(pairs, "b") == (["a"], ["c"])
