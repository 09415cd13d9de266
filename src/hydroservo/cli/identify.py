"""The command that finds a machine's numbers from logs of it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydroservo.cli.options import (
    Changes,
    Json,
    Plugins,
    Scenario,
    Verbose,
    ranges_in,
    varied,
)
from hydroservo.cli.remarks import say_warning

if TYPE_CHECKING:
    from hydroservo.identification import Identified

__all__ = ["identify"]

FOUND = "scenario.toml"


def identify(
    scenario: Scenario,
    logs: Annotated[
        list[Path],
        typer.Argument(metavar="LOG...", help="Logs of the machine: CSV, Parquet, MAT, NetCDF or MDF files."),
    ],
    changes: Changes,
    plugins: Plugins,
    ranges: Annotated[
        list[str],
        varied(
            "Seek a number of the machine between two values, such as 5000..15000 bar, or relative to "
            "that of the scenario, such as -50%..+100%."
        ),
    ],
    seed: Annotated[
        int,
        typer.Option("--seed", metavar="S", help="Seed of the search's starts, a whole number from 0 on."),
    ] = 0,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", file_okay=False, help="Write the results to this folder."),
    ] = None,
    threads: Annotated[
        int | None,
        typer.Option("--threads", metavar="N", min=1, show_default="all cores", help="How many to use."),
    ] = None,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Find numbers of a scenario's machine from logs of it, with 95 % intervals.

    A log is a table whose header names signals and their units, such as `time [s],command [V],velocity
    [mm/s],load_force [N]`; other headers are mapped by the scenario's table `[identify.columns]`. The
    recorded command takes the place of the law. With --out it writes a scenario with what was found
    (scenario.toml), all numbers (metrics.json), and of each log how it was understood (log-1.png, log-1.svg)
    and met (fit-1.png, fit-1.svg).

    Examples:

    - `hydroservo identify my.toml bench.csv --vary plant.mass=-50%..+100% --vary
      plant.bulk_modulus=-50%..+100% --out found`
    """
    from hydroservo.cli.identify_tables import as_tables, show_identified
    from hydroservo.cli.kernels import log_kernels
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.writing import try_outputs, write_or_keep
    from hydroservo.identification.identified import identified
    from hydroservo.runs.results import as_json
    from hydroservo.scenario import parse_override
    from hydroservo.work.cores import checked_count

    overrides, asked = dict(map(parse_override, changes)), ranges_in(ranges)
    if out:
        try_outputs(identify_files(out, len(logs)))
    with log_kernels(verbose), progress_bar(scenario) as report:
        found = identified(
            scenario,
            logs,
            asked,
            overrides,
            plugins,
            seed,
            checked_count(threads, "--threads"),
            lambda fraction: report(fraction, scenario),
        )
        left = write_or_keep(out, lambda place: write_identified(place, found))
    for line in found.remarks:
        say_warning(scenario, line)
    if json:
        typer.echo(as_json(as_tables(found)))
    else:
        show_identified(found)
        if left.files:
            typer.echo(f"written to {left.files[0].parent}: {', '.join(file.name for file in left.files)}")
    left.check()


def identify_files(folder: Path, logs: int) -> list[Path]:
    """What :func:`write_identified` writes."""
    from hydroservo.runs.results import METRICS

    pictures = [
        f"{what}-{i}.{form}" for i in range(1, logs + 1) for what in ("log", "fit") for form in ("png", "svg")
    ]
    return [folder / name for name in (FOUND, *pictures, METRICS)]


def write_identified(folder: Path, found: "Identified") -> list[Path]:
    """The scenario, the pictures and the numbers of an identification; returns what was written."""
    from hydroservo.cli.identify_tables import as_tables
    from hydroservo.figures.identified import plot_fit, plot_log
    from hydroservo.figures.style import save_figure
    from hydroservo.outputs import staged, write_text
    from hydroservo.runs.provenance import scenario_hash
    from hydroservo.runs.results import METRICS, write_metrics

    origin = scenario_hash(found.loop)
    with staged(folder, last=METRICS) as stage:
        write_text(stage / FOUND, found.toml(folder))
        for i, fit in enumerate(found.logs, 1):
            save_figure(plot_log(fit), stage / f"log-{i}", origin)
            save_figure(plot_fit(fit), stage / f"fit-{i}", origin)
        content: dict[str, Any] = as_tables(found)
        write_metrics(stage, content)
    return identify_files(folder, len(found.logs))
