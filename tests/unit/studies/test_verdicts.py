"""All that a study says, from its table and its manifest."""

import json
import re

import numpy as np
import pandas as pd
import pytest

from hydroservo.errors import HydroservoError, ParameterError
from hydroservo.studies.rules import Rules
from hydroservo.studies.verdicts import judged
from tools.planted import Spreads, manifest, rows, trials, with_lost

RULES = Rules(resamples=200)
LAWS = {
    "lq": {"family": "lq", "observer": "eso"},
    "lq-plain": {"family": "lq", "observer": "eso", "of": "lq", "without": "rates"},
    "pi": {"class": "V"},
    "pi-copy": {"family": "pi", "class": "V", "observer": "eso"},
}
LEVELS = {"lq": 0.8, "lq-plain": 0.9, "pi": 1.0, "pi-copy": 1.0}


def table(levels=LEVELS, cells=("calm", "noisy"), searches=4, conditions=40, lost=None):
    parts = []
    for number, cell in enumerate(cells):
        spreads = Spreads(own=0.05, searches=0.01)
        every = {**LEVELS, **levels}  # drawn alike whichever laws are asked for
        runs = trials(np.random.default_rng(number), every, searches, conditions, spreads)
        for law in levels:
            one = with_lost(runs[law], lost) if lost is not None else runs[law]
            for effort, factor in ((0.0, 1.0), (0.1, 1.2)):
                own = one._replace(error=factor * one.error, activity=one.activity / factor)
                columns = {
                    "effort": effort,
                    "split": "validation",
                    "condition": rows(one, law, cell)["condition"],
                }
                parts += [rows(own, law, cell, **columns), rows(own, law, cell, effort=effort)]
                strained = {"effort": effort, "split": "stress", "scale": 1.0}
                parts.append(rows(own, law, cell, **strained))
    return pd.concat(parts, ignore_index=True)


FOUND = judged(table(), manifest(LAWS), RULES)


def test_what_was_planted_is_found():
    for one in FOUND.cells.values():
        assert (one.best.law, one.best.ties, one.best.state, one.budget) == ("lq", ["lq"], "won", 64)
        assert one.ranks == {"lq": 1, "lq-plain": 2, "pi": 1, "pi-copy": 1}
        assert one.regret["pi"] == pytest.approx(1.25, rel=0.05)
        assert one.standings["pi"].survived == 1.0
        assert {point.law for point in one.front if point.front} == {"lq"}
        assert [stage.budget for stage in one.curves["pi"]] == [64]
    assert FOUND.worths["lq-plain"].over_cells.value == pytest.approx(0.9 / 0.8, rel=0.03)
    assert (FOUND.worths["lq-plain"].whole, FOUND.worths["lq-plain"].wins) == ("lq", 2)
    alike = manifest(LAWS | {"pi-copy": LAWS["lq"]})  # a law of the same making is not the whole of it
    assert judged(table(), alike, RULES).worths["lq-plain"] == FOUND.worths["lq-plain"]
    assert FOUND.prices["V over VP"].value == pytest.approx(1.25, rel=0.05)
    assert FOUND.areas["lq"].near_best == 1.0
    # of the logarithms -0.22, 0 and 0 the family explains 3/4, and the observer nothing beyond it
    assert FOUND.effects["family"].share == pytest.approx(0.75, abs=0.1)


def test_the_order_of_rows_changes_no_bit():
    shuffled = table().sample(frac=1.0, random_state=0)
    assert same(judged(shuffled, manifest(LAWS), RULES), FOUND)


def test_categories_of_text_change_no_bit():
    names = dict.fromkeys(("law", "cell", "optimiser", "split"), "category")
    assert same(judged(table().astype(names), manifest(LAWS), RULES), FOUND)


def same(one, other):
    return json.dumps(one.as_dict()) == json.dumps(other.as_dict())


def test_other_laws_change_no_interval():
    few = judged(table({law: LEVELS[law] for law in ("lq", "pi")}), manifest(LAWS), RULES)
    for cell, one in few.cells.items():
        (alone,) = one.pairs
        among = next(pair for pair in FOUND.cells[cell].pairs if pair[:2] == alone[:2])
        assert alone[4:7] == among[4:7]
        assert one.standings["pi"] == FOUND.cells[cell].standings["pi"]


def test_it_is_json():
    text = json.dumps(FOUND.as_dict(), allow_nan=False)
    assert json.loads(text)["cells"]["calm"]["best"]["law"] == "lq"
    one_search = judged(table(searches=1), manifest(LAWS), RULES).as_dict()
    assert one_search["cells"]["calm"]["pairs"][0]["high"] is None
    json.dumps(one_search, allow_nan=False)


@pytest.mark.parametrize(("searches", "conditions"), [(1, 40), (4, 1), (1, 1)])
def test_one_draw_makes_nobody_win(searches, conditions):
    found = judged(table(searches=searches, conditions=conditions), manifest(LAWS), RULES)
    assert not any(pair.winner for one in found.cells.values() for pair in one.pairs)
    assert {one.best.state for one in found.cells.values()} == {"tie"}


def test_all_lost():
    found = judged(table(lost=np.ones((4, 40), dtype=bool)), manifest(LAWS), RULES)
    for one in found.cells.values():
        assert (one.best.state, one.best.law) == ("none", "")
        assert one.standings["pi"].lost.value == 1.0
        assert one.standings["pi"].survived == 0.0
    assert found.areas["pi"].cells == 0
    json.dumps(found.as_dict(), allow_nan=False)


def test_one_law():
    found = judged(table({"pi": 1.0}), manifest(LAWS), RULES)
    assert found.cells["calm"].best[:4] == ("pi", ["pi"], ["pi"], "won")
    assert found.cells["calm"].pairs == []
    assert found.effects == {}


def test_all_are_judged_after_as_many_candidates():
    half = table()
    longer = half[half["law"] == "pi"].assign(budget=128)
    found = judged(pd.concat([half, longer]), manifest(LAWS), RULES)
    assert found.cells["calm"].budget == 64
    assert [stage.budget for stage in found.cells["calm"].curves["pi"]] == [64, 128]


def without(rows_, **values):
    some = np.ones(len(rows_), dtype=bool)
    for name, value in values.items():
        some &= (rows_[name] == value).to_numpy()
    return rows_[~some]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda rows_: without(rows_, split="test"), "law lq, cell calm: no test runs"),
        (lambda rows_: without(rows_, split="test", law="pi"), "law pi, cell calm: no test runs"),
        (lambda rows_: without(rows_, split="validation", law="pi"), "law pi, .*: no validation runs"),
        (
            lambda rows_: without(rows_, split="test", law="pi", condition=3),
            "cell calm: lq and pi met different conditions",
        ),
        (
            lambda rows_: without(rows_, split="test", law="pi", condition=3, optimiser="de"),
            "law pi, cell calm: each search must have each condition once",
        ),
        (
            lambda rows_: pd.concat([rows_, rows_[rows_["split"] == "test"].head(1)]),
            "law lq, cell calm: each search must have each condition once",
        ),
        (
            lambda rows_: rows_.assign(budget=np.where(rows_["law"] == "pi", 128, 64)),
            "cell calm: no budget that all searches reached",
        ),
        (lambda rows_: rows_.assign(law="mine"), "study.json: laws: no mine"),
    ],
)
def test_what_cannot_be_judged_is_refused(change, message):
    with pytest.raises(HydroservoError, match=message):
        judged(change(table()), manifest(LAWS), RULES)


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
        judged(table({"pi": 1.0}), {"laws": {"pi": own}}, RULES)


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
        judged(table(), manifest(LAWS), RULES._replace(**{name: value}))
