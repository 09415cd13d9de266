"""Each law of a cell against each other, and a part of a law against none: won by whom, and by what."""

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from hydroservo.studies.law_standing import fewer_lost
from hydroservo.studies.trials import (
    MeanEstimate,
    Rules,
    Trials,
    exponentials,
    mean_estimate,
    paired_difference,
)


class LawPair(NamedTuple):
    """Two laws in one cell.

    Attributes:
        a, b: their names, in alphabetical order.
        winner: the name of the law that won; empty for a tie.
        by: ``"lost runs"`` or ``"error"``, which decided it; empty for a tie.
        ratio, low, high: a's error over b's, geometric mean over conditions in which neither lost its run,
            with its interval; nan, 0 and inf where nothing can be said.
        chance: Holm's, of such a ratio where there is no difference.
        more_lost, more_lost_low, more_lost_high: a's share of lost runs less b's, with its interval.
        lost_chance: Holm's, of such a difference of shares where there is none.
        conditions: how many the ratio is over.
        only_a_lost, only_b_lost: in how many conditions only a, or only b, lost its run.
    """

    a: str
    b: str
    winner: str
    by: str
    ratio: float
    low: float
    high: float
    chance: float
    more_lost: float
    more_lost_low: float
    more_lost_high: float
    lost_chance: float
    conditions: int
    only_a_lost: int
    only_b_lost: int


def pairs_of(trials: Mapping[str, Trials], rules: Rules) -> list[LawPair]:
    """All pairs of a cell's laws.

    Two things are asked of a pair: whether one law loses a greater share of its runs, if any was lost, and
    whose error is less over the conditions in which neither lost its run. Holm's correction is
    over all that is asked in the cell. The law that loses fewer runs wins, whatever the errors; no error
    makes up for an axis that went astray. If neither loses fewer the law with less error wins, where the
    ratio is at least the margin.
    """
    names = list(combinations(sorted(trials), 2))
    errors = [paired_difference(trials[a].logs(), trials[b].logs(), rules.confidence) for a, b in names]
    lost = [fewer_lost(trials[a].lost, trials[b].lost, rules.confidence) for a, b in names]
    asked = [bool(trials[a].lost.any() or trials[b].lost.any()) for a, b in names]
    of_errors = [one.chance for one in errors]
    of_lost = [one.chance for one, any_lost in zip(lost, asked, strict=True) if any_lost]
    chances = holm_corrected([*of_errors, *of_lost])
    rest = iter(chances[len(names) :])
    return [
        pair_verdict(
            (a, trials[a]),
            (b, trials[b]),
            errors[i]._replace(chance=chances[i]),
            lost[i]._replace(chance=next(rest) if asked[i] else 1.0),
            rules,
        )
        for i, (a, b) in enumerate(names)
    ]


def pair_verdict(
    a: tuple[str, Trials], b: tuple[str, Trials], errors: MeanEstimate, lost: MeanEstimate, rules: Rules
) -> LawPair:
    """What was found of a pair, its chances corrected, put together."""
    level = 1.0 - rules.confidence
    winner, by = "", ""
    if lost.chance <= level:
        winner, by = b[0] if lost.value > 0.0 else a[0], "lost runs"
    elif errors.chance <= level and abs(errors.value) >= math.log(rules.margin):
        winner, by = b[0] if errors.value > 0.0 else a[0], "error"
    lost_a, lost_b = a[1].lost, b[1].lost
    ratio, low, high = exponentials(errors)
    return LawPair(
        a=a[0],
        b=b[0],
        winner=winner,
        by=by,
        ratio=ratio,
        low=low,
        high=high,
        chance=errors.chance,
        more_lost=lost.value,
        more_lost_low=max(lost.low, -1.0),
        more_lost_high=min(lost.high, 1.0),
        lost_chance=lost.chance,
        conditions=int((~(lost_a | lost_b)).sum()),
        only_a_lost=int((lost_a & ~lost_b).sum()),
        only_b_lost=int((lost_b & ~lost_a).sum()),
    )


def ratio_between(pairs: list[LawPair], one: str, other: str) -> tuple[float, float, float]:
    """The error of one law over another's with its interval; 1 of a law over itself."""
    if one == other:
        return 1.0, 1.0, 1.0
    found = pair_between(pairs, one, other)
    if found.a == one:
        return found.ratio, found.low, found.high
    return 1.0 / found.ratio, 1.0 / found.high, 1.0 / found.low if found.low > 0.0 else math.inf


def pair_between(pairs: list[LawPair], one: str, other: str) -> LawPair:
    return next(pair for pair in pairs if {pair.a, pair.b} == {one, other})


def rivals_of(pairs: list[LawPair], law: str) -> tuple[list[str], list[str]]:
    """The laws that beat a law, and those that tie with it."""
    own = [pair for pair in pairs if law in (pair.a, pair.b)]
    beat = [pair.winner for pair in own if pair.winner and pair.winner != law]
    tie = [pair.b if pair.a == law else pair.a for pair in own if not pair.winner]
    return sorted(beat), sorted(tie)


def holm_corrected(chances: Sequence[float]) -> list[float]:
    """Chances, corrected so that below a level is at most that share of studies with any false one.

    In rising order the i-th of m is min(1, max over j <= i of (m - j + 1) p(j)).

    Source: Holm 1979, A simple sequentially rejective multiple test procedure, Scandinavian Journal of
    Statistics 6, 65-70.
    """
    plain = np.asarray(chances, dtype=np.float64)
    order = np.argsort(plain, kind="stable")
    scaled = plain[order] * np.arange(plain.size, 0, -1)
    found = np.empty_like(plain)
    found[order] = np.minimum(np.maximum.accumulate(scaled), 1.0) if plain.size else scaled
    return [float(one) for one in found]


class ErrorRatio(NamedTuple):
    """A ratio of errors with its interval.

    Attributes:
        value: its estimate; nan where there is none.
        low, high: the ends of its interval.
    """

    value: float
    low: float
    high: float


class Worth(NamedTuple):
    """What a part of a law is worth: the error without it over that of the whole law.

    Attributes:
        part: what is left out.
        whole: the name of the law that has it.
        cells: the ratio in each cell in which both are.
        over_cells: its geometric mean.
        wins, ties, losses: in how many cells the whole law wins against the one without the part, ties with
            it, and loses to it.
    """

    part: str
    whole: str
    cells: dict[str, ErrorRatio]
    over_cells: ErrorRatio
    wins: int
    ties: int
    losses: int


def part_worths(
    pairs: Mapping[str, list[LawPair]], laws: Mapping[str, Mapping[str, Any]], confidence: float
) -> dict[str, Worth]:
    """What parts are worth, by the name of the law that lacks one."""
    found = {}
    for law, whole in {name: own["of"] for name, own in laws.items() if own["of"] in laws}.items():
        own = {
            cell: one for cell, one in pairs.items() if {law, whole} <= {name for p in one for name in p[:2]}
        }
        ratios = {cell: ErrorRatio(*ratio_between(one, law, whole)) for cell, one in own.items()}
        winners = [pair_between(one, law, whole).winner for one in own.values()]
        over = ratio_over_cells(ratios, confidence)
        counts = (winners.count(whole), winners.count(""), winners.count(law))
        found[law] = Worth(laws[law]["without"], whole, ratios, over, *counts)
    return found


def ratio_over_cells(ratios: Mapping[str, tuple[float, float, float]], confidence: float) -> ErrorRatio:
    """The geometric mean of a ratio over cells, with an interval for cells that were not asked."""
    known = [one for one in ratios.values() if not math.isnan(one[0])]
    if len(known) == 1:
        return ErrorRatio(*known[0])
    return ErrorRatio(*exponentials(mean_estimate(np.log([one[0] for one in known]), confidence)))
