"""Whether a friction that should hold has let the piston creep."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from hydroservo.control.loop import Loop
from hydroservo.core.formatting import quantity
from hydroservo.machine.mechanics import LuGre

HELD = 0.95  # of what sliding takes, up to which bristles hold
LONGEST = 5.0  # times the bristles' deflection in sliding, beyond which a motion is not their bending
FEWEST = 8  # samples, which one swing of the bristles does not span


def creep_caution(loop: Loop, data: Mapping[Any, Any]) -> str:
    """That the piston moved far while the bristles of a LuGre friction held it; else empty.

    Args:
        loop: the loop.
        data: a run of it, with its machine's states.

    Fails to see creep where the run moves past breakaway again and again.
    """
    friction = getattr(loop.plant, "friction", None)
    if not isinstance(friction, LuGre):
        return ""
    position, velocity = (np.asarray(data[f"plant.{name}"]) for name in ("position", "velocity"))
    ratio = velocity / friction.stribeck_velocity
    fallen = 1.0 - np.exp(-np.minimum(ratio**2, 700.0))
    sliding = friction.breakaway - (friction.breakaway - friction.coulomb) * fallen
    pull = friction.bristle_stiffness * np.abs(np.asarray(data["plant.friction.deflection"]))
    way = longest_way(position, pull < HELD * sliding)
    if way <= LONGEST * friction.breakaway / friction.bristle_stiffness:
        return ""
    return (
        f"the piston crept by {quantity(way, 'm')} under forces that its friction holds: LuGre drifts where "
        "a force varies below breakaway; ElastoPlastic and Stribeck hold it"
    )


def longest_way(position: np.ndarray, holds: np.ndarray) -> float:
    """How far the piston gets in a stretch of samples in which it is held [m]."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], holds, [False]]).astype(int)))
    stretches = zip(ends[::2], ends[1::2], strict=True)
    ways = (abs(position[b - 1] - position[a]) for a, b in stretches if b - a >= FEWEST)
    return float(max(ways, default=0.0))
