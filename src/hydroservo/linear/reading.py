"""How margins and bandwidths are called, and in which unit they are read."""

import math

from hydroservo.formatting import number
from hydroservo.linear.onset import MOST

READ = {
    "gain_margin": ("gain margin", "dB"),
    "phase_margin": ("phase margin", "\N{DEGREE SIGN}"),
    "delay_margin": ("delay margin", "ms"),
    "disk_margin": ("disk margin", ""),
    "sensitivity_peak": ("sensitivity peak", "dB"),
    "oscillation_gain": ("oscillates from", "onset"),
    "bandwidth": ("bandwidth, \N{MINUS SIGN}3 dB", "Hz"),
    "bandwidth_90": ("bandwidth, \N{MINUS SIGN}90\N{DEGREE SIGN}", "Hz"),
}
FACTORS = {"\N{DEGREE SIGN}": 180.0 / math.pi, "ms": 1e3}


def read_as(value: float, unit: str, missing: str) -> str:
    """A number in the unit in which it is read.

    Args:
        value: in SI units; a ratio where the unit is dB, a factor on the gain where it is
            "onset", a frequency in Hz.
        unit: of those in ``READ``.
        missing: what stands for nan.
    """
    if math.isnan(value):
        return missing
    if unit == "onset" and value in (1.0, math.inf):
        return "as it stands" if value == 1.0 else f"none up to {MOST:g} dB"
    if unit == "onset":
        unit = "dB"
    if unit == "dB":
        shown = 20.0 * math.log10(value) if value > 0.0 else -math.inf
    else:
        shown = FACTORS.get(unit, 1.0) * value
    return f"{number(shown)} {unit}".strip()
