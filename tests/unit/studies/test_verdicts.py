"""All that a study says, from its table and its manifest."""

import json
import re

import numpy as np
import pandas as pd
import pytest

from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.studies.trials import Rules
from hydroservo.studies.verdicts import study_verdicts
from tools.planted import Spreads, manifest, rows, trials, with_lost

RULES = Rules(resamples=200)
LAWS = {
    "lq": {"family": "lq", "observer": "eso"},
    "lq-plain": {"family": "lq", "observer": "eso", "of": "lq", "without": "rates"},
    "pi": {"class": "V"},
    "pi-copy": {"family": "pi", "class": "V", "observer": "eso"},
}
LEVELS = {"lq": 0.8, "lq-plain": 0.9, "pi": 1.0, "pi-copy": 1.0}


def table(levels=LEVELS, cells=("calm", "noisy"), conditions=40, lost=None):
    """Laws of two points each: the first at 1 %/s, the second twice as active with 0.9 of its error."""
    parts = []
    for number, cell in enumerate(cells):
        every = {**LEVELS, **levels}  # drawn alike whichever laws are asked for
        runs = trials(np.random.default_rng(number), every, conditions, Spreads(own=0.05))
        for law in levels:
            one = with_lost(runs[law], lost) if lost is not None else runs[law]
            for point, (factor, activity) in enumerate(((1.0, 1.0), (0.97, 2.0))):
                own = one._replace(error=factor * one.error, activity=activity * one.activity)
                parts += [
                    rows(own, law, cell, point=point, split="validation"),
                    rows(own, law, cell, point=point),
                ]
                parts.append(rows(own, law, cell, point=point, split="stress", scale=1.0))
    return pd.concat(parts, ignore_index=True)


FOUND = study_verdicts(table(), manifest(LAWS), RULES)


def test_what_was_planted_is_found():
    own, lively = FOUND.levels["1"], FOUND.levels["2"]
    assert FOUND.activity == {"calm": pytest.approx(1.0), "noisy": pytest.approx(1.0)}
    assert FOUND.levels["0.5"].cells == {}  # no law is so calm
    for cell, one in own.cells.items():
        assert (one.best.law, one.best.ties, one.best.state) == ("lq", ["lq"], "won")
        assert one.ranks == {"lq": 1, "lq-plain": 2, "pi": 1, "pi-copy": 1}
        assert one.regret["pi"] == pytest.approx(1.25, rel=0.05)
        assert one.to_own["lq"].value == pytest.approx(0.8, rel=0.05)
        assert one.to_own["pi"] == (1.0, 1.0, 1.0)
        assert one.standings["pi"].survived == 1.0
        assert lively.cells[cell].to_own["pi"].value == pytest.approx(0.97)
        points = FOUND.fronts[cell]["lq"].points
        assert [point.activity for point in points] == pytest.approx([1.0, 2.0])
        assert [point.level for point in points] == [1.0, 2.0]
    assert own.worths["lq-plain"].over_cells.value == pytest.approx(0.9 / 0.8, rel=0.03)
    assert (own.worths["lq-plain"].whole, own.worths["lq-plain"].wins) == ("lq", 2)
    alike = manifest(LAWS | {"pi-copy": LAWS["lq"]})  # a law of the same making is not the whole of it
    assert study_verdicts(table(), alike, RULES).levels["1"].worths["lq-plain"] == own.worths["lq-plain"]
    assert own.prices["V over VP"].value == pytest.approx(1.25, rel=0.05)
    assert own.areas["lq"].near_best == 1.0
    # of the logarithms -0.22, 0 and 0 the family explains 3/4, and the observer nothing beyond it
    assert own.effects["family"].share == pytest.approx(0.75, abs=0.1)


def test_the_order_of_rows_changes_no_bit():
    shuffled = table().sample(frac=1.0, random_state=0)
    assert same(study_verdicts(shuffled, manifest(LAWS), RULES), FOUND)


def test_categories_of_text_change_no_bit():
    names = dict.fromkeys(("law", "cell", "split"), "category")
    assert same(study_verdicts(table().astype(names), manifest(LAWS), RULES), FOUND)


def same(one, other):
    return json.dumps(one.as_dict()) == json.dumps(other.as_dict())


def test_other_laws_change_no_interval():
    few = study_verdicts(table({law: LEVELS[law] for law in ("lq", "pi")}), manifest(LAWS), RULES).levels["1"]
    for cell, one in few.cells.items():
        (alone,) = one.pairs
        there = FOUND.levels["1"].cells[cell]
        among = next(pair for pair in there.pairs if pair[:2] == alone[:2])
        assert alone[4:7] == among[4:7]
        assert one.standings["pi"] == there.standings["pi"]


def test_it_is_json():
    text = json.dumps(FOUND.as_dict(), allow_nan=False)
    assert json.loads(text)["levels"]["1"]["cells"]["calm"]["best"]["law"] == "lq"
    one = study_verdicts(table(conditions=1), manifest(LAWS), RULES).as_dict()
    assert one["levels"]["1"]["cells"]["calm"]["pairs"][0]["high"] is None
    json.dumps(one, allow_nan=False)


def test_one_condition_makes_nobody_win():
    found = study_verdicts(table(conditions=1), manifest(LAWS), RULES).levels["1"]
    assert not any(pair.winner for one in found.cells.values() for pair in one.pairs)
    assert {one.best.state for one in found.cells.values()} == {"tie"}


def test_most_lost():
    found = study_verdicts(table(lost=np.arange(40) < 20), manifest(LAWS), RULES).levels["1"]
    for one in found.cells.values():
        assert (one.best.state, one.best.law) == ("none", "")
        assert one.standings["pi"].lost.value == 0.5
        assert one.standings["pi"].survived == 0.0
    assert found.areas["pi"].cells == 0


def test_a_reference_that_loses_all_has_no_activity():
    with pytest.raises(HydroservoError, match="cell calm: the reference, pi, loses all its runs"):
        study_verdicts(table(lost=np.ones(40, dtype=bool)), manifest(LAWS), RULES)


def test_one_law():
    found = study_verdicts(table({"pi": 1.0}), manifest(LAWS), RULES).levels["1"]
    assert found.cells["calm"].best[:4] == ("pi", ["pi"], ["pi"], "won")
    assert found.cells["calm"].pairs == []
    assert found.effects == {}


def without(rows_, **values):
    some = np.ones(len(rows_), dtype=bool)
    for name, value in values.items():
        some &= (rows_[name] == value).to_numpy()
    return rows_[~some]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda rows_: without(rows_, split="test"), "law lq, cell calm, level 1: no test runs"),
        (lambda rows_: without(rows_, split="test", law="pi"), "law pi, cell calm, level 1: no test runs"),
        (lambda rows_: without(rows_, split="validation"), "no validation runs"),
        (
            lambda rows_: without(rows_, split="test", law="pi", condition=3),
            "cell calm: lq and pi met different conditions",
        ),
        (
            lambda rows_: pd.concat([rows_, rows_[rows_["split"] == "test"].head(1)]),
            "law lq, cell calm: has a condition twice",
        ),
        (lambda rows_: rows_.assign(law="mine"), "study.json: laws: no mine"),
    ],
)
def test_what_cannot_be_judged_is_refused(change, message):
    with pytest.raises(HydroservoError, match=message):
        study_verdicts(change(table()), manifest(LAWS), RULES)


@pytest.mark.parametrize(
    ("own", "message"),
    [
        ({"family": "pi"}, "study.json: laws.pi: no observer, wrapper, class"),
        (manifest({"pi": {"class": "X"}})["laws"]["pi"], "laws.pi.class = 'X': must be one of V, VP, VPX"),
        (manifest({"pi": {"without": "rates"}})["laws"]["pi"], "laws.pi.of = None: must be one of its laws"),
    ],
)
def test_a_manifest_that_does_not_say_is_refused(own, message):
    with pytest.raises(HydroservoError, match=re.escape(message)):
        study_verdicts(table({"pi": 1.0}), manifest({}) | {"laws": {"pi": own}}, RULES)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("confidence", 1.0),
        ("worst", 0.0),
        ("margin", 0.9),
        ("near_best", float("nan")),
        ("most_lost", 1.0),
        ("resamples", 0),
        ("seed", -1),
    ],
)
def test_rules_out_of_range_are_refused(name, value):
    with pytest.raises(ParameterError, match=rf"rules.{name} = "):
        study_verdicts(table(), manifest(LAWS), RULES._replace(**{name: value}))
