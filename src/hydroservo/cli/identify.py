"""The command that finds a machine's numbers from logs of it."""

from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
    Threads,
    Verbose,
    checked_decimal_comma,
    quantity_of,
    ranges_in,
    varied,
)
from hydroservo.cli.remarks import say_warning

if TYPE_CHECKING:
    from hydroservo.cli.identify_tables import Further
    from hydroservo.identification import Identified
    from hydroservo.reports.folder import Files
    from hydroservo.reports.journal import Journal
    from hydroservo.scenario.tables import Entry

FORM, HORIZON, LIMIT = "--form", "--horizon", "--limit"
DOES_NOT_FIT = 3  # exit status


class Form(StrEnum):
    """What is held against what was measured."""

    SIMULATION = "simulation"
    ONE_STEP = "one-step"


def identify(
    context: typer.Context,
    scenario: Scenario,
    logs: Annotated[
        list[Path],
        typer.Argument(
            metavar="LOG...", help="Logs of the machine: CSV, Parquet, MAT, NetCDF, HDF5, MDF or TDMS files."
        ),
    ],
    changes: Changes,
    plugins: Plugins,
    ranges: Annotated[
        list[str],
        varied(
            "Seek a number of the machine between two values, such as 5000..15000 bar, or relative to "
            "that of the scenario, such as -50%..+100% or x0.5..x2; or the delay of each log, such as "
            "delay=0..3s."
        ),
    ],
    limits: Annotated[
        list[str],
        typer.Option(
            LIMIT,
            metavar="SIGNAL=LOW..HIGH",
            default_factory=list,
            show_default=False,
            help="Keep the proposed command, or a signal under it, between two values, such as "
            "`position=20..80mm`. May be given again.",
        ),
    ],
    form: Annotated[
        Form,
        typer.Option(
            FORM,
            help="Hold against the log a simulation of all of it, or predictions of each sample from those "
            "before, where a load or a drift acts that no one recorded.",
        ),
    ] = Form.SIMULATION,
    horizon: Annotated[
        str | None,
        typer.Option(
            HORIZON,
            metavar="TIME",
            help="Time in which a prediction forgets the samples before.",
            show_default="50ms",
        ),
    ] = None,
    against: Annotated[
        str | None,
        typer.Option(
            "--against",
            metavar="SCENARIO",
            help="Fit this scenario too, and say whether the larger of both models earns its numbers.",
        ),
    ] = None,
    propose: Annotated[
        Path | None,
        typer.Option(
            "--propose",
            metavar="FILE.csv",
            dir_okay=False,
            help="Write a command for the next log, which tells what these logs do not.",
        ),
    ] = None,
    seed: Annotated[
        int,
        typer.Option("--seed", metavar="S", help="Seed of the search's starts, a whole number >= 0."),
    ] = 0,
    out: Folder = None,
    figure_size: FigureSize = None,
    figure_format: FigureFormat = None,
    decimal_comma: DecimalComma = False,
    threads: Threads = None,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Find numbers of a scenario's machine from logs of it, with 95 % intervals.

    A log is a table whose header names signals and their units, such as `time [s],command [V],velocity
    [mm/s],load_force [N]`; other headers are mapped by the scenario's table `[identify.columns]`. The
    recorded command takes the place of the law. What is sought can stand in the scenario too, in
    `[identify.vary]`. With --out it writes a report (report.html, its tables as CSV and LaTeX in tables), a
    scenario with what was found (scenario.toml), all numbers (metrics.json), and of each log how it was
    understood (log-1.png, log-1.svg) and met (fit-1.png, fit-1.svg).

    Where the model does not fit the logs, they tell none of its numbers. A table has what it may miss, and
    the exit status is 3.

    Examples:

    - `hydroservo identify my.toml bench.csv --vary plant.mass=-50%..+100% --vary
      plant.bulk_modulus=-50%..+100% --out found`
    - `hydroservo identify larger.toml bench.csv --against smaller.toml`
    - `hydroservo identify my.toml bench.csv --vary plant.mass=-50%..+100% --propose next.csv --limit
      position=20..80mm`
    """
    from hydroservo.cli.files import list_files, result_files
    from hydroservo.cli.identify_tables import Further, as_tables, tables_of, typed_units
    from hydroservo.cli.kernels import log_kernels
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.tables import show
    from hydroservo.cli.writing import try_outputs, write_or_keep
    from hydroservo.errors import HydroservoError
    from hydroservo.identification import compare
    from hydroservo.identification import propose as proposed
    from hydroservo.identification.identified import identified
    from hydroservo.outputs import write_text
    from hydroservo.reports.journal import journal_of
    from hydroservo.runs.results import as_json
    from hydroservo.scenario import parse_override
    from hydroservo.work.cores import checked_count

    overrides, asked = dict(map(parse_override, changes)), ranges_in(ranges)
    bounds, memory = limits_in(limits, propose), horizon_of(form, horizon)
    count = checked_count(threads, "--threads")
    journal = journal_of(figure_format, figure_size, out, checked_decimal_comma(decimal_comma, out, propose))
    files = files_of(len(logs), against is not None, propose is not None, journal)
    own = result_files(out, ["scenario.toml"], files) if out else []
    try_outputs([*own, *([propose] if propose else [])])
    shared, changed = others_own(against, asked, overrides, plugins) if against is not None else ({}, {})
    with log_kernels(verbose), progress_bar(scenario) as report:
        say = partial(say_progress, report, scenario)
        found = identified(scenario, logs, asked, overrides, plugins, seed, memory, count, say)
        more, failure = Further(typed=typed_units(found, asked)), None
        try:  # whatever goes wrong here must not cost what was found
            if against is not None:
                say = partial(say_progress, report, against)
                other = identified(against, logs, shared, changed, plugins, seed, memory, count, say)
                more = more._replace(other=other, comparison=compare(found, other))
            if propose:
                say = partial(say_progress, report, "the command to propose")
                proposal = proposed(found, limits=bounds, seed=seed, progress=say)
                write_text(propose, journal.csv(proposal.csv()))
                more = more._replace(proposal=proposal)
        except HydroservoError as error:
            failure = error
        left = write_or_keep(out, partial(write_identified, context, found, more, logs, journal))
    for one in (found, more.other):
        say_remarks_of(one)
    if json:
        typer.echo(as_json(as_tables(found, more)))
    else:
        show(*tables_of(found, more).values())
        list_files(left.files)
    left.check()
    raise failure or typer.Exit(0 if found.fits else DOES_NOT_FIT)


def write_identified(
    context: typer.Context,
    found: "Identified",
    more: "Further",
    logs: Sequence[Path],
    journal: "Journal",
    place: Path,
) -> list[Path]:
    """Write what was found into a folder; returns what was written."""
    from hydroservo.cli.files import write_results
    from hydroservo.cli.identify_tables import as_tables
    from hydroservo.cli.reporting import again
    from hydroservo.cli.reports.identify import identified_files, identify_report

    page = identify_report(again(context), found, more, logs)
    return write_results(place, identified_files(found, place), page, as_tables(found, more), journal)


def say_remarks_of(found: "Identified | None") -> None:
    """What a user should know of an identification, on stderr."""
    if found:
        for line in found.remarks:
            say_warning(found.scenario, line)


def say_progress(report: Callable[[float, str], None], name: str, fraction: float) -> None:
    """Report how much of something is done."""
    report(fraction, name)


def horizon_of(form: Form, text: str | None) -> float | None:
    """The time in which predictions forget; None for a simulation.

    Raises:
        ParameterError: it is given for a simulation, or is no time.
    """
    from hydroservo.errors import ParameterError
    from hydroservo.identification.one_step import USUAL

    if form == Form.SIMULATION:
        if text is not None:
            raise ParameterError(HORIZON, text, f"is of {FORM} one-step; a simulation has none")
        return None
    given = quantity_of(HORIZON, text, "s")
    return USUAL if given is None else given


def limits_in(texts: Sequence[str], propose: Path | None) -> dict[str, tuple[float, float]]:
    """The limits of a proposal by signal, in SI units.

    Raises:
        ParameterError: there is no proposal.
        ScenarioError: one is no range of a signal, or is given twice.
    """
    from hydroservo.errors import ParameterError, ScenarioError
    from hydroservo.identification.signals import COMMAND, OUTPUTS, SIGNALS
    from hydroservo.nearest import one_of
    from hydroservo.scenario.ranges import both_ends

    if texts and propose is None:
        raise ParameterError(LIMIT, texts[0], "applies to a proposed command; add --propose FILE.csv")
    found = {}
    for name, entry in ranges_in(texts, LIMIT).items():
        if name not in (COMMAND, *OUTPUTS):
            raise ScenarioError(LIMIT, name, f"is not a signal; it {one_of(name, (COMMAND, *OUTPUTS))}")
        found[name] = both_ends(entry, SIGNALS[name], None)
    return found


def others_own(
    scenario: str, asked: "Mapping[str, Entry]", overrides: Mapping[str, object], plugins: Sequence[Path]
) -> "tuple[dict[str, Entry], dict[str, object]]":
    """Those of some ranges, and of some changes, whose numbers another scenario has.

    Raises:
        ScenarioError: one of these changes is none to it.
    """
    from hydroservo.block import leaves
    from hydroservo.identification.problem import DELAY
    from hydroservo.scenario.load import assembled

    other = assembled(scenario, {}, plugins)
    known = {DELAY, *other.arguments, *(path for path, _ in leaves(other.loop))}
    changed = {path: value for path, value in overrides.items() if path in known}
    assembled(scenario, changed, plugins)
    return {path: entry for path, entry in asked.items() if path in known}, changed


def files_of(logs: int, compared: bool, proposed: bool, journal: "Journal") -> "Files":
    """What the report of an identification will have.

    Args:
        logs: how many.
        compared: whether with another scenario.
        proposed: whether there is a proposal for the next log.
        journal: what figures a journal is to have.
    """
    from hydroservo.reports.folder import Files

    each = range(1, logs + 1)
    asked = {"comparison": compared, "proposal": proposed}
    tables = [
        "parameters",
        *(f"signals-{i}" for i in each),
        *(name for name, there in asked.items() if there),
    ]
    return Files([f"{what}-{i}" for i in each for what in ("log", "fit")], tables, journal)
