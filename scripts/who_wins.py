"""The README's picture of who wins where, from the dataset of the study of velocity."""

from pathlib import Path

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from hydroservo.figures.studies.layout import fix_layout
from hydroservo.figures.studies.looks import INK
from hydroservo.figures.style import figure, save_picture, style

LAWS = {  # the least error, the first paper's law and its rivals there, and what practice uses
    "lq-kalman": "linear quadratic, Kalman observer",
    "lqi": "linear quadratic with an integral",
    "fast-terminal-kalman": "the paper's terminal sliding mode",
    "backstepping": "backstepping",
    "industrial": "PID with pressure feedback",
    "pi": "PI",
}
VALVES = {"fast": "fast valve", "slow": "slow valve"}
NOISES = {"low": "little noise", "high": "much noise"}
RATES = {"1khz": "1 kHz", "4khz": "4 kHz"}
FILLS = {"best": "#0072B2", "tie": "#dbe6ee", "behind": "#f0a35e"}
MEANS = {"best": "least error of all laws", "tie": "ties with it", "behind": "surely behind"}
WIDTH = 4.6  # inch: as wide as a phone's screen at the size of its text
NAME = 2.25  # tiles that a law's name takes
GAP = 0.2  # tiles, between noises; twice that between valves


def read(path: Path) -> dict[str, pd.DataFrame]:
    """Each number of the dataset by cell and law."""
    rows = pd.read_csv(path)
    return {key: rows.pivot(index="cell", columns="law", values=key) for key in rows.columns[2:]}


def draw(data: dict[str, pd.DataFrame]) -> Figure:
    """A tile for each law in each condition: its error over the least there, and whether that is sure."""
    with style():
        fig = figure(0.29 * len(LAWS) + 1.15, WIDTH)
        axis = fig.subplots()
        for row, (law, name) in enumerate(LAWS.items()):
            axis.text(-0.12, row + 0.5, two_lines(name), ha="right", va="center", fontsize=8.5, color=INK)
            for cell, left in places().items():
                draw_tile(axis, left, row, data["stands"].loc[cell, law], data["regret"].loc[cell, law])
        draw_headings(axis)
        axis.set(xlim=(-NAME, max(places().values()) + 1.0), ylim=(len(LAWS), -1.75))
        axis.set_axis_off()
        handles = [Patch(facecolor=fill, label=MEANS[stands]) for stands, fill in FILLS.items()]
        fig.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=8)
        fix_layout(fig)
    return fig


def two_lines(name: str) -> str:
    """A name broken at the space nearest to its middle, where it is long."""
    spaces = [place for place, letter in enumerate(name) if letter == " "]
    if len(name) < 14 or not spaces:
        return name
    middle = min(spaces, key=lambda place: abs(place - len(name) / 2))
    return f"{name[:middle]}\n{name[middle + 1 :]}"


def places() -> dict[str, float]:
    """The left end of each cell's column, in tiles."""
    return {
        f"{rate}-{noise}-{valve}": 4.0 * v + 2.0 * n + r + GAP * (n + 3.0 * v)
        for v, valve in enumerate(VALVES)
        for n, noise in enumerate(NOISES)
        for r, rate in enumerate(RATES)
    }


def draw_tile(axis: Axes, left: float, row: int, stands: str, ratio: float) -> None:
    tile = Rectangle((left, row), 1, 1, facecolor=FILLS[stands], edgecolor="white", linewidth=1)
    axis.add_patch(tile)
    ink = "white" if stands == "best" else INK
    axis.text(left + 0.5, row + 0.53, f"{ratio:.1f}", ha="center", va="center", fontsize=8.5, color=ink)


def draw_headings(axis: Axes) -> None:
    """What the columns are: valves above noises above sample rates."""
    left = places()
    first, last = next(iter(RATES)), list(RATES)[-1]
    for cell, place in left.items():
        axis.text(place + 0.5, -0.1, RATES[cell.partition("-")[0]], ha="center", va="bottom", fontsize=7)
    for valve, said in VALVES.items():
        ends = left[f"{first}-{next(iter(NOISES))}-{valve}"], left[f"{last}-{list(NOISES)[-1]}-{valve}"] + 1
        axis.text(sum(ends) / 2, -1.25, said, ha="center", va="bottom", fontsize=9)
        for noise, words in NOISES.items():
            near, far = left[f"{first}-{noise}-{valve}"], left[f"{last}-{noise}-{valve}"] + 1
            axis.text((near + far) / 2, -0.65, words, ha="center", va="bottom", fontsize=8.5)


def save(data: dict[str, pd.DataFrame], path: Path) -> None:
    """Write the picture; its white ground makes it legible on dark pages too."""
    save_picture(draw(data), path, "")
