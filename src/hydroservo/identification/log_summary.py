"""A log as it is understood, in few words: its signals and their ranges, its rate and its gaps."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from hydroservo.formatting import scales_of
from hydroservo.identification.segments import Understood
from hydroservo.identification.signals import SIGNALS, TIME


def log_summary(whole: Understood) -> dict[str, Any]:
    """The log as nested tables, in SI units."""
    signals = {TIME: whole.log.time, **whole.log.signals}
    return {
        "log": whole.log.name,
        "signals": {name: about(whole, name, values) for name, values in signals.items()},
        "period": float(np.median([one.period for one in whole.segments])),
        "stretches": [
            {"from": one.start, "to": float(one.time[-1]), "samples": one.samples} for one in whole.segments
        ],
        "unused": list(whole.log.unused),
        "remarks": list(whole.remarks),
    }


def about(whole: Understood, name: str, values: "np.ndarray[Any, np.dtype[np.float64]]") -> dict[str, Any]:
    """The column of a signal, and its range where it has samples."""
    samples = values[np.isfinite(values)]
    ends = {"lowest": float(samples.min()), "highest": float(samples.max())} if samples.size else {}
    column = whole.log.columns.get(name, "")
    return {"column": column, "unit": SIGNALS[name].unit, "samples": int(samples.size), **ends}


def signal_rows(summary: Mapping[str, Any]) -> list[list[str]]:
    """Of each signal its name, column and number of samples, the lowest and the highest, and their unit."""
    rows = []
    signals = summary["signals"]
    ends = {name: [one[key] for key in ("lowest", "highest") if key in one] for name, one in signals.items()}
    scales = scales_of((one["unit"], ends[name]) for name, one in signals.items())
    for name, one in signals.items():
        scale = scales[one["unit"]]
        shown = [f"{scale.of(end):.4g}" for end in ends[name]] or ["", ""]
        rows.append([name, one["column"], str(one["samples"]), *shown, scale.label])
    return rows


def rate_lines(summary: Mapping[str, Any]) -> list[str]:
    """How often it is sampled, and where it has gaps."""
    period, stretches = summary["period"], summary["stretches"]
    rate = f"a sample every {1e3 * period:.6g} ms ({1.0 / period:.6g} Hz)"
    if len(stretches) == 1:
        return [f"{rate}, without a gap of more than a few samples"]
    spans = (f"{one['from']:.4g} to {one['to']:.4g} s" for one in stretches)
    return [rate, f"{len(stretches)} stretches between gaps: {', '.join(spans)}"]
