"""The command that finds a machine's numbers from logs of it."""

from collections.abc import Mapping, Sequence
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo.cli.frame import PICTURE_ENDINGS, CommandOutput, with_output
from hydroservo.cli.messages import Report, log_kernels
from hydroservo.cli.options import (
    Changes,
    LogScenario,
    Plugins,
    Scenario,
    Threads,
    Verbose,
    list_option,
    log_columns_of,
    parse_quantity,
    parse_ranges,
    vary_option,
)
from hydroservo.core.errors import HydroservoError, ParameterError, ScenarioError, one_of
from hydroservo.core.outputs import write_text

if TYPE_CHECKING:
    from hydroservo.identification import Identified
    from hydroservo.identification.finding import FurtherAnswers
    from hydroservo.scenario.tables import TableEntry

    Ranges = Mapping[str, TableEntry]
    Changed = Mapping[str, object]

Logs = Annotated[
    list[Path],
    typer.Argument(
        metavar="LOG...", help="Logs of the machine: CSV, Parquet, MAT, NetCDF, HDF5, MDF or TDMS files."
    ),
]
FORM, HORIZON, LIMIT = "--form", "--horizon", "--limit"
DOES_NOT_FIT = 3  # exit status


class ComparisonForm(StrEnum):
    """What is held against what was measured."""

    SIMULATION = "simulation"
    ONE_STEP = "one-step"


@with_output()
def identify_command(
    *,
    scenario: Scenario,
    logs: Logs,
    changes: Changes,
    plugins: Plugins,
    ranges: Annotated[
        list[str],
        vary_option(
            "Seek a number of the machine between two values, such as 5000..15000 bar, or relative to "
            "that of the scenario, such as -50%..+100% or x0.5..x2; or the delay of each log, such as "
            "delay=0..3s."
        ),
    ],
    limits: Annotated[
        list[str],
        list_option(
            LIMIT,
            "SIGNAL=LOW..HIGH",
            "Keep the proposed command, or a signal under it, between two values: `position=20..80mm`.",
        ),
    ],
    form: Annotated[
        ComparisonForm,
        typer.Option(
            FORM,
            help="Hold against the log a simulation of all of it, or predictions of each sample from those "
            "before, where a load or a drift acts that no one recorded.",
        ),
    ] = ComparisonForm.SIMULATION,
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
        int, typer.Option("--seed", metavar="S", help="Seed of the search's starts, a whole number >= 0.")
    ] = 0,
    output: CommandOutput,
    threads: Threads = None,
    verbose: Verbose = False,
) -> None:
    """Find numbers of a scenario's machine from logs of it, with 95 % intervals.

    A log is a table whose header names signals and their units, such as `time [s],command [V],velocity
    [mm/s],hydraulic_force [N]`; other headers are mapped by the scenario's table `[identify.columns]`. The
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
    from hydroservo.identification import compare
    from hydroservo.identification.finding import FurtherAnswers, identified_finding, typed_units
    from hydroservo.identification.identify import identify_entries
    from hydroservo.identification.proposal import propose as propose_log
    from hydroservo.scenario import parse_override
    from hydroservo.work.cores import checked_count

    overrides, sought = dict(map(parse_override, changes)), parse_ranges(ranges)
    bounds, memory = parse_limits(limits, propose), parse_horizon(form, horizon)
    count = checked_count(threads, "--threads")
    shared = settings_of_other(against, sought, overrides, plugins) if against is not None else ({}, {})

    def fit(name: str, ranges: "Ranges", changes: "Changed", report: Report) -> "Identified":
        return identify_entries(
            name, logs, ranges, changes, plugins, seed, memory, count, lambda done: report(done, name)
        )

    def ask(report: Report) -> "tuple[Identified, FurtherAnswers]":
        first = fit(scenario, sought, overrides, report)
        further = FurtherAnswers(typed=typed_units(first, sought))
        try:  # whatever goes wrong here must not cost what the logs tell
            if against is not None:
                other = fit(against, *shared, report)
                further = further._replace(other=other, comparison=compare(first, other))
            if propose:
                what = "the command to propose"
                proposal = propose_log(
                    first, limits=bounds, seed=seed, progress=lambda done: report(done, what)
                )
                write_text(propose, output.journal.csv(proposal.csv()))
                further = further._replace(proposal=proposal)
        except HydroservoError as error:
            further = further._replace(failure=error)
        return first, further

    with log_kernels(verbose):
        others = [propose] if propose else []
        first, further = output.present(
            scenario, ask, lambda both: identified_finding(*both, logs), others=others
        )
    raise further.failure or typer.Exit(0 if first.fits else DOES_NOT_FIT)


def parse_horizon(form: ComparisonForm, text: str | None) -> float | None:
    """The time in which predictions forget; None for a simulation."""
    from hydroservo.identification.prediction import USUAL

    if form == ComparisonForm.SIMULATION:
        if text is not None:
            raise ParameterError(HORIZON, text, f"applies to predictions; add {FORM} one-step")
        return None
    given = parse_quantity(HORIZON, text, "s")
    return USUAL if given is None else given


def parse_limits(texts: Sequence[str], propose: Path | None) -> dict[str, tuple[float, float]]:
    """The limits of a proposal by signal, in SI units."""
    from hydroservo.identification.log import COMMAND, OUTPUTS, SIGNALS
    from hydroservo.scenario.ranges import both_ends

    if texts and propose is None:
        raise ParameterError(LIMIT, texts[0], "applies to a proposed command; add --propose FILE.csv")
    found = {}
    for name, entry in parse_ranges(texts, LIMIT).items():
        if name not in (COMMAND, *OUTPUTS):
            raise ScenarioError(LIMIT, name, f"is not a signal; it {one_of(name, (COMMAND, *OUTPUTS))}")
        found[name] = both_ends(entry, SIGNALS[name], None)
    return found


def settings_of_other(
    scenario: str, ranges: "Ranges", changes: "Changed", plugins: Sequence[Path]
) -> "tuple[dict[str, TableEntry], dict[str, object]]":
    """Those of some ranges, and of some changes, whose numbers another scenario has."""
    from hydroservo.core.block import leaves
    from hydroservo.identification.problem import DELAY
    from hydroservo.scenario.load import assemble

    other = assemble(scenario, {}, plugins)
    known = {DELAY, *other.arguments, *(path for path, _ in leaves(other.loop))}
    changed = {path: value for path, value in changes.items() if path in known}
    assemble(scenario, changed, plugins)
    return {path: entry for path, entry in ranges.items() if path in known}, changed


@with_output()
def map_command(
    kind: Annotated[
        str,
        typer.Argument(
            metavar="KIND", help="`valve-flow`, `characteristic`, `pressure-gain`, `friction` or `decay`."
        ),
    ],
    logs: Logs,
    changes: Changes,
    plugins: Plugins,
    output: CommandOutput,
    scenario: LogScenario = None,
) -> None:
    """Measure a static map of a machine from logs of it, with 95 % intervals.

    KIND is one of: valve-flow, the flow gain, dead band and hysteresis of a valve from slow sweeps of the
    command; characteristic, the flow of a valve that bends, as a table, from these or from stairs of the
    command; pressure-gain, from slow sweeps with blocked ports; friction against velocity from moves at
    constant speed; decay, leakage and bulk modulus from pressures in blocked ports. Headers of logs are those
    that `identify` reads. With --out it writes a report (report.html, its tables as CSV and LaTeX in tables),
    the curve (map.csv), the table of a characteristic (characteristic.csv), the numbers (metrics.json), a
    picture (map.png, map.svg) and, with --scenario, a scenario with what was found (scenario.toml).

    Examples:

    - `hydroservo map friction bench.csv --scenario my.toml --out friction`
    """
    from hydroservo.identification.maps import map_logs
    from hydroservo.identification.maps.finding import map_finding
    from hydroservo.scenario import parse_override

    overrides = dict(map(parse_override, changes))
    output.present(
        ", ".join(map(str, logs)),
        lambda _: map_logs(kind, logs, scenario, changes=overrides, plugins=plugins),
        partial(map_finding, logs=logs),
    )


@with_output("Draw it: a .png, .svg or .pdf. Into a folder goes a report too.", endings=PICTURE_ENDINGS)
def log_command(
    file: Annotated[
        Path, typer.Argument(metavar="LOG", help="A CSV, Parquet, MAT, NetCDF, HDF5, MDF or TDMS file.")
    ],
    changes: Changes,
    plugins: Plugins,
    output: CommandOutput,
    scenario: LogScenario = None,
) -> None:
    """Show how a log is understood: its signals, their units and ranges, its rate and its gaps.

    It reads a log exactly as `identify`, `map` and `bode --log` do. A warning names the columns in which no
    signal is recognised; a scenario can say what they hold, with a scale where units do not convert:

        [identify.columns]
        velocity = "v_piston [mm/s]"
        command = { column = "current [mA]", scale = "0.25 V/mA" }
        period = "10 ms"  # without a column of instants

    A folder as --out gets a report (report.html, its table as CSV and LaTeX in tables), a picture of the log
    (log.png, log.svg) and the numbers (metrics.json).

    Examples:

    - `hydroservo log bench.csv`
    - `hydroservo log bench.csv --scenario my.toml --out bench.png`
    """
    from hydroservo.identification.finding import log_finding
    from hydroservo.identification.log import TIME, read_log
    from hydroservo.identification.segments import understand_log

    if scenario is None and (changes or plugins):
        option = "--set" if changes else "--plugin"
        raise ParameterError(
            option, str([*changes, *plugins][0]), "applies to a scenario; add --scenario SCENARIO"
        )
    mapping = {} if scenario is None else log_columns_of(scenario, changes, plugins)
    output.present(
        str(file),
        lambda _: understand_log(read_log(file, mapping, (TIME,))),
        partial(log_finding, logs=[file]),
    )
