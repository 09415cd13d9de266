"""What frequency responses and linear models say."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.command_scale import in_command_unit
from hydroservo.core.formatting import NONE, brief, number, quantity, scale_of, superscripts
from hydroservo.linear.margins import (
    MARGIN_LABELS,
    formatted_margin,
    margins_table,
    onset_phrase,
    stability_lines,
)
from hydroservo.linear.measurement import measured_margins
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.provenance import origin_of, origin_of_loop
from hydroservo.runs.run_finding import controller_title
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import logs_in, title_of

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.figures.style import Plot
    from hydroservo.linear.linearization import Linearization, Quantity
    from hydroservo.linear.textbook import Textbook

RESPONSES = ("machine", "open", "closed", "sensitivity", "compliance", "open_compliance")
RECORDED = ("machine", "closed")
COHERENT = 0.95  # of a log, from which a response counts as heard
BODE_CAPTION = (
    "Magnitude, phase and coherence. Lines: the linear model. Dots, where there are any: measured, pale "
    f"where the coherence is below {COHERENT}."
)
POLES_CAPTION = "Poles, with lines of equal damping; those that are not stable are red."
STEADY = "Gains from each input to each output once all has settled."
ENDLESS = "\N{INFINITY}: an output that the input moves on and on."
INEXACT_LINE = Line(
    "Some derivatives come from differences", ", where there is no slope: see the last table.", Mark.DOUBTFUL
)
GUESSES = "Derivatives from differences, in SI units."


def bode_finding(data: "xr.Dataset", scenario: str = "", logs: Sequence[Path] = ()) -> Finding:
    """What frequency responses say, of one point or several."""
    margins = [
        {name: one[name].item() for name in ("stable", *MARGIN_LABELS)} for one in point_datasets(data)
    ]
    return Finding(
        title_of("Frequency response", scenario or controller_title(data)),
        [*stability_lines(margins), *summary_lines(data), *measured_lines(data), *log_lines(data)],
        warnings_of(data),
        [margins_table(point_headings(data), margins)],
        [Picture("bode", BODE_CAPTION, lambda: draw_responses(data))],
        bode_numbers(data, scenario),
        origins=[origin_of(scenario, data.attrs)],
        logs=logs_in(logs),
    )


def draw_responses(data: "xr.Dataset") -> "Plot":
    from hydroservo.figures.bode import plot_bode

    return plot_bode(data)


def point_datasets(data: "xr.Dataset") -> "list[xr.Dataset]":
    """What is known about each point."""
    return [data.isel(point=i) for i in range(data.sizes["point"])] if "point" in data.dims else [data]


def point_headings(data: "xr.Dataset") -> list[str]:
    """What each point is called, and before that what differs between them."""
    if "point" not in data.dims:
        return ["quantity", "value"]
    values = data["point"].values.tolist()
    scale = scale_of(values, data["point"].attrs["units"])
    points = [f"{brief(scale.of(value))} {scale.label}".strip() for value in values]
    return [data["point"].attrs["long_name"], *points]


def summary_lines(data: "xr.Dataset") -> list[Line]:
    """The margins of one point as far as it has any, or what varied over several."""
    if "point" in data.dims:
        values, about = data["point"].values, data["point"].attrs
        low, high = (quantity(float(values[end]), about["units"]) for end in (0, -1))
        return [Line(f"{len(values)} values of {about['long_name']}, from {low} to {high}.")]
    known = [name for name in ("gain_margin", "phase_margin", "bandwidth") if data[name].notnull()]
    margins = ", ".join(margin_text(name, float(data[name])) for name in known)
    gain = float(data["oscillation_gain"])
    onset = "" if np.isnan(gain) or gain == 1.0 else f"the loop {onset_phrase(gain)}"
    text = "; ".join(filter(None, [margins, onset]))
    return [Line(f"{text[0].upper()}{text[1:]}.")] if text else []


def margin_text(name: str, value: float) -> str:
    label, unit = MARGIN_LABELS[name]
    return f"{label.partition(',')[0]} {formatted_margin(value, unit, NONE)}"


def measured_lines(data: "xr.Dataset") -> list[Line]:
    """How coherent the measurement is, and the margins that it tells, or why it tells none."""
    if "tone" not in data.coords:
        return []
    least = {name: float(data[f"{name}_coherence"].min()) for name in ("open", "closed", "compliance")}
    coherence = ", ".join(f"{name} {value:.3f}" for name, value in least.items())
    margins = ", ".join(
        f"{margin_text(name, one.margin)} ({one.remark or f'at {number(one.frequency)} Hz'})"
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


def bode_numbers(data: "xr.Dataset", scenario: str) -> dict[str, Any]:
    """All numbers of frequency responses; of several points a list of those of each."""
    about = {"logs": numbers_of_logs(data), "warnings": warnings_of(data)}
    if "point" not in data.dims:
        return {"scenario": scenario, "hash": data.attrs["hash"], **numbers_at(data), **about}
    name, unit = data["point"].attrs["long_name"], data["point"].attrs["units"]
    points = [{"value": one["point"].item(), **numbers_at(one)} for one in point_datasets(data)]
    return {"scenario": scenario, "varied": name, "unit": unit, "points": points, **about}


def numbers_at(data: "xr.Dataset") -> dict[str, Any]:
    """The numbers and the responses about one point."""
    over = {"frequency", "tone", "recorded"}
    numbers = {
        str(name): row.values.tolist() for name, row in data.data_vars.items() if not over & {*row.dims}
    }
    curves = {}
    for name in RESPONSES:
        curves[name] = curve_numbers(data["frequency"], data[name]) | {"unit": data[name].attrs["units"]}
        if f"{name}_measured" in data:
            coherence = data[f"{name}_coherence"].values.tolist()
            curves[name]["measured"] = curve_numbers(data["tone"], data[f"{name}_measured"]) | {
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
            responses[name] = curve_numbers(own["recorded"], own[f"{name}_recorded"]) | {
                "coherence": coherence
            }
    return responses


def curve_numbers(frequencies: "xr.DataArray", response: "xr.DataArray") -> dict[str, Any]:
    """A response as sizes and phases [rad], over frequencies [Hz]."""
    return {
        "frequency": frequencies.values.tolist(),
        "magnitude": np.abs(response.values).tolist(),
        "phase": np.unwrap(np.angle(response.values)).tolist(),
    }


def linearization_finding(
    model: "Linearization", scenario: str = "", book: "Textbook | None" = None
) -> Finding:
    """What a linear model says."""
    doubtful, inexact = ([INEXACT_LINE], [inexact_table(model)]) if model.inexact else ([], [])
    states = f"States: {', '.join(map(name_with_unit, model.states)) or 'none'}."
    return Finding(
        title_of(f"Linear model of the {model.unit}", scenario),
        [least_damped(model), *textbook_line(book), *doubtful, Line(states, mark=Mark.QUIET)],
        [],
        [poles_table(model), steady_gains_table(model), *inexact],
        [Picture("poles", POLES_CAPTION, lambda: draw_poles(model))],
        linearization_numbers(model, scenario),
        origins=[origin_of_loop(scenario, model.loop)] if model.loop else [],
    )


def draw_poles(model: "Linearization") -> "Plot":
    from hydroservo.figures.bode import plot_poles

    return plot_poles(model)


def least_damped(model: "Linearization") -> Line:
    """The pair of poles that swings longest."""
    pairs = model.poles.imag > 0.0
    if not pairs.any():
        return Line("None of its poles swings.")
    which = np.flatnonzero(pairs)[np.argmin(model.damping[pairs])]
    frequency, damping = number(model.frequencies[which] / (2.0 * math.pi)), number(model.damping[which])
    pair = f"The least damped pair of its {len(model.poles)} poles"
    return Line(f"{pair} has {frequency} Hz and a damping ratio of {damping}.")


def textbook_line(book: "Textbook | None") -> list[Line]:
    if book is None:
        return []
    frequency, damping = number(book.natural_frequency / (2.0 * math.pi), 5), number(book.damping_ratio, 4)
    oil = f"{number(book.mass, 4)} kg on {number(1e-6 * book.stiffness, 4)} kN/mm of oil"
    return [Line(f"By the textbook's formulas: {frequency} Hz, damping ratio {damping} ({oil}).")]


def name_with_unit(one: "Quantity") -> str:
    unit = superscripts(in_command_unit(one.unit)[0])
    return f"{one.name} [{unit}]" if unit else one.name


def poles_table(model: "Linearization") -> Table:
    """The poles; of a pair one."""
    time = f"sampled every {quantity(model.period, 's')}" if model.period else "in continuous time"
    name, units = ("z", ("", "")) if model.period else ("s", ("1/s", "rad/s"))
    columns = (
        Column(f"Re {name}", units[0], digits=5),
        Column(f"± Im {name}", units[1], digits=5),
        Column("natural frequency", "Hz", digits=5),
        Column("damping ratio"),
    )
    each = zip(model.poles.tolist(), model.frequencies.tolist(), model.damping.tolist(), strict=True)
    rows = [
        [Cell(pole.real), Cell(pole.imag), Cell(frequency / (2.0 * math.pi)), Cell(damping)]
        for pole, frequency, damping in each
        if pole.imag >= 0.0
    ]
    return Table("poles", columns, rows, f"Poles of a model {time}, slowest first; of a pair one.")


def steady_gains_table(model: "Linearization") -> Table:
    """The steady gain of each output by each input."""
    inputs = [(one.name, *in_command_unit(one.unit)) for one in model.inputs]
    columns = [
        Column(f"by 1 {superscripts(unit)} of {name}" if unit else f"by {name}") for name, unit, _ in inputs
    ]
    rows = [
        [
            Cell(output.name),
            *(Cell(model.steady_gain(output.name, name) / factor, output.unit) for name, _, factor in inputs),
            Cell(),
        ]
        for output in model.outputs
    ]
    note = ENDLESS if any(cell.value in (math.inf, -math.inf) for row in rows for cell in row) else ""
    return Table("gains", (Column("output"), *columns, UNIT), rows, STEADY, note)


def inexact_table(model: "Linearization") -> Table:
    """The derivatives that are not exact."""
    columns = (Column("derivative"), Column("value"), Column("off by up to", digits=2))
    rows = [[Cell(f"{one.of} by {one.by}"), Cell(one.value), Cell(one.error)] for one in model.inexact]
    return Table("inexact", columns, rows, GUESSES)


def linearization_numbers(model: "Linearization", scenario: str) -> dict[str, Any]:
    """All numbers of a linear model, in SI units."""
    names = {what: [one.name for one in getattr(model, what)] for what in ("states", "inputs", "outputs")}
    units = {what: [one.unit for one in getattr(model, what)] for what in names}
    return {
        "scenario": scenario,
        "unit": model.unit,
        "period": model.period or None,
        **names,
        "units": units,
        **{name: getattr(model, name).tolist() for name in "ABCD"},
        "poles": [[pole.real, pole.imag] for pole in model.poles.tolist()],
        "frequencies": model.frequencies.tolist(),
        "damping": model.damping.tolist(),
        "inexact": [one._asdict() for one in model.inexact],
    }
