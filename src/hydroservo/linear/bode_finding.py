"""What frequency responses say."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.formatting import NONE, brief, number, quantity, scale_of
from hydroservo.linear.measured_margins import measured_margins
from hydroservo.linear.reading import READ, margins_table, read_as, verdict
from hydroservo.linear.trusted import says
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.provenance import origin_of
from hydroservo.runs.titles import controller_title
from hydroservo.show import Finding, Line, Picture
from hydroservo.show.finding import logs_of, title_of

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.figures.style import Plot

RESPONSES = ("machine", "open", "closed", "sensitivity", "compliance", "open_compliance")
RECORDED = ("machine", "closed")
COHERENT = 0.95  # of a log, from which a response counts as heard
CAPTION = (
    "Magnitude, phase and coherence. Lines: the linear model. Dots, where there are any: measured, pale "
    f"where the coherence is below {COHERENT}."
)


def bode_finding(data: "xr.Dataset", scenario: str = "", logs: Sequence[Path] = ()) -> Finding:
    """What frequency responses say, of one point or several.

    Args:
        data: what ``bode`` returned.
        scenario: its name, if it has one.
        logs: files of what was recorded, if anything.
    """
    margins = [{name: one[name].item() for name in ("stable", *READ)} for one in points_of(data)]
    return Finding(
        title_of("Frequency response", scenario or controller_title(data)),
        [*verdict(margins), *in_short(data), *measured_lines(data), *log_lines(data)],
        warnings_of(data),
        [margins_table(headings(data), margins)],
        [Picture("bode", CAPTION, lambda: drawn(data))],
        numbers_of(data, scenario),
        origins=[origin_of(scenario, data.attrs)],
        logs=logs_of(logs),
    )


def drawn(data: "xr.Dataset") -> "Plot":
    from hydroservo.figures.bode import plot_bode

    return plot_bode(data)


def points_of(data: "xr.Dataset") -> "list[xr.Dataset]":
    """What is known about each point."""
    return [data.isel(point=i) for i in range(data.sizes["point"])] if "point" in data.dims else [data]


def headings(data: "xr.Dataset") -> list[str]:
    """What each point is called, and before that what differs between them."""
    if "point" not in data.dims:
        return ["quantity", "value"]
    values = data["point"].values.tolist()
    scale = scale_of(values, data["point"].attrs["units"])
    points = [f"{brief(scale.of(value))} {scale.label}".strip() for value in values]
    return [data["point"].attrs["long_name"], *points]


def in_short(data: "xr.Dataset") -> list[Line]:
    """The margins of one point as far as it has any, or what varied over several."""
    if "point" in data.dims:
        values, about = data["point"].values, data["point"].attrs
        low, high = (quantity(float(values[end]), about["units"]) for end in (0, -1))
        return [Line(f"{len(values)} values of {about['long_name']}, from {low} to {high}.")]
    known = [name for name in ("gain_margin", "phase_margin", "bandwidth") if data[name].notnull()]
    margins = ", ".join(read(name, float(data[name])) for name in known)
    gain = float(data["oscillation_gain"])
    onset = "" if np.isnan(gain) or gain == 1.0 else f"the loop {says(gain)}"
    text = "; ".join(filter(None, [margins, onset]))
    return [Line(f"{text[0].upper()}{text[1:]}.")] if text else []


def read(name: str, value: float) -> str:
    label, unit = READ[name]
    return f"{label.partition(',')[0]} {read_as(value, unit, NONE)}"


def measured_lines(data: "xr.Dataset") -> list[Line]:
    """How coherent the measurement is, and the margins that it tells, or why it tells none."""
    if "tone" not in data.coords:
        return []
    least = {name: float(data[f"{name}_coherence"].min()) for name in ("open", "closed", "compliance")}
    coherence = ", ".join(f"{name} {value:.3f}" for name, value in least.items())
    margins = ", ".join(
        f"{read(name, one.margin)} ({one.remark or f'at {number(one.frequency)} Hz'})"
        for name, one in zip(("gain_margin", "phase_margin"), measured_margins(data), strict=True)
    )
    return [
        Line(f"Measured: {margins}."),
        Line(f"Measured at {data.sizes['tone']} frequencies; least coherence: {coherence}."),
    ]


def log_lines(data: "xr.Dataset") -> Iterator[Line]:
    """Where each log tells a response."""
    for log in numbers_of_logs(data):
        for name in filter(log.__contains__, RECORDED):
            pairs = zip(log[name]["frequency"], log[name]["coherence"], strict=True)
            heard = [frequency for frequency, coherence in pairs if coherence > COHERENT]
            band = f"{number(min(heard))} to {number(max(heard))} Hz" if heard else "none"
            yield Line(f"{log['log']}: {name}, coherence above {COHERENT}: {band}.")


def numbers_of(data: "xr.Dataset", scenario: str) -> dict[str, Any]:
    """All numbers of frequency responses; of several points a list of those of each."""
    about = {"logs": numbers_of_logs(data), "warnings": warnings_of(data)}
    if "point" not in data.dims:
        return {"scenario": scenario, "hash": data.attrs["hash"], **numbers_at(data), **about}
    name, unit = data["point"].attrs["long_name"], data["point"].attrs["units"]
    points = [{"value": one["point"].item(), **numbers_at(one)} for one in points_of(data)]
    return {"scenario": scenario, "varied": name, "unit": unit, "points": points, **about}


def numbers_at(data: "xr.Dataset") -> dict[str, Any]:
    """The numbers and the responses about one point."""
    numbers = {str(name): one.values.tolist() for name, one in data.data_vars.items() if not is_curve(one)}
    curves = {}
    for name in RESPONSES:
        curves[name] = curve(data["frequency"], data[name]) | {"unit": data[name].attrs["units"]}
        if f"{name}_measured" in data:
            coherence = data[f"{name}_coherence"].values.tolist()
            curves[name]["measured"] = curve(data["tone"], data[f"{name}_measured"]) | {
                "coherence": coherence
            }
    return {"command": data.attrs.get("command"), "force": data.attrs.get("force"), **numbers, **curves}


def numbers_of_logs(data: "xr.Dataset") -> list[dict[str, Any]]:
    """What each log tells, by the name of the response."""
    names = data["log"].values if "log" in data.coords else np.array([], dtype=object)
    return [{"log": log, **responses_in(data, names == log)} for log in dict.fromkeys(names.tolist())]


def responses_in(data: "xr.Dataset", of_log: NDArray[np.bool_]) -> dict[str, Any]:
    """The responses that one log tells, by name."""
    responses = {}
    for name in RECORDED:
        own = data.isel(recorded=np.flatnonzero(of_log & data[f"{name}_recorded_coherence"].notnull()))
        if own.sizes["recorded"]:
            coherence = own[f"{name}_recorded_coherence"].values.tolist()
            responses[name] = curve(own["recorded"], own[f"{name}_recorded"]) | {"coherence": coherence}
    return responses


def is_curve(one: "xr.DataArray") -> bool:
    return bool({"frequency", "tone", "recorded"} & set(one.dims))


def curve(frequencies: "xr.DataArray", response: "xr.DataArray") -> dict[str, Any]:
    """A response as sizes and phases [rad], over frequencies [Hz]."""
    return {
        "frequency": frequencies.values.tolist(),
        "magnitude": np.abs(response.values).tolist(),
        "phase": np.unwrap(np.angle(response.values)).tolist(),
    }
