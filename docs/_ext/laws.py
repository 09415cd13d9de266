"""What the pages of the laws side by side share: what each law needs, what it costs, and how it runs."""

import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from cells import table
from IPython.display import Markdown
from matplotlib.figure import Figure

import hydroservo as hs
from hydroservo.core.block import values
from hydroservo.figures.style import PALETTE, figure, style
from hydroservo.scenario.load import assemble

__all__ = ["LAWS", "elsewhere", "needs", "overview", "side_by_side"]

TARGET = Path(__file__).parents[1] / "target.md"
BEFORE, AFTER = 0.005, 0.04  # s, about the jump that is shown
MEAN = 20  # samples of an error that is shown, whose noise would hide it
GREY = "#aaaaaa"
COST = "instructions of a step, Cortex-M4F, single precision ({doc}`../target`)"

BOTH = "velocity, hydraulic force"
LAGGED = "the machine, at rest, and the valve's lag"
WHOLE = "the machine and the valve's lag"
NOISE = f"{WHOLE}; the noise of both sensors"


class Law(NamedTuple):
    """What is said of a law in words.

    Attributes:
        title: in a table's header.
        family: where it belongs.
        page: in this folder.
        measures: which signals it takes.
        knows: of the machine, by numbers that are not tuned.
    """

    title: str
    family: str
    page: str
    measures: str
    knows: str


LAWS = {
    "pi": Law("PI", "PID", "pi", "velocity", "nothing"),
    "industrial": Law("PID with feedforward and pressure feedback", "PID", "industry", BOTH, "nothing"),
    "adrc-1": Law("ADRC, order 1", "disturbance rejection", "adrc", "velocity", "nothing"),
    "adrc-2": Law("ADRC, order 2", "disturbance rejection", "adrc", "velocity", "the valve's lag"),
    "h-infinity": Law("H∞ loop shaping", "robust, linear", "h-infinity", "velocity", LAGGED),
    "lq": Law("LQ without offset", "linear quadratic", "linear-quadratic", BOTH, NOISE),
    "lqi": Law("LQI", "linear quadratic", "linear-quadratic", BOTH, WHOLE),
    "internal-model": Law(
        "Internal model",
        "linear quadratic",
        "internal-model",
        BOTH,
        f"{WHOLE}; the frequency of demand or load",
    ),
    "mpc": Law("Linear MPC", "linear quadratic", "predictive", BOTH, f"{NOISE}; the command's limits"),
    "linear": Law("Feedback linearisation", "inversion", "feedback-linearisation", BOTH, NOISE),
    "backstepping": Law("Backstepping", "inversion", "backstepping", BOTH, NOISE),
    "terminal": Law("Terminal", "sliding mode", "terminal", BOTH, NOISE),
    "fast-terminal": Law("Fast terminal", "sliding mode", "terminal", BOTH, NOISE),
    "nonsingular-terminal": Law("Nonsingular terminal", "sliding mode", "terminal", BOTH, NOISE),
    "homogeneous": Law("Homogeneous", "finite time", "terminal", BOTH, NOISE),
    "super-twisting": Law("Super-twisting", "sliding mode", "super-twisting", BOTH, NOISE),
    "rise": Law("RISE", "sliding mode", "super-twisting", BOTH, NOISE),
    "adaptive": Law(
        "Adaptive backstepping", "adaptive", "adaptive", BOTH, f"{WHOLE}; how far each term may be off"
    ),
    "adaptive-robust": Law(
        "Adaptive robust", "adaptive", "adaptive", BOTH, f"{WHOLE}; how far each term may be off"
    ),
    "adaptive-rbf": Law(
        "Radial basis", "adaptive", "adaptive", BOTH, f"{WHOLE}; the span of velocities, the largest weight"
    ),
}


def needs(*names: str) -> Markdown:
    """What the laws of a page need, a column each."""
    costs = instructions()
    rows: dict[str, list[str]] = {}
    for name in names:
        law, loop, gains = LAWS[name], hs.load_scenario(f"laws/{name}-sine"), searched(name)
        cost = costs.get(f"laws/{name}-sine")
        found = {
            "measures": law.measures,
            "knows": law.knows,
            "gains to tune": f"{len(gains)}: {', '.join(f'`{gain}`' for gain in gains)}",
            "state": f"{len(values(loop.controller.init()))} numbers",
            COST: cost or "not measured yet",
        }
        for key, text in found.items():
            rows.setdefault(key, []).append(text)
    return table(("", *(LAWS[name].title for name in names)), ((key, *cells) for key, cells in rows.items()))


def overview() -> Markdown:
    """All laws: family, page, what they measure, and how many gains were searched."""
    rows = (
        (f"`{name}`", law.title, law.family, f"{{doc}}`{law.page}`", law.measures, len(searched(name)))
        for name, law in LAWS.items()
    )
    return table(("`laws/...`", "law", "family", "page", "measures", "gains"), rows)


def searched(name: str) -> list[str]:
    """The last names of the numbers that a search sets."""
    ranges = assemble(f"laws/{name}-sine").search.ranges
    return [path.rpartition(".")[2] for path in ranges]


def instructions() -> dict[str, str]:
    """Of one step on a Cortex-M4F in single precision, by what the page about targets calls a controller."""
    text = TARGET.read_text(encoding="utf-8").partition("### Instructions")[2].partition("###")[0]
    header, *rows = (split(line) for line in text.splitlines() if line.startswith("| `") or "M4F" in line)
    place = header.index("Cortex-M4F, single")
    return {row[0].strip("`"): row[place] for row in rows}


def split(line: str) -> list[str]:
    return [cell.strip() for cell in re.split(r"\|", line)[1:-1]]


LOST = 0.03  # m/s, the demand's amplitude: an error of that size is no following


def elsewhere(*names: str) -> Markdown:
    """How laws and the PI law follow the square, with the gains they have, where the loop is another one."""
    rows = [(LAWS[name].title, *map(rms_error, elsewheres(name).values())) for name in ("pi", *names)]
    return table(("rms error on the square [mm/s]", *elsewheres("pi")), rows)


def elsewheres(name: str) -> Mapping[str, Any]:
    """A law's loop, and others: what the law is not told of the machine, or samples that come later."""
    scenario = f"laws/{name}-square"
    loop: Any = hs.load_scenario(scenario)
    softer = hs.load_scenario(scenario, {"uncertainty.scale": -1})
    lag, noise = loop.valve.time_constant, loop.sensors
    quick = {"valve.time_constant": 0.5 * lag}
    loud = {
        "sensors.velocity_noise": 4.0 * noise.velocity_noise,
        "sensors.hydraulic_force_noise": 4.0 * noise.hydraulic_force_noise,
    }
    return {
        "as searched": loop,
        "twice the mass": hs.replace(loop, {"plant.mass": 2.0 * loop.plant.mass}),
        "half the valve's lag": hs.replace(loop, quick),
        "half the lag, -Δ": hs.replace(softer, quick),
        "twice the lag": hs.replace(loop, {"valve.time_constant": 2.0 * lag}),
        "four times the noise": hs.replace(loop, loud),
        "three times the load": hs.replace(loop, {"load.amplitude": 3.0 * loop.load.amplitude}),
        "sampled at 2 ms": sampled_at(loop, 2),
        "sampled at 3 ms": sampled_at(loop, 3),
    }


def sampled_at(loop: Any, milliseconds: int) -> Any:
    """The loop with later samples, its machine followed in the same steps."""
    period, steps = 1e-3 * milliseconds, 10 * milliseconds
    return hs.replace(
        loop,
        {"simulation.period": period, "simulation.record_period": period, "simulation.substeps": steps},
    )


def rms_error(loop: Any) -> str:
    """In mm/s."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hs.HydroservoWarning)  # what runs away is too quick for any step
        error = float(hs.simulate(loop)["rms_error"])
    return f"{1e3 * error:.3g}" if error < LOST else "lost"


def side_by_side(*names: str) -> Figure:
    """Laws beside the PI law: their errors and commands on the sine, and about the jump of the square."""
    shown = [("pi", GREY), *zip(names, PALETTE, strict=False)]
    with style():
        fig = figure(height=3.6)
        grid = fig.subplots(2, 2, sharex="col", width_ratios=(1.25, 1.0))
        for name, colour in shown:
            draw(grid, name, {"color": colour, "linewidth": 0.9, "label": LAWS[name].title})
        labelled(grid)
        fig.align_ylabels(grid[:, 0])
        fig.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=len(shown))
    return fig


def draw(grid: np.ndarray, name: str, line: Mapping[str, Any]) -> None:
    """A law's four curves; of commands the calmer ones lie on top."""
    sine, square = (hs.simulate(hs.load_scenario(f"laws/{name}-{demand}")) for demand in ("sine", "square"))
    depth = 3.0 - 0.01 * float(sine["control_total_variation"])
    error = (sine["reference.value"] - sine["controlled.value"]).rolling(time=MEAN, center=True).mean()
    grid[0, 0].plot(sine["time"], 1e3 * error, **line)
    grid[1, 0].plot(sine["time"], 1e3 * sine["controller.u"], **line, zorder=depth)
    jump = about_jump(square)
    after = 1e3 * jump["time"]
    grid[0, 1].plot(after, 1e3 * jump["controlled.value"], **line)
    grid[1, 1].step(after, 1e3 * jump["controller.u"], where="post", **line, zorder=depth)
    if name == "pi":
        grid[0, 1].step(after, 1e3 * jump["reference.value"], "k--", where="post", linewidth=0.8)


def about_jump(square: xr.Dataset) -> xr.Dataset:
    """The part of a run in which the demand jumps for the last time, from whose instant time counts."""
    demand = square["reference.value"].values
    instant = float(square["time"][int(np.flatnonzero(np.diff(demand))[-1]) + 1])
    part = square.sel(time=slice(instant - BEFORE, instant + AFTER))
    return part.assign_coords(time=part["time"] - instant)


def labelled(grid: np.ndarray) -> None:
    labels = (f"error, mean of\n{MEAN} samples [mm/s]", "velocity [mm/s]", "command [mV]", "command [mV]")
    for axis, text in zip(grid.flat, labels, strict=True):
        axis.set_ylabel(text)
    grid[0, 0].set_title("sine", loc="left")
    grid[0, 1].set_title("square, at the jump", loc="left")
    grid[1, 0].set_xlabel("time [s]")
    grid[1, 1].set_xlabel("time [ms]")
