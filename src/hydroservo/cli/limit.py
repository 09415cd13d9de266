"""The command that says how much better a law could be."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from hydroservo.cli.options import Changes, Folder, Json, Plugins, Scenario, loaded
from hydroservo.cli.remarks import say_remarks

if TYPE_CHECKING:
    from hydroservo.limits import Limits

__all__ = ["limit"]

FILES = ("limit.png", "limit.svg", "law.csv", "causal.csv", "clairvoyant.csv")
MEANINGS = {
    "law": "the scenario's law",
    "causal": "the best command, jumps unknown until they come",
    "clairvoyant": "the best command, all known",
}


def limit(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    out: Folder = None,
    json: Json = False,
) -> None:
    """Show how close a scenario's law comes to the best that any command could do.

    The commands with the least rms error are found by optimal control of the same machine, at the same
    sample rate and within the limits of the command, and played back: where all is known in advance
    (clairvoyant), and where jumps of demand and load are known only once they are there (causal). That takes
    from seconds to minutes. With --out it also writes a picture of the three runs (limit.png, limit.svg) and
    the trajectory of each (law.csv, causal.csv, clairvoyant.csv).

    Examples:

    - `hydroservo limit rig/1khz-tsmc-square`
    - `hydroservo limit rig/1khz-pi-square --set valve.time_constant='5 ms' --out limit`
    """
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.writing import try_outputs, write_or_keep
    from hydroservo.limits import limit as limit_of
    from hydroservo.runs.results import as_json
    from hydroservo.runs.run import trace_size

    loop = loaded(scenario, changes, plugins)
    if out:
        try_outputs(limit_files(out), len(MEANINGS) * trace_size(loop))
    with progress_bar(scenario) as report:
        found = limit_of(loop, progress=lambda fraction: report(fraction, scenario))
        left = write_or_keep(out, lambda place: write_limits(place, found))
    for data in found:
        say_remarks(scenario, data)
    if json:
        typer.echo(as_json(said_of(scenario, found)))
    else:
        show_limits(scenario, found)
        if left.files:
            typer.echo(f"written to {left.files[0].parent}: {', '.join(file.name for file in left.files)}")
    left.check()


def said_of(scenario: str, found: "Limits") -> dict[str, Any]:
    """What there is to say of limits, for JSON."""
    runs = found._asdict()
    own = {
        name: {key: runs[name].attrs[key] for key in ("iterations", "converged")} for name in list(runs)[1:]
    }
    return {
        "scenario": scenario,
        "hash": found.law.attrs["hash"],
        "unit": found.law["rms_error"].attrs["units"],
        "rms_error": {name: float(data["rms_error"]) for name, data in runs.items()},
        "multiple": found.multiples(),
        "search": own,
    }


def show_limits(scenario: str, found: "Limits") -> None:
    """A table on the terminal: what each run leaves, and how many times that the law leaves."""
    from rich.markup import escape
    from rich.table import Table

    from hydroservo.cli.tables import show
    from hydroservo.formatting import measured, number

    table = Table(title=escape(scenario), title_justify="left")
    multiples = found.multiples()
    table.add_column("command")
    table.add_column(found.law["rms_error"].attrs["long_name"], justify="right")
    table.add_column("the law leaves", justify="right")
    table.add_column("meaning")
    for name, data in found._asdict().items():
        times = multiples.get(name)
        shown = "" if times is None else f"{number(times)} times this"
        table.add_row(name, measured(data, "rms_error"), shown, MEANINGS[name])
    show(table)


def limit_files(folder: Path) -> list[Path]:
    """What :func:`write_limits` writes."""
    return [folder / name for name in FILES]


def write_limits(folder: Path, found: "Limits") -> list[Path]:
    """The picture of the runs, and the trajectory of each; returns what was written."""
    from hydroservo.figures.comparison import plot_comparison
    from hydroservo.figures.style import save_figure
    from hydroservo.outputs import staged
    from hydroservo.runs.results import save

    with staged(folder) as stage:
        picture = plot_comparison([*found], [*found._fields])
        save_figure(picture, stage / "limit", found.law.attrs["hash"])
        for name, data in found._asdict().items():
            save(data, stage / f"{name}.csv")
    return limit_files(folder)
