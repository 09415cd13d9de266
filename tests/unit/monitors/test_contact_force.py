"""What is made of a force that meets a workpiece, holds, and lets go."""

import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from hydroservo import ParameterError
from hydroservo.control.monitors import ContactForce
from hydroservo.core.signals import Demand
from hydroservo.core.validation import checked

DT = 0.125  # exact
LOOP: Any = SimpleNamespace(
    seen=lambda s, load: SimpleNamespace(force=s.force + 0.0 * load), load=SimpleNamespace(force=float)
)


def judged(monitor: ContactForce, forces: Sequence[float], turned: int, error: float = 0.0) -> Any:
    """What it makes of forces DT apart; the demand is ahead by an error, and goes back from an instant on."""
    m = monitor.init()
    for k, force in enumerate(forces):
        demand = Demand(error, -2.0 if k >= turned else 2.0, 0.0)
        s: Any = SimpleNamespace(force=force, reference=demand, controlled=SimpleNamespace(value=0.0))
        m = monitor.step(m, LOOP, s, k * DT, DT if k < len(forces) - 1 else 0.0)
    return monitor.values(m)


def test_the_force_that_is_held() -> None:
    """Contact at the third instant, in the band of 5 % from the sixth on; after the turn nothing counts."""
    values = judged(ContactForce(100.0), [0.0, 4.0, 30.0, 112.0, 94.0, 96.0, 103.0, 500.0, 0.0], turned=7)
    assert values == pytest.approx((0.12, 3 * DT, 0.0))


def test_the_time_to_hold_begins_where_the_demand_meets_the_workpiece() -> None:
    values = judged(ContactForce(100.0), [0.0, 50.0, 100.0, 100.0], turned=9, error=0.5)
    assert values.holding_time == DT + 0.5 / 2.0


def test_a_force_that_leaves_the_band_at_the_end_is_not_held() -> None:
    assert judged(ContactForce(100.0), [0.0, 98.0, 101.0, 106.0], turned=9).holding_time == math.inf


def test_an_overshoot_beyond_what_is_allowed_is_not_held() -> None:
    forces = [0.0, 106.0, 100.0, 100.0]
    assert judged(ContactForce(100.0), forces, turned=9).holding_time == DT
    assert judged(ContactForce(100.0, allowed_overshoot=0.05), forces, turned=9).holding_time == math.inf


def test_bounces_are_losses_of_contact_before_the_demand_turns() -> None:
    assert (
        judged(ContactForce(100.0), [0.0, 60.0, 0.0, 70.0, 1.0, 100.0, 0.0, 50.0, 0.0], turned=6).bounces
        == 2.0
    )


def test_without_contact_nothing_is_held() -> None:
    assert judged(ContactForce(100.0), [0.0, 4.0, 5.0], turned=9) == (0.0, math.inf, 0.0)


def test_the_force_must_be_given() -> None:
    with pytest.raises(ParameterError, match="force"):
        checked(ContactForce())
