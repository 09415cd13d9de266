"""What the cells of the pages share; importing it lets a cell show a figure by naming it."""

import io
import json
import os
import re
import shlex
import shutil
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import numpy as np
import xarray as xr
from IPython import get_ipython
from IPython.display import HTML, Image, Markdown
from matplotlib.figure import Figure

from hydroservo import load_scenario, simulate
from hydroservo.core.formatting import NONE, readable_unit
from hydroservo.figures.style import figure, style
from hydroservo.linear.margins import MARGIN_LABELS, formatted_margin
from hydroservo.linear.stability import stability_of

__all__ = [
    "Image",
    "case",
    "curves",
    "examples",
    "framed",
    "function_in_c",
    "margins",
    "metrics_table",
    "records_in_c",
    "refused",
    "script",
    "sweeps",
    "table",
    "terminal",
    "walk",
]


def svg(fig: Figure) -> str:
    """A figure as SVG, the same bytes each time."""
    text = io.StringIO()
    with style():
        fig.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()


xr.set_options(display_expand_attrs=False)  # type: ignore[no-untyped-call]
formatters = get_ipython().display_formatter.formatters
formatters["image/svg+xml"].for_type(Figure, svg)
formatters["image/png"].for_type(Figure, lambda _: None)


def examples() -> None:
    """Copies the repository's examples into the page's own temporary folder."""
    shutil.copytree(Path(__file__).parents[2] / "examples", ".", dirs_exist_ok=True)


def script(name: str) -> ModuleType:
    """A program of ``scripts/`` as a module, so that a page and the README show what one text computes."""
    spec = spec_from_file_location(name, Path(__file__).parents[2] / "scripts" / f"{name}.py")
    module = module_from_spec(spec)  # type: ignore[arg-type]
    spec.loader.exec_module(module)  # type: ignore[union-attr]
    return module


def function_in_c(file: str, name: str) -> Markdown:
    """A function of a written source."""
    text = Path(file).read_text(encoding="utf-8")
    found = re.search(rf"^static [^;{{}}]*\b{name}\([^;{{}}]*\{{.*?^\}}", text, re.MULTILINE | re.DOTALL)
    if found is None:
        raise LookupError(f"no function {name} in {file}")
    return Markdown(f"```c\n{found[0]}\n```")  # type: ignore[no-untyped-call]


def function_in_st(file: str, name: str) -> Markdown:
    """A function or a function block of written Structured Text."""
    text = Path(file).read_text(encoding="utf-8")
    found = re.search(rf"^(FUNCTION(?:_BLOCK)?) {name}\b.*?^END_\1$", text, re.MULTILINE | re.DOTALL)
    if found is None:
        raise LookupError(f"no function {name} in {file}")
    return Markdown(f"```\n{found[0]}\n```")  # type: ignore[no-untyped-call]


def records_in_c(file: str, *names: str) -> Markdown:
    """Records of a written header."""
    text = Path(file).read_text(encoding="utf-8")
    blocks = text.split("\n\n")
    ends = [re.compile(rf"^\}} {Path(file).stem}_{name};", re.MULTILINE) for name in names]
    found = [block for end in ends for block in blocks if end.search(block)]
    if len(found) != len(names):
        raise LookupError(f"not all of {names} in {file}")
    return Markdown("```c\n" + "\n\n".join(found) + "\n```")  # type: ignore[no-untyped-call]


def terminal(*commands: str) -> Markdown:
    """What a reader's terminal shows after some commands.

    Raises:
        RuntimeError: one does not succeed.
    """
    return shown(commands, status=0)


def framed(file: str, title: str) -> HTML:
    """A page of a file, as it is, inside this one."""
    inside = escape(Path(file).read_text(encoding="utf-8"))
    style = "width: 100%; height: 46rem; border: 1px solid #8a97a5; border-radius: 8px"
    return HTML(f'<div><iframe srcdoc="{inside}" title="{escape(title)}" style="{style}"></iframe></div>')


def refused(*commands: str) -> Markdown:
    """What a reader's terminal shows after commands that hydroservo refuses.

    Raises:
        RuntimeError: one is not refused.
    """
    return shown(commands, status=2)


def shown(commands: Iterable[str], status: int) -> Markdown:
    surroundings = {
        name: value for name, value in os.environ.items() if not name.startswith(("FORCE_", "CLICOLOR"))
    }
    lines = []
    for command in commands:
        done = subprocess.run(
            shlex.split(command),
            check=False,
            env=surroundings,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        if done.returncode != status:
            raise RuntimeError(f"{command}: ended with {done.returncode}, not {status}\n{done.stdout}")
        lines += [f"$ {command}", *(line.rstrip() for line in done.stdout.strip().splitlines())]
    text = "\n".join(lines).replace(f"{Path.cwd()}/", "")
    return Markdown(f"```console\n{text}\n```")  # type: ignore[no-untyped-call]


def case(name: str, *laws: str) -> dict[str, xr.Dataset]:
    """Runs of a scenario cases/... under some of the laws that scripts/cases has found for it."""
    found = json.loads((Path(__file__).parents[1] / "cases.json").read_text(encoding="utf-8"))[name]
    return {law: simulate(load_scenario(f"cases/{name}", found[law])) for law in laws}


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> Markdown:
    """A table of what a cell computed."""
    lines = [header, ["---"] * len(header), *rows]
    return Markdown("\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines))  # type: ignore[no-untyped-call]


def metrics_table(runs: Mapping[str, xr.Dataset], *names: str) -> Markdown:
    """Metrics of some runs side by side, in units that an engineer reads."""
    header, columns = [""], []
    for name in names:
        values = [float(data[name]) for data in runs.values()]
        unit, factor = readable_unit(next(iter(runs.values()))[name].attrs["units"], np.nanmax(values))
        header.append(f"{name} [{unit}]" if unit else name)
        columns.append([NONE if np.isnan(value) else f"{factor * value:.3g}" for value in values])
    lost = [" (diverged)" if bool(data["diverged"]) else "" for data in runs.values()]
    names_shown = [label + note for label, note in zip(runs, lost, strict=True)]
    return table(header, zip(names_shown, *columns, strict=True))


def margins(*names: str, scales: Sequence[float] = (-1.0, 0.0, 1.0)) -> Markdown:
    """What scenarios leave to instability while they move, on the worst of some machines."""
    columns = ("oscillation_gain", "gain_margin", "phase_margin", "sensitivity_peak")
    rows = []
    for name in names:
        found = [stability_of(load_scenario(name, {"uncertainty.scale": scale})) for scale in scales]
        *least, peaks, _ = zip(*found, strict=True)
        worst = [*map(np.min, least), np.max(peaks)]
        texts = [
            formatted_margin(value, MARGIN_LABELS[column][1], NONE)
            for value, column in zip(worst, columns, strict=True)
        ]
        rows.append((f"`{name}`", *texts))
    return table(("", *(MARGIN_LABELS[column][0] for column in columns)), rows)


def curves(
    panels: Mapping[str, Mapping[str, tuple[np.ndarray, np.ndarray]]], xlabel: str = "time [s]"
) -> Figure:
    """Panels below each other: by the label of the vertical axis, and in each by the legend's."""
    with style():
        fig = figure(height=0.5 + 1.5 * len(panels))
        axes = np.atleast_1d(fig.subplots(len(panels), 1, sharex=True))
        for axis, (label, lines) in zip(axes, panels.items(), strict=True):
            for name, (x, y) in lines.items():
                axis.plot(x, y, label=name)
            axis.set_ylabel(label)
            if len(lines) > 1:
                axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(lines), borderpad=0.1)
        axes[-1].set_xlabel(xlabel)
        fig.align_ylabels(axes)
    return fig


def sweeps(
    columns: Mapping[str, Mapping[str, Mapping[str, np.ndarray]]], x: np.ndarray, xlabel: str
) -> Figure:
    """Columns of panels over one logarithmic axis: by a column's title, a panel's label and a line's name.

    What is not finite is left out.
    """
    rows = max(len(panels) for panels in columns.values())
    with style():
        fig = figure(height=0.6 + 1.7 * rows)
        grid = fig.subplots(rows, len(columns), sharex=True, sharey="row", squeeze=False)
        for axes, (title, panels) in zip(grid.T, columns.items(), strict=True):
            for axis, (label, lines) in zip(axes, panels.items(), strict=True):
                for marker, (name, y) in zip("osD^", lines.items(), strict=False):
                    axis.loglog(x, y, marker=marker, markersize=3.5, label=name)
                if axes[0] is grid[0, 0]:
                    axis.set_ylabel(label)
            axes[0].set_title(title, loc="left")
            axes[0].legend(loc="best")
            axes[-1].set_xlabel(xlabel)
        grid[0, 0].margins(x=0.03)
        fig.align_ylabels(grid[:, 0])
    return fig


def walk(start: str, *steps: tuple[str, str, str]) -> Figure:
    """A chain of boxes: a function of the package by its path, what it does, and what it makes."""
    count = len(steps)
    with style():
        fig = figure(height=0.25 + 0.42 * (count + 1))
        axis = fig.subplots()
        axis.set(xlim=(0.0, 10.0), ylim=(-count - 0.5, 0.5))
        axis.set_axis_off()
        box = {"boxstyle": "round,pad=0.35", "facecolor": "white", "edgecolor": "0.4"}
        for i, made in enumerate([start, *(made for *_, made in steps)]):
            axis.text(2.0, -i, made, ha="center", va="center", bbox=box)
        for i, (path, meaning, _) in enumerate(steps):
            axis.annotate(
                "", (2.0, -i - 0.72), (2.0, -i - 0.28), arrowprops={"arrowstyle": "->", "color": "0.4"}
            )
            axis.text(4.4, -i - 0.42, file_of(path), family="monospace", size="small", va="center")
            axis.text(4.4, -i - 0.72, meaning, size="small", color="0.4", va="center")
    return fig


def file_of(path: str) -> str:
    """The file and the name of a function, such as ``runs.run.prepare``; an error where there is none."""
    module, _, name = path.rpartition(".")
    owner = ""
    if module.rpartition(".")[2][0].isupper():
        module, _, owner = module.rpartition(".")
    found = import_module(f"hydroservo.{module}")
    getattr(getattr(found, owner) if owner else found, name)
    return f"{module.replace('.', '/')}.py: {owner}{'.' * bool(owner)}{name}"
