"""Whether 95 % intervals hold the truth as often as they say, over logs that differ in nothing but chance."""

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.core.block import value_at
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

SEEDS = 40  # of the 200 of ``scripts/coverage``, which leave a rate of 95 % uncertain by 1.5 %
LEAST = 0.85  # of 40; at a rate of 95 % less has a chance of 1 in 200


@pytest.fixture(scope="module")
def held() -> dict[str, list[bool]]:
    """Of the logs that are said to tell a parameter: whether its interval holds the truth."""
    truth, exact = hs.load_scenario(SCENARIO, SHORT), exact_log()
    found: dict[str, list[bool]] = {path: [] for path in RANGES}
    for seed in range(SEEDS):
        identified = hs.identify(SCENARIO, recorded(exact, seed), RANGES, changes=SHORT | WRONG)
        for path, one in identified.parameters.items():
            if one.identifiable:
                found[path].append(one.low <= value_at(truth, path) <= one.high)
    return found


@pytest.mark.nightly  # many logs each
def test_what_no_log_tells_is_not_said_to_be_told(held):
    assert not any(held[path] for path in (*TOGETHER, SILENT))


@pytest.mark.nightly  # many logs each
@pytest.mark.parametrize("path", TOLD)
def test_intervals_hold_the_truth_as_often_as_they_say(path, held):
    assert len(held[path]) > 0.97 * SEEDS
    assert np.mean(held[path]) >= LEAST
