"""A law for a static valve on a slow one."""

import math
from typing import NamedTuple

import pytest

from hydroservo.control.controllers import Saturation, ValveInversion
from hydroservo.core.block import Block
from hydroservo.core.signals import Demand, Measurement

DT, TAU = 1e-3, 0.01
KEPT = math.exp(-DT / TAU)
NONE = Demand(0.0, 0.0, 0.0)


class WantedState(NamedTuple):
    u: float
    told: float


class Wanted(NamedTuple):
    """Wants an opening of its own, and keeps what it is told was applied."""

    opening: float

    def init(self) -> WantedState:
        return WantedState(0.0, 0.0)

    def step(self, s: WantedState, y: Measurement, r: Demand, dt: float) -> WantedState:
        return WantedState(self.opening, y.command)


def after(law: ValveInversion, steps: int) -> tuple[Block, float, float]:
    """The wrapper's state, an exact spool's opening and its mean over the last period, after some steps."""
    s, opening, mean = law.init(), 0.0, 0.0
    for _ in range(steps):
        s = law.step(s, Measurement(0.0, 0.0, 0.0, s.u, 0.0, 0.0, 0.0), NONE, DT)
        mean = s.u + (opening - s.u) * (1.0 - KEPT) * TAU / DT
        opening = s.u + (opening - s.u) * KEPT
    return s, opening, mean


@pytest.mark.parametrize("steps", [1, 2, 5])
def test_the_spool_gets_where_the_law_wants_it_by_the_next_sample(steps: int) -> None:
    s, opening, _ = after(ValveInversion(Wanted(0.3), TAU), steps)
    assert opening == pytest.approx(0.3, rel=1e-12)
    assert s.controller.u == 0.3


def test_beyond_the_limit_it_gets_there_as_fast_as_it_can() -> None:
    law = ValveInversion(Wanted(5.0), TAU, saturation=Saturation(10.0))
    openings = [after(law, steps)[1] for steps in (1, 4, 10)]
    assert openings[:2] == pytest.approx([10.0 * (1.0 - KEPT**n) for n in (1, 4)])
    assert openings[2] == pytest.approx(5.0)


def test_the_law_is_told_the_mean_opening() -> None:
    law = ValveInversion(Wanted(0.3), TAU)
    for steps in (1, 2, 6):
        s, _, mean = after(law, steps)
        y = Measurement(0.0, 0.0, 0.0, s.u, 0.0, 0.0, 0.0)
        assert law.step(s, y, NONE, DT).controller.told == pytest.approx(mean, rel=1e-12)


def test_a_slower_reach_is_a_calmer_command() -> None:
    commands = [after(ValveInversion(Wanted(0.3), TAU, reach=reach), 1)[0].u for reach in (1.0, 2.0)]
    assert commands == pytest.approx([0.3 / (1.0 - KEPT), 0.3 / (1.0 - KEPT**2)])
    assert after(ValveInversion(Wanted(0.3), TAU, reach=2.0), 40)[1] == pytest.approx(0.3)
