"""Figures 3 to 10 of the paper, redrawn from the reproduction's own runs."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import xarray as xr

from hydroservo.figures.panels import Curve, Panel, Samples, Trace, panel_figure, trace_of
from hydroservo.figures.style import COLOURS, Plot, style
from hydroservo.papers.tsmc_eha_2021.conditions import CONTROLLERS
from hydroservo.papers.tsmc_eha_2021.report.captions import (
    CAPTIONS,
    CLOSE,
    SHORT,
    WHOLE,
    seen_errors,
    seen_estimates,
    seen_surfaces,
    seen_velocities,
)
from hydroservo.papers.tsmc_eha_2021.report.names import NAMES, Trajectories
from hydroservo.papers.tsmc_eha_2021.study import Progress
from hydroservo.show.page import write_figure

LAW_COLOURS = {"pi": COLOURS["PI"], "backstepping": COLOURS["Backstepping"], "tsmc": COLOURS["TSMC"]}

# A wide curve shows on both sides of a narrow one on it.
WIDTHS = {"pi": 2.4, "backstepping": 1.2, "tsmc": 1.0}
TRUTH = "#a8a8a8"


class PaperFigure(NamedTuple):
    """One figure: what it shows, how it is drawn, and what its numbers say."""

    number: int
    caption: str
    draw: Callable[[Trajectories], Plot]
    seen: Callable[[Trajectories], str]


def draw_figures(
    trajectories: Trajectories, out: Path, origin: str, progress: Progress | None = None
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


def velocities(trajectories: Trajectories, demand: str) -> Plot:
    """The three velocities: whole run, start or jump, and from close by what lies on one another."""
    traces = traces_of(trajectories, demand)
    curves = [controller_curve(name, trace, trace.signal) for name, trace in traces.items()]
    longest = max(traces.values(), key=lambda trace: trace.time.size)
    curves.append(
        Curve("demand", longest.time, longest.demand, COLOURS["demand"], 0.8, "--", demand == "square")
    )
    panels = [Panel("velocity", "m/s", curves, window) for window in (WHOLE, SHORT[demand])]
    panels.append(Panel("velocity", "m/s", curves, CLOSE[demand], fitted=("PI", "TSMC", "demand")))
    return panel_figure(panels, "aab\naac", 4.0)


def errors(trajectories: Trajectories, demand: str) -> Plot:
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


def estimates(trajectories: Trajectories, demand: str) -> Plot:
    """Both estimates over the true disturbances; beside each what it misses, or how it follows a jump."""
    trace = trace_of(shown(trajectories, demand, "tsmc"))
    panels = []
    for i, unit in enumerate(("m/s^2", "N/s")):
        symbol = f"$d_{{L{i + 1}}}$"
        truth, estimate = trace.disturbances[i], trace.estimates[i]
        error = Curve("error", trace.time, estimate - truth, COLOURS["TSMC"])
        both = [
            Curve("true disturbance", trace.time, truth, TRUTH, 2.6),
            Curve("estimate", trace.time, estimate, COLOURS["TSMC"], 1.0),
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


def surfaces(trajectories: Trajectories, demand: str) -> Plot:
    """Both sliding surfaces and the command of TSMC."""
    dataset = shown(trajectories, demand, "tsmc")
    trace = trace_of(dataset)
    end = trace.time.size
    spiked = {"sine": r"$\xi_2$", "square": r"$\xi_1$"}[demand]
    panels = []
    for symbol, unit, values in (
        (r"$\xi_1$", "m/s", dataset["controller.xi1"].to_numpy()[:end]),
        (r"$\xi_2$", "m/s^2", dataset["controller.xi2"].to_numpy()[:end]),
        ("command $u$", "V", trace.command),
    ):
        curves = [Curve("TSMC", trace.time, values, COLOURS["TSMC"])]
        fitted = ["TSMC"] if symbol == spiked else []
        panels += [Panel(symbol, unit, curves, WHOLE, fitted), Panel(symbol, unit, curves, SHORT[demand])]
    return panel_figure(panels, "aab\nccd\neef", 5.4)


def traces_of(trajectories: Trajectories, demand: str) -> dict[str, Trace]:
    return {name: trace_of(shown(trajectories, demand, name)) for name in CONTROLLERS}


def shown(trajectories: Trajectories, demand: str, controller: str) -> xr.Dataset:
    """A run without its last sample, which lies on a jump of the square."""
    return trajectories[f"{demand}-{controller}"].isel(time=slice(-1))


def controller_curve(name: str, trace: Trace, values: Samples) -> Curve:
    return Curve(NAMES[name], trace.time, values, LAW_COLOURS[name], WIDTHS[name])


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
    paper_figure(3, "sine", velocities, seen_velocities),
    paper_figure(4, "sine", errors, seen_errors),
    paper_figure(5, "square", velocities, seen_velocities),
    paper_figure(6, "square", errors, seen_errors),
    paper_figure(7, "sine", estimates, seen_estimates),
    paper_figure(8, "square", estimates, seen_estimates),
    paper_figure(9, "sine", surfaces, seen_surfaces),
    paper_figure(10, "square", surfaces, seen_surfaces),
)
"""The figures in the paper's order."""
