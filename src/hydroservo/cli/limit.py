"""The command that says how much better a law could be."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from hydroservo.cli.options import (
    Changes,
    DecimalComma,
    FigureFormat,
    FigureSize,
    Folder,
    Json,
    Plugins,
    Scenario,
    checked_decimal_comma,
    loaded,
)
from hydroservo.cli.remarks import say_remarks

if TYPE_CHECKING:
    from rich.table import Table

    from hydroservo.limits import Limits

MEANINGS = {
    "law": "the scenario's law",
    "causal": "the best command, jumps unknown until they come",
    "clairvoyant": "the best command, all known",
}


def limit(
    context: typer.Context,
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    out: Folder = None,
    figure_size: FigureSize = None,
    figure_format: FigureFormat = None,
    decimal_comma: DecimalComma = False,
    json: Json = False,
) -> None:
    """Show how close a scenario's law comes to the best that any command could do.

    The commands with the least rms error are found by optimal control of the same machine, at the same
    sample rate and within the limits of the command, and played back: where all is known in advance
    (clairvoyant), and where jumps of demand and load are known only once they are there (causal). That takes
    from seconds to minutes. With --out it also writes a report (report.html, its tables as CSV and LaTeX in
    tables), a picture of the three runs (limit.png, limit.svg), the trajectory of each (law.csv, causal.csv,
    clairvoyant.csv) and the numbers (metrics.json).

    Examples:

    - `hydroservo limit rig/1khz-tsmc-square`
    - `hydroservo limit rig/1khz-pi-square --set valve.time_constant='5 ms' --out limit`
    """
    from hydroservo.cli.files import list_files, result_files, write_results
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.tables import show
    from hydroservo.cli.writing import try_outputs, write_or_keep
    from hydroservo.limits import limit as limit_of
    from hydroservo.reports.folder import Files
    from hydroservo.reports.journal import journal_of
    from hydroservo.runs.results import as_json
    from hydroservo.runs.run import trace_size

    loop = loaded(scenario, changes, plugins)
    journal = journal_of(figure_format, figure_size, out, checked_decimal_comma(decimal_comma, out))
    if out:
        own = [f"{name}.csv" for name in MEANINGS]
        report_files = Files(["limit"], ["limits"], journal)
        try_outputs(result_files(out, own, report_files), len(MEANINGS) * trace_size(loop))
    with progress_bar(scenario) as report:
        found = limit_of(loop, progress=lambda fraction: report(fraction, scenario))
        said = as_object(scenario, found)

        def write(place: Path) -> list[Path]:
            from hydroservo.cli.reporting import again
            from hydroservo.cli.reports.limit import limit_report, limits_files

            page = limit_report(again(context), scenario, found)
            return write_results(place, limits_files(found), page, said, journal)

        left = write_or_keep(out, write)
    for data in found:
        say_remarks(scenario, data)
    if json:
        typer.echo(as_json(said))
    else:
        show(limits_table(scenario, found))
        list_files(left.files)
    left.check()


def as_object(scenario: str, found: "Limits") -> dict[str, Any]:
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


def limits_table(scenario: str, found: "Limits") -> "Table":
    """What each run leaves, and how many times that the law leaves."""
    from rich.markup import escape
    from rich.table import Table

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
    return table
