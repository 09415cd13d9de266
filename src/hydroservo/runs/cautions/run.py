"""What is doubtful of a run: creep, pressures below vacuum, and motions that its record hides."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from hydroservo.control.loop import Loop
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.formatting import quantity
from hydroservo.machine.mechanics import LuGre

HELD = 0.95  # of what sliding takes, up to which bristles hold
LONGEST = 5.0  # times the bristles' deflection in sliding, beyond which a motion is not their bending
FEWEST = 8  # samples, which one swing of the bristles does not span


def creep_caution(loop: Loop, data: Mapping[Any, Any]) -> str:
    """That the piston moved far while the bristles of a LuGre friction held it; else empty.

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


def pressure_caution(data: Mapping[Any, Any]) -> str:
    """That a chamber's pressure fell below absolute zero, in a run or in some of many; else empty."""
    if "pressure_min" not in data:
        return ""
    lost = np.isfinite(data["diverged_at"])  # what overflows passes every pressure
    lowest = np.where(lost, np.nan, data["pressure_min"])
    below = np.atleast_1d(lowest < -ATMOSPHERE)
    if not below.any():
        return ""
    where = "" if lowest.ndim == 0 else f" in {below.sum():,} of {below.size:,} runs"
    return (
        f"the pressure in a chamber fell to {1e-5 * np.nanmin(lowest):.3g} bar{where}, below absolute "
        f"zero ({-1e-5 * ATMOSPHERE:.3g} bar gauge): real oil cavitates before that, as an AeratedOil does"
    )


COMMAND = "controller.u"
NEEDED = (COMMAND, "control_total_variation", "control_rms", "control_max")
HIDDEN = 0.5  # noise changes as much between recorded samples as between neighbours, a smooth command more
VISIBLE = 0.01  # of the rms command: about the width of the line that draws it
HIGHER = 1.1  # times the recorded peak


class Unrecorded(NamedTuple):
    """What the record of a command does not show [V]; 0 where it shows all that matters."""

    change: float = 0.0  # mean |u_k - u_(k-1)|, where it is more than recorded samples let one see
    recorded_change: float = 0.0  # the same of recorded samples
    peak: float = 0.0  # largest |u|, where it is higher than all that was recorded


def unrecorded_command(data: Mapping[Any, Any], period: float) -> Unrecorded:
    """What the command does between recorded samples that these do not let one guess.

    Recorded samples hide how it alternates where neighbours among them differ, on average, by less than half
    of what neighbours among all samples do. White noise, whose samples do not know each other, differs by as
    much in both; a smooth command by more in the record.

    Fails where the command alternates in a small part of the run alone.
    """
    if any(name not in data for name in NEEDED):
        return Unrecorded()
    variation, rms, largest = (float(data[name]) for name in NEEDED[1:])
    command = np.asarray(data[COMMAND])
    command = command[np.isfinite(command)]
    if command.size < 2 or not np.isfinite([variation, rms, largest]).all():
        return Unrecorded()
    step, lost = float(data["time"][1]), float(data["diverged_at"])
    if step < 1.5 * period:
        return Unrecorded()
    samples = (lost if np.isfinite(lost) else float(data["time"][-1])) / period
    change = variation / max(samples, 1.0)
    recorded = float(np.mean(np.abs(np.diff(command))))
    hidden = change > VISIBLE * rms and recorded < HIDDEN * change
    higher = largest > HIGHER * float(np.abs(command).max())
    return Unrecorded(change * hidden, recorded * hidden, largest * higher)


def record_caution(data: Mapping[Any, Any], period: float) -> str:
    """That recorded samples hide how the command alternates, and what to do; else empty."""
    found = unrecorded_command(data, period)
    if not found.change:
        return ""
    return (
        f"the record hides a fast motion: the command changes by {quantity(found.change, 'V')} a sample, "
        f"recorded samples by {quantity(found.recorded_change, 'V')}; simulation.record_period = "
        f'"{period!r} s" records each sample'
    )


def run_cautions(loop: Loop, data: Mapping[Any, Any]) -> list[str]:
    """Lines about a run, with its machine's states, that a user should know; empty ones among them."""
    period = loop.simulation.period
    return [pressure_caution(data), creep_caution(loop, data), record_caution(data, period)]
