"""What a run's command does between the samples that were recorded."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from hydroservo.core.formatting import quantity

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

    Args:
        data: a run, as a Dataset or a Trace; nothing is said of one without the command or its metrics.
        period: of the samples [s].

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
    """That recorded samples hide how the command alternates, and what to do; else empty.

    Args:
        data: a run, as a Dataset or a Trace.
        period: of the samples [s].
    """
    found = unrecorded_command(data, period)
    if not found.change:
        return ""
    return (
        f"the record hides a fast motion: the command changes by {quantity(found.change, 'V')} a sample, "
        f"recorded samples by {quantity(found.recorded_change, 'V')}; simulation.record_period = "
        f'"{period!r} s" records each sample'
    )
