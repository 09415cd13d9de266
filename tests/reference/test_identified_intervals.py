"""Whether 95 % intervals hold the truth as often as they say, over logs that differ in nothing but chance."""

from functools import cache

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.block import value_at
from tests.support.synthetic_logs import (
    RANGES,
    SCENARIO,
    SHORT,
    SILENT,
    TOGETHER,
    TOLD,
    WRONG,
    exact_log,
    recorded,
)

SEEDS = 200  # which leave a rate of 95 % uncertain by 1.5 %
PART = 50


@cache
def told(first: int) -> dict[str, list[bool]]:
    """Of some logs, for each parameter that is said to be told: whether its interval holds the truth."""
    truth, exact = hs.load_scenario(SCENARIO, SHORT), exact_log()
    held: dict[str, list[bool]] = {path: [] for path in RANGES}
    for seed in range(first, first + PART):
        found = hs.identify(SCENARIO, recorded(exact, seed), RANGES, changes=SHORT | WRONG)
        for path, one in found.parameters.items():
            if one.identifiable:
                held[path].append(one.low <= value_at(truth, path) <= one.high)
    return held


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, SEEDS, PART))
def test_what_no_log_tells_is_not_said_to_be_told(first):
    assert not any(told(first)[path] for path in (*TOGETHER, SILENT))


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say():
    parts = [told(first) for first in range(0, SEEDS, PART)]
    for path in TOLD:
        held = [one for part in parts for one in part[path]]
        assert len(held) > 0.97 * SEEDS, path
        assert 0.90 <= np.mean(held) <= 0.98 + 0.015, path
