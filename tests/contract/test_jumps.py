"""What ``next_jump`` of every load promises to the integrators that end their steps there."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hydroservo.core.block import Block
from hydroservo.core.roles import Load
from hydroservo.machine.loads import Sine, Square, Step
from hydroservo.testing.drawing import ORDINARY, random_blocks
from hydroservo.testing.examples import example
from tests.support.roles import identifier, playing

BEFORE, AFTER = 1.0 - 2.0**-50, 1.0 + 2.0**-50  # as near to a jump as integrators go
JUMPS = 20

every_load = pytest.mark.parametrize("cls", playing(Load), ids=identifier)


def jumps(load: Block, t: float) -> list[float]:
    """The next ones, the search going on just after each."""
    found: list[float] = []
    while len(found) < JUMPS:
        t = load.next_jump(AFTER * found[-1] if found else t)
        if t == math.inf:
            break
        found.append(t)
    return found


@every_load
class TestJumps:
    @settings(max_examples=50)
    @given(data=st.data(), t=st.floats(0.0, 1e4))
    def test_they_come_one_after_the_other(self, cls: type, data: st.DataObject, t: float) -> None:
        load = data.draw(random_blocks(example(cls), ORDINARY))
        found = [t, *jumps(load, t)]
        assert all(later > earlier for earlier, later in pairwise(found))

    @settings(max_examples=50)
    @given(data=st.data(), t=st.floats(0.0, 100.0), where=st.floats(0.0, 1.0))
    def test_the_next_one_is_the_same_all_the_way_to_it(
        self, cls: type, data: st.DataObject, t: float, where: float
    ) -> None:
        load = data.draw(random_blocks(example(cls), ORDINARY))
        found = [t, *jumps(load, t)]
        for earlier, later in pairwise(found):
            between = AFTER * earlier + where * (BEFORE * later - AFTER * earlier)
            assert load.next_jump(between) == pytest.approx(later, rel=1e-14)

    @settings(max_examples=50)
    @given(data=st.data(), t=st.floats(0.0, 100.0))
    def test_between_them_the_force_is_smooth(self, cls: type, data: st.DataObject, t: float) -> None:
        """A cubic through four instants meets the force in between: all but the sine are piecewise cubics.

        Of a sine, a stretch that is short beside the quickest one drawn.
        """
        reach = 1e-2 if cls is Sine else 1e3
        load = data.draw(random_blocks(example(cls), ORDINARY))
        found = [t, *jumps(load, t)]
        ends = [] if len(found) > JUMPS else [math.inf]
        for earlier, later in pairwise([*found, *ends]):
            start, end = AFTER * earlier, min(BEFORE * later, earlier + reach)
            at = np.linspace(start, end, 7)
            if end - start < 1e-9 * end:
                continue
            force = np.array([load.force(float(one)) for one in at])
            place = np.linspace(-1.0, 1.0, 7)
            cubic = np.polynomial.Polynomial.fit(place[::2], force[::2], 3)
            assert np.abs(cubic(place) - force).max() <= 1e-3 * max(np.ptp(force), 1e-9 * np.abs(force).max())


def test_where_they_are() -> None:
    assert jumps(example(Step, time=0.25), 0.0) == [pytest.approx(0.25)]
    assert jumps(example(Step, time=0.0), 0.0) == []
    assert jumps(example(Square, period=4.0), 1.0)[:3] == pytest.approx([2.0, 4.0, 6.0])
