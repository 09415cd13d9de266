"""Figures 3 to 10 of the paper, redrawn from the reproduction's own runs, and what stands below them."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from hydroservo.control.metrics import METRIC_FIELDS
from hydroservo.core.formatting import measured, number, quantity
from hydroservo.figures import panels
from hydroservo.figures.panels import (
    Panel,
    PlottedRun,
    Samples,
    SignalCurve,
    TimeWindow,
    panel_figure,
    trace_of,
)
from hydroservo.figures.style import COLOURS, Plot, style
from hydroservo.papers.tsmc_eha_2021.claims import CONTROLLERS, run_outcome
from hydroservo.papers.tsmc_eha_2021.machine import AMPLITUDE, DURATION, PERIOD
from hydroservo.papers.tsmc_eha_2021.report.names import NAMES, Trajectories
from hydroservo.papers.tsmc_eha_2021.study import PaperProgress
from hydroservo.show.files import write_figure

START = 0.03  # [s] how much of the start from rest is shown
JUMP = 0.5 * PERIOD  # [s] the square's first
TROUGH = 0.75 * PERIOD  # [s] the sine's first

WHOLE = panels.WHOLE._replace(stop=DURATION)
SHORT = {
    "sine": TimeWindow("start", 0.0, START, label="time [ms]", factor=1e3, dots=True),
    "square": TimeWindow(
        f"jump at {JUMP:g} s", JUMP - 0.01, JUMP + 0.06, JUMP, "time after the jump [ms]", 1e3, dots=True
    ),
}
CLOSE = {
    "sine": TimeWindow("trough, close by", TROUGH - 0.1, TROUGH + 0.1),
    "square": TimeWindow("after the jump, close by", JUMP + 0.1, JUMP + 0.5 * PERIOD - 0.1),
}
VELOCITIES = "Piston velocity with the three controllers"
ERRORS = "Velocity errors of the three controllers"
ESTIMATES = "Lumped disturbances (grey) and their estimates by the observer of TSMC (green)"
SURFACES = "Sliding surfaces and command of TSMC"
READ = "Dots are recorded samples. What panels of the whole run cut off is named above them."

FIRST = f"first {1e3 * START:g} ms"
AT_JUMP = f"jump at {JUMP:g} s"
LAW_COLOURS = {"pi": COLOURS["PI"], "backstepping": COLOURS["Backstepping"], "tsmc": COLOURS["TSMC"]}

# A wide curve shows on both sides of a narrow one on it.
WIDTHS = {"pi": 2.4, "backstepping": 1.2, "tsmc": 1.0}
TRUTH = "#a8a8a8"


def caption(shown: str, demand: str, *panels: str) -> str:
    size, period = f"{1e3 * AMPLITUDE:g} mm/s", f"{PERIOD:g} s"
    return ". ".join((f"{shown}, {demand} demand of {size} amplitude and {period} period", *panels, READ))


CAPTIONS = {
    3: caption(
        VELOCITIES,
        "sine",
        "(a) Whole run",
        f"(b) {FIRST.capitalize()}",
        f"(c) Trough at {TROUGH:g} s, on a range for PI, TSMC and demand",
    ),
    4: caption(
        ERRORS,
        "sine",
        f"(a), (b) Whole run and {FIRST}, on a range for all three",
        "(c), (d) The same on a range for PI and TSMC",
    ),
    5: caption(
        VELOCITIES,
        "square",
        "(a) Whole run",
        f"(b) {AT_JUMP.capitalize()}",
        "(c) The level after that jump, on a range for PI, TSMC and demand",
    ),
    6: caption(
        ERRORS,
        "square",
        f"(a), (b) Whole run and {AT_JUMP}, on a range for all three",
        "(c), (d) The same on a range for the settled errors of PI and TSMC",
    ),
    7: caption(ESTIMATES, "sine", "(a), (c) Whole run", "(b), (d) Estimate less true disturbance"),
    8: caption(
        ESTIMATES,
        "square",
        "(a), (c) Whole run, on a range without the spikes at the jumps",
        f"(b), (d) {AT_JUMP.capitalize()}",
    ),
    9: caption(
        SURFACES,
        "sine",
        "(a), (c), (e) Whole run; ξ₂ on a range without its start",
        f"(b), (d), (f) {FIRST.capitalize()}",
    ),
    10: caption(
        SURFACES,
        "square",
        "(a), (c), (e) Whole run; ξ₁ on a range without the spikes at the jumps",
        f"(b), (d), (f) {AT_JUMP.capitalize()}",
    ),
}
"""By the figure's number."""


def seen_velocities(trajectories: Trajectories, demand: str) -> str:
    """How closely the three velocities follow a sine, or how fast and far they leave a square's jump."""
    if demand == "sine":
        peak = float(np.max(np.abs(trajectories["sine-pi"]["reference.value"].to_numpy())))
        worst = ranking(trajectories, demand, "steady_max_error")
        return f"Largest error in the second half, under a demand of {quantity(peak, 'm/s')} peak: {worst}."
    settling = ranking(trajectories, demand, "settling_time")
    overshoot = ranking(trajectories, demand, "overshoot")
    return (
        f"{METRIC_FIELDS['settling_time'].meaning.capitalize()} ({JUMP:g} s: not before the next jump): "
        f"{settling}. "
        f"Furthest beyond the demand in the direction of its last jump: {overshoot}."
    )


def seen_errors(trajectories: Trajectories, demand: str) -> str:
    """The three rms errors."""
    run = ranking(trajectories, demand, "rms_error")
    steady = ranking(trajectories, demand, "steady_rms_error")
    return f"Rms error over the whole run: {run}. In the second half: {steady}."


def seen_estimates(trajectories: Trajectories, demand: str) -> str:
    """What both estimates miss of what they estimate."""
    run = trajectories[f"{demand}-tsmc"]
    parts = []
    for i in (1, 2):
        miss, size = float(run[f"estimate_rms_error_{i}"]), float(run[f"disturbance_rms_{i}"])
        share = f"{number(100.0 * miss / size)} % of " if size > 0.0 else "against "
        parts.append(
            f"The estimate of d_L{i} misses by {measured(run, f'estimate_rms_error_{i}')} rms, {share}"
            f"the disturbance's {measured(run, f'disturbance_rms_{i}')} rms (second half); "
            f"the disturbance peaks at {measured(run, f'disturbance_max_{i}')}."
        )
    return " ".join(parts)


def seen_surfaces(trajectories: Trajectories, demand: str) -> str:
    """How close to zero the surfaces stay, and what command that takes."""
    run = trajectories[f"{demand}-tsmc"]
    settled = run_outcome(run, demand).settled
    return (
        f"Once settled |ξ₁| stays within {quantity(settled['xi1'], 'm/s')} and |ξ₂| within "
        f"{quantity(settled['xi2'], 'm/s^2')}. The command is {measured(run, 'control_rms')} rms, at most "
        f"{measured(run, 'control_max')}, and its changes add up to "
        f"{measured(run, 'control_total_variation')}."
    )


def ranking(trajectories: Trajectories, demand: str, metric: str) -> str:
    """The three controllers with one metric, the smallest first."""
    runs = {name: trajectories[f"{demand}-{name}"] for name in CONTROLLERS}

    def rank(name: str) -> float:
        value = float(runs[name][metric])
        return value if math.isfinite(value) else math.inf

    return ", ".join(f"{NAMES[name]} {measured(runs[name], metric)}" for name in sorted(runs, key=rank))


class PaperFigure(NamedTuple):
    """One figure: what it shows, how it is drawn, and what its numbers say."""

    number: int
    caption: str
    draw: Callable[[Trajectories], Plot]
    seen: Callable[[Trajectories], str]


def draw_figures(
    trajectories: Trajectories, out: Path, origin: str, progress: PaperProgress | None = None
) -> list[Path]:
    """Write ``fig03`` to ``fig10`` as PNG and SVG."""
    written = []
    for done, one in enumerate(FIGURES, 1):
        with style():
            fig = one.draw(trajectories)
        written += write_figure(fig, out / f"fig{one.number:02d}", origin)
        if progress is not None:
            progress(done, len(FIGURES), f"figure {one.number}")
    return written


def plot_velocities(trajectories: Trajectories, demand: str) -> Plot:
    """The three velocities: whole run, start or jump, and from close by what lies on one another."""
    traces = traces_of(trajectories, demand)
    curves = [controller_curve(name, trace, trace.signal) for name, trace in traces.items()]
    longest = max(traces.values(), key=lambda trace: trace.time.size)
    curves.append(
        SignalCurve("demand", longest.time, longest.demand, COLOURS["demand"], 0.8, "--", demand == "square")
    )
    panels = [Panel("velocity", "m/s", curves, window) for window in (WHOLE, SHORT[demand])]
    panels.append(Panel("velocity", "m/s", curves, CLOSE[demand], fitted=("PI", "TSMC", "demand")))
    return panel_figure(panels, "aab\naac", 4.0)


def plot_errors(trajectories: Trajectories, demand: str) -> Plot:
    """The three tracking errors, above on an axis for the largest, below on one for PI and TSMC."""
    traces = traces_of(trajectories, demand)
    curves = [controller_curve(name, trace, trace.error) for name, trace in traces.items()]
    panels = [
        Panel("error", "m/s", curves, window, fitted)
        for fitted in ((), ("PI", "TSMC"))
        for window in (WHOLE, SHORT[demand])
    ]
    if demand == "square":
        panels[3] = panels[3]._replace(range_of=WHOLE)
    return panel_figure(panels, "aab\nccd", 4.3)


def plot_estimates(trajectories: Trajectories, demand: str) -> Plot:
    """Both estimates over the true disturbances; beside each what it misses, or how it follows a jump."""
    trace = trace_of(shown_run(trajectories, demand, "tsmc"))
    panels = []
    for i, unit in enumerate(("m/s^2", "N/s")):
        symbol = f"$d_{{L{i + 1}}}$"
        truth, estimate = trace.disturbances[i], trace.estimates[i]
        error = SignalCurve("error", trace.time, estimate - truth, COLOURS["TSMC"])
        both = [
            SignalCurve("true disturbance", trace.time, truth, TRUTH, 2.6),
            SignalCurve("estimate", trace.time, estimate, COLOURS["TSMC"], 1.0),
        ]
        if demand == "sine":
            panels += [
                Panel(symbol, unit, both, WHOLE),
                Panel(f"error of {symbol}", unit, [error], WHOLE, ["error"]),
            ]
        else:
            fitted = [curve.label for curve in both]
            panels += [Panel(symbol, unit, both, WHOLE, fitted), Panel(symbol, unit, both, SHORT[demand])]
    return panel_figure(panels, "ab\ncd" if demand == "sine" else "aab\nccd", 4.2)


def plot_surfaces(trajectories: Trajectories, demand: str) -> Plot:
    """Both sliding surfaces and the command of TSMC."""
    dataset = shown_run(trajectories, demand, "tsmc")
    trace = trace_of(dataset)
    end = trace.time.size
    spiked = {"sine": r"$\xi_2$", "square": r"$\xi_1$"}[demand]
    panels = []
    for symbol, unit, values in (
        (r"$\xi_1$", "m/s", dataset["controller.xi1"].to_numpy()[:end]),
        (r"$\xi_2$", "m/s^2", dataset["controller.xi2"].to_numpy()[:end]),
        ("command $u$", "V", trace.command),
    ):
        curves = [SignalCurve("TSMC", trace.time, values, COLOURS["TSMC"])]
        fitted = ["TSMC"] if symbol == spiked else []
        panels += [Panel(symbol, unit, curves, WHOLE, fitted), Panel(symbol, unit, curves, SHORT[demand])]
    return panel_figure(panels, "aab\nccd\neef", 5.4)


def traces_of(trajectories: Trajectories, demand: str) -> dict[str, PlottedRun]:
    return {name: trace_of(shown_run(trajectories, demand, name)) for name in CONTROLLERS}


def shown_run(trajectories: Trajectories, demand: str, controller: str) -> xr.Dataset:
    """A run without its last sample, which lies on a jump of the square."""
    return trajectories[f"{demand}-{controller}"].isel(time=slice(-1))


def controller_curve(name: str, trace: PlottedRun, values: Samples) -> SignalCurve:
    return SignalCurve(NAMES[name], trace.time, values, LAW_COLOURS[name], WIDTHS[name])


def paper_figure(
    number: int,
    demand: str,
    draw: Callable[[Trajectories, str], Plot],
    seen: Callable[[Trajectories, str], str],
) -> PaperFigure:
    return PaperFigure(
        number, CAPTIONS[number], lambda runs: draw(runs, demand), lambda runs: seen(runs, demand)
    )


FIGURES = (
    paper_figure(3, "sine", plot_velocities, seen_velocities),
    paper_figure(4, "sine", plot_errors, seen_errors),
    paper_figure(5, "square", plot_velocities, seen_velocities),
    paper_figure(6, "square", plot_errors, seen_errors),
    paper_figure(7, "sine", plot_estimates, seen_estimates),
    paper_figure(8, "square", plot_estimates, seen_estimates),
    paper_figure(9, "sine", plot_surfaces, seen_surfaces),
    paper_figure(10, "square", plot_surfaces, seen_surfaces),
)
"""The figures in the paper's order."""
