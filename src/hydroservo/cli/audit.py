"""The command that asks whether a loop is what its law supposes."""

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

if TYPE_CHECKING:
    from hydroservo.audits import Asked, Audit
    from hydroservo.audits.sustained import Sustained


def audit(
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
    """Check what a scenario's law assumes, whether its loop oscillates and why, and predict its chatter.

    Each assumption has a margin, the factor by which it holds: bounds on disturbances, the sample rate, the
    valve's lag, noise, limits. Those marked "run" are measured on one run. Where that run oscillates to its
    end, it goes on without each possible cause in turn, and what ends the oscillation is named. Chatter is
    predicted by harmonic balance, without a run. With --out it also writes a report (report.html, its tables
    as CSV and LaTeX in tables), a picture of the margins (margins.png, margins.svg) and the numbers
    (metrics.json).

    Examples:

    - `hydroservo audit paper/sine-tsmc`
    - `hydroservo audit rig/1khz-tsmc-sine --set valve.time_constant=4ms --out audit`
    """
    from hydroservo.audits import audit as audited
    from hydroservo.cli.files import list_files, result_files, write_results
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.writing import try_outputs, write_or_keep
    from hydroservo.reports.folder import Files
    from hydroservo.reports.journal import journal_of
    from hydroservo.runs.results import as_json

    loop = loaded(scenario, changes, plugins)
    journal = journal_of(figure_format, figure_size, out, checked_decimal_comma(decimal_comma, out))
    if out:
        try_outputs(result_files(out, (), Files(["margins"], ["assumptions"], journal)))
    with progress_bar(scenario):
        found = audited(loop)
        said = as_object(scenario, found)

        def write(place: Path) -> list[Path]:
            from hydroservo.cli.reporting import again
            from hydroservo.cli.reports.audit import audit_report

            page = audit_report(again(context), scenario, loop, found)
            return write_results(place, {}, page, said, journal)

        left = write_or_keep(out, write)
    if json:
        typer.echo(as_json(said))
    else:
        from hydroservo.cli.audit_tables import show_audit

        show_audit(scenario, found)
        list_files(left.files)
    left.check()


def as_object(scenario: str, found: "Audit") -> dict[str, Any]:
    """What ``--json`` prints."""
    return {
        "scenario": scenario,
        "holds": found.holds,
        "diverged": found.lost,
        "assumptions": [line for one in found.asked for line in lines(one)],
        "silent": [{"path": one.path, "block": one.block} for one in found.asked if one.assumptions is None],
        "chatter": None if found.chatter is None else found.chatter._asdict(),
        "no_forecast": found.no_forecast,
        "oscillation": None if found.oscillation is None else as_oscillation(found.oscillation),
        "strain": None if found.strain is None else found.strain._asdict(),
    }


def as_oscillation(one: "Sustained") -> dict[str, Any]:
    """The oscillation of the run, and what ends it."""
    remains = [each._asdict() for each in one.remains]
    return {**one._asdict(), "causes": [each.cause for each in one.causes], "remains": remains}


def lines(one: "Asked") -> list[dict[str, Any]]:
    """A block's assumptions."""
    about = {"path": one.path, "block": one.block}
    return [
        {**about, **assumption._asdict(), "holds": assumption.holds} for assumption in one.assumptions or ()
    ]
