"""Holm's correction: against a printed example, and against what it is, a closed test."""

from itertools import combinations

import numpy as np
import pytest

from hydroservo.studies.law_pairs import holm_corrected


def test_printed_example():
    # https://en.wikipedia.org/wiki/Holm-Bonferroni_method rejects the first and the last at 0.05
    assert holm_corrected([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])


def closed(chances):
    """The largest of Bonferroni's chances of all sets that a finding is in (Marcus et al. 1976)."""
    number = range(len(chances))
    sets = [s for k in number for s in combinations(number, k + 1)]
    bonferroni = {s: min(1.0, len(s) * min(chances[i] for i in s)) for s in sets}
    return [max(bonferroni[s] for s in sets if i in s) for i in number]


@pytest.mark.parametrize("seed", range(5))
def test_it_is_the_closed_test(seed):
    chances = np.random.default_rng(seed).random(8) ** 3
    assert holm_corrected(chances) == pytest.approx(closed(chances), rel=1e-12)


def test_one_and_none():
    assert holm_corrected([0.03]) == [0.03]
    assert holm_corrected([]) == []
