"""Which part of a loop earns how much, and the bootstrap that says how sure that is."""

import math
from itertools import product

import numpy as np
import pytest

from hydroservo.studies.factors import bootstrap_weights, cell_means, drawn_mean, factor_effects
from hydroservo.studies.law_pairs import ratio_over_cells
from hydroservo.studies.trials import Rules, Trials
from tools.planted import Spreads, trials, with_lost

RULES = Rules(resamples=2000)
FAMILY, OBSERVER = {"pi": 1.0, "lq": 0.8}, {"none": 1.0, "eso": 0.5, "kf": 0.5}
EVERY = {f"{family}-{observer}": (family, observer) for family, observer in product(FAMILY, OBSERVER)}
LEVELS = {
    law: {"family": family, "observer": observer, "wrapper": "", "without": ""}
    for law, (family, observer) in EVERY.items()
}
TRUE = {law: FAMILY[family] * OBSERVER[observer] for law, (family, observer) in EVERY.items()}
CLEAR = Spreads(own=0.05)


def study(true, cells="12"):
    """Runs of laws in cells, and the effects that they show."""
    runs = {cell: trials(np.random.default_rng(int(cell)), true, spreads=CLEAR) for cell in cells}
    levels = {law: LEVELS[law] for law in true}
    return factor_effects(cell_means(runs, levels, RULES), levels, 0.95)


def true_shares():
    """Of a full factorial without interaction: the variances of the factors add up to the whole."""
    parts = {"family": np.var(np.log([*FAMILY.values()])), "observer": np.var(np.log([*OBSERVER.values()]))}
    return {name: part / sum(parts.values()) for name, part in parts.items()}


def test_planted_effects_are_found():
    found = study(TRUE)
    assert list(found) == ["family", "observer"]  # all have the same wrapper
    for name, share in true_shares().items():
        assert found[name].share == pytest.approx(share, abs=0.03)
        assert found[name].low < found[name].share < found[name].high
    assert found["family"].share + found["observer"].share == pytest.approx(1.0, abs=0.01)
    mean = np.prod(list(OBSERVER.values())) ** (1 / 3)
    for level, value in OBSERVER.items():
        ratio = found["observer"].levels[level]
        assert ratio.low < value / mean < ratio.high
        assert ratio.value == pytest.approx(value / mean, rel=0.03)


def test_a_factor_that_earns_nothing():
    assert study({law: OBSERVER[observer] for law, (_, observer) in EVERY.items()})["family"].share < 0.01


def test_a_hole_in_the_factorial():
    found = study({law: level for law, level in TRUE.items() if law != "lq-kf"})
    assert found["observer"].levels["kf"].value < 0.8
    assert found["observer"].levels["none"].value > 1.2
    assert found["family"].levels["lq"].value == pytest.approx(math.sqrt(0.8), rel=0.05)


def test_factors_that_cannot_be_told_apart_have_no_share():
    found = study({law: TRUE[law] for law in ("pi-none", "lq-eso")})
    assert found["family"].share == pytest.approx(0.0, abs=1e-9)
    assert math.isnan(found["family"].levels["pi"].value)


def test_one_law_has_no_factors():
    assert study({"pi-none": 1.0}) == {}


def test_the_bootstrap_spreads_as_the_mean_does():
    one = trials(np.random.default_rng(0), {"a": 1.0}, spreads=Spreads(conditions=0.2))["a"]
    draws = drawn_mean(one, bootstrap_weights(200, Rules(), "c"))
    assert draws.size == 10_000
    assert draws.mean() == pytest.approx(one.logs().mean(), abs=4 * draws.std() / 100)
    assert draws.var() == pytest.approx(one.logs().var(ddof=1) / 200, rel=0.1)


def test_draws_depend_on_names_alone():
    first, again = bootstrap_weights(5, RULES, "c", "a"), bootstrap_weights(5, RULES, "c", "a")
    assert np.array_equal(first, again)
    assert (first.sum(axis=1) == 4).all()
    others = [
        bootstrap_weights(5, RULES, "c", "b"),
        bootstrap_weights(5, RULES, "c"),
        bootstrap_weights(5, RULES._replace(seed=1), "c", "a"),
    ]
    assert not any(np.array_equal(first, other) for other in others)
    assert np.isnan(bootstrap_weights(1, RULES, "c", "a")).all()


def test_draws_leave_lost_runs_out():
    one = trials(np.random.default_rng(0), {"a": 1.0}, conditions=30)["a"]
    lost = np.arange(30) == 3
    drawn = bootstrap_weights(30, RULES, "c")
    without = Trials(*(x[~lost] for x in one))
    expected = drawn_mean(without, drawn[:, ~lost])
    assert drawn_mean(with_lost(one, lost), drawn) == pytest.approx(expected, rel=1e-9)


def test_one_condition_has_no_interval():
    one = trials(np.random.default_rng(0), {"a": 1.0}, conditions=1)["a"]
    assert np.isnan(drawn_mean(one, bootstrap_weights(1, RULES, "c"))).all()


def test_a_ratio_over_cells():
    found = ratio_over_cells(
        {"1": (1.0, 0.9, 1.1), "2": (4.0, 3.0, 5.0), "3": (math.nan, 0.0, math.inf)}, 0.95
    )
    assert found.value == pytest.approx(2.0)
    assert found.low < 1.0
    assert found.high > 4.0
    assert ratio_over_cells({"1": (1.0, 0.9, 1.1)}, 0.95) == (1.0, 0.9, 1.1)
    assert math.isnan(ratio_over_cells({}, 0.95).value)
