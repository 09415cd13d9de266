"""What a run's metrics say of the loop's behaviour, in sentences."""

import math
from collections.abc import Mapping

from hydroservo.control.monitors.cycles import GROWING
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.field import Field
from hydroservo.core.formatting import quantity

VAPOUR = 1e4  # [Pa] absolute, down to which oil may lose air without losing its flow; chosen here
LONG = 0.01  # s of low pressure that are worth a sentence

Metrics = Mapping[str, float | bool]


def oscillates(metrics: Metrics) -> bool:
    """Whether a run ends in an oscillation that does not die out."""
    return metrics.get("oscillation_command", 0.0) > 0.0


def oscillation_note(metrics: Metrics) -> str:
    """A few words about a sustained oscillation, for a title; empty where there is none."""
    if not oscillates(metrics):
        return ""
    return f"oscillates at {quantity(metrics['oscillation_frequency'], 'Hz')}"


def behaviour(metrics: Metrics, fields: Mapping[str, Field]) -> list[str]:
    """Sentences about a run: oscillation, ringing, low pressure; none where it diverged.

    Args:
        metrics: by name, in SI units.
        fields: their declarations.
    """
    if metrics["diverged"]:
        return []
    return [line for line in (oscillation_line(metrics, fields), pressure_line(metrics)) if line]


def oscillation_line(metrics: Metrics, fields: Mapping[str, Field]) -> str:
    if "oscillation_command" not in metrics:
        return ""
    command, frequency = metrics["oscillation_command"], metrics["oscillation_frequency"]
    if math.isnan(command):
        short = "The run is too short to tell whether the loop settles or hunts slowly"
        return f"{short}; hydroservo audit runs it longer."
    growth = metrics["oscillation_growth"]
    if not oscillates(metrics):
        if math.isnan(frequency):
            return ""
        rings = f"The loop rings at {quantity(frequency, 'Hz')}"
        return f"{rings}; each cycle is {abs(growth):.0%} smaller than the last."
    unit = fields["oscillation_amplitude"].unit
    signal = quantity(metrics["oscillation_amplitude"], unit)
    sizes = f"{signal} in the controlled signal and {quantity(command, 'V')} in the command"
    if growth > GROWING:
        return f"The loop oscillates at {quantity(frequency, 'Hz')} and still grows: {sizes} so far."
    return f"The loop oscillates for good at {quantity(frequency, 'Hz')}: {sizes}."


def pressure_line(metrics: Metrics) -> str:
    """That a chamber cavitates, or that air leaves its oil; empty where its pressure stays above."""
    time, lowest = metrics.get("low_pressure_time", 0.0), metrics.get("pressure_min", 0.0)
    if lowest < -ATMOSPHERE:
        return (
            f"A chamber is below absolute zero: its pressure falls to {quantity(lowest, 'Pa')}, where real "
            "oil cavitates, so that the run cannot be trusted."
        )
    if lowest <= VAPOUR - ATMOSPHERE:
        return f"A chamber cavitates: its pressure falls to {quantity(lowest, 'Pa')}, nearly a vacuum."
    if not (time > LONG and lowest < 0.0):
        return ""
    return (
        f"A chamber is below atmospheric pressure for {quantity(time, 's')}: it falls to "
        f"{quantity(lowest, 'Pa')}, where air leaves the oil."
    )
