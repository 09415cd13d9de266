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
HELD = ContactForce(100.0)


def contact_values(
    monitor: ContactForce, forces: Sequence[float], demands: Sequence[float] = (), error: float = 0.0
) -> Any:
    """What it makes of forces DT apart; the demand goes on unless it is given, and is ahead by an error."""
    m = monitor.init()
    demands = demands or [0.5 * k for k in range(len(forces))]
    for k, (force, demand) in enumerate(zip(forces, demands, strict=True)):
        rate = (demands[k] - demands[k - 1]) / DT if k else 0.0
        controlled = SimpleNamespace(value=demand - error)
        s: Any = SimpleNamespace(force=force, reference=Demand(demand, rate, 0.0), controlled=controlled)
        m = monitor.step(m, LOOP, s, k * DT, DT if k < len(forces) - 1 else 0.0)
    return monitor.values(m)


def test_the_force_that_is_held() -> None:
    """Contact at the third instant, in the band of 5 % from the sixth on; after the turn nothing counts."""
    forces = [0.0, 4.0, 30.0, 112.0, 94.0, 96.0, 103.0, 500.0, 0.0]
    demands = [0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0, 2.0, 1.0]
    assert contact_values(HELD, forces, demands) == pytest.approx((0.12, 3 * DT, 0.0))


def test_a_demand_that_jumps_back_releases_too() -> None:
    values = contact_values(HELD, [0.0, 50.0, 100.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0, 0.0])
    assert values == pytest.approx((0.0, DT, 0.0))


def test_the_time_to_hold_begins_where_the_demand_meets_the_workpiece() -> None:
    """By its largest rate, 4, of which an error of 0.25 is a sixteenth; at rest too; not before the start."""
    forces = [0.0, 50.0, 100.0, 100.0]
    assert contact_values(HELD, forces, error=0.25).holding_time == DT + 0.25 / 4.0
    late = [0.0, 0.0, 50.0, 100.0, 100.0]
    assert contact_values(HELD, late, [0.0, 0.5, 0.5, 0.5, 0.5], error=0.25).holding_time == DT + 0.25 / 4.0
    assert contact_values(HELD, forces, error=1e3).holding_time == 2 * DT


def test_a_force_that_is_held_at_once_takes_no_time() -> None:
    assert contact_values(HELD, [0.0, 100.0, 100.0]).holding_time == 0.0


def test_a_force_that_leaves_the_band_at_the_end_is_not_held() -> None:
    assert contact_values(HELD, [0.0, 98.0, 101.0, 106.0]).holding_time == math.inf


def test_an_overshoot_beyond_what_is_allowed_is_not_held() -> None:
    forces = [0.0, 106.0, 100.0, 100.0]
    assert contact_values(HELD, forces).holding_time == DT
    assert contact_values(HELD._replace(allowed_overshoot=0.05), forces).holding_time == math.inf


def test_bounces_are_losses_of_contact_before_the_demand_turns() -> None:
    forces = [0.0, 60.0, 0.0, 70.0, 1.0, 100.0, 0.0, 50.0, 0.0]
    demands = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 4.0, 3.0, 2.0]
    assert contact_values(HELD, forces, demands).bounces == 2.0


def test_without_contact_nothing_is_known_to_be_good() -> None:
    assert contact_values(HELD, [0.0, 4.0, 5.0]) == (math.inf, math.inf, math.inf)


def test_the_force_must_be_given() -> None:
    with pytest.raises(ParameterError, match="force"):
        checked(ContactForce())
