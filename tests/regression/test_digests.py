"""The built-in scenarios give the bits that they gave before."""

import pytest

from tests.support.digests import digests_of, stored
from tests.support.scenarios import LOOPS
from tests.support.tiers import mostly


@pytest.mark.parametrize(
    "scenario",
    mostly(
        pytest.mark.slow, LOOPS, ["axis/position", "laws/lq-sine", "paper/sine-tsmc", "rig/excavator-link"]
    ),
)
def test_strict_results_are_as_they_were(scenario: str) -> None:
    before, now = stored()[scenario], digests_of(scenario)
    assert {name: digest for name, digest in now.items() if before.get(name) != digest} == {}
    assert set(now) == set(before)


def test_each_scenario_has_digests() -> None:
    assert set(stored()) == set(LOOPS)
