"""The command that shows a scenario in frequency."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydroservo.cli.frame import PICTURE_ENDINGS, CommandOutput, with_output
from hydroservo.cli.options import (
    VARY,
    Changes,
    CommandAt,
    Force,
    Plugins,
    Scenario,
    list_option,
    load_loop,
    load_with_warnings,
    log_columns_of,
    parse_quantity,
    parse_ranges,
)
from hydroservo.core.errors import ParameterError

if TYPE_CHECKING:
    import xarray as xr

    from hydroservo.cli.progress import Report
    from hydroservo.show import Finding

VALUES = 5  # of a range, evenly


class ExcitationOption(StrEnum):
    """What a loop is excited with."""

    MULTISINE = "multisine"
    CHIRP = "chirp"


@with_output("Draw it: a .png, .svg or .pdf. Into a folder goes a report too.", PICTURE_ENDINGS)
def bode_command(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    logs: Annotated[
        list[Path],
        list_option(
            "--log",
            "FILE",
            "Show what a recorded log says beside it: a table with the command or the demand "
            "(`reference`) and what is controlled, as of `identify`.",
        ),
    ],
    vary: Annotated[
        list[str],
        typer.Option(
            VARY,
            metavar="PATH=LOW..HIGH",
            default_factory=list,
            show_default=False,
            help="Show the linear model for five values of this number: `plant.mechanism.mass=40..120kg`, "
            "`start.command=0.1..2V`, `load.amplitude=0..2kN`. Nothing is measured then.",
        ),
    ],
    *,
    command: CommandAt = None,
    force: Force = None,
    band: Annotated[
        str | None,
        typer.Option(
            "--band", metavar="LOW..HIGH", help="Frequencies: `1..200Hz`. Without it, about the crossover."
        ),
    ] = None,
    amplitude: Annotated[
        str,
        typer.Option(
            "--amplitude",
            metavar="COMMAND",
            help="How far the excitation moves the command, rms: volts, or the scenario's unit of commands.",
        ),
    ] = "10mV",
    excitation: Annotated[
        ExcitationOption, typer.Option("--excitation", help="Many tones at once, or one of rising frequency.")
    ] = ExcitationOption.MULTISINE,
    periods: Annotated[int, typer.Option("--periods", help="Periods of the excitation to measure.")] = 2,
    realisations: Annotated[
        int, typer.Option("--realisations", help="Experiments, each with random phases of its own.")
    ] = 4,
    linear: Annotated[
        bool, typer.Option("--linear", help="Only the linear model, nothing measured.")
    ] = False,
    answer: CommandOutput,
) -> None:
    """Show a scenario in frequency: its loop open and closed, and its compliance to the load.

    Each response comes twice: from the linear model about a point, and measured on the simulation with many
    tones at once or a chirp, noise, resolution and all, with its coherence. With it come the margins, the
    sensitivity peak, the bandwidth, and the gain from which the simulation oscillates for good, with 0.1 V
    or more in its command. A log shows what the real machine does. A folder as --out gets a
    report (report.html, its tables as CSV and LaTeX in tables), the picture (bode.png, bode.svg) and all
    curves (metrics.json).

    Examples:

    - `hydroservo bode rig/1khz-pi-sine --out bode.png`
    - `hydroservo bode axis/force --command 0.1V --amplitude 50mV --band 0.5..100Hz --json`
    - `hydroservo bode rig/1khz-pi-sine --vary plant.mass=4..12kg --out masses.pdf`
    - `hydroservo bode rig/1khz-pi-sine --log bench.csv --log warm.csv --out bench`
    """
    from hydroservo.identification.recorded import with_logs
    from hydroservo.linear.bode import bode, bode_over
    from hydroservo.linear.bode_finding import bode_finding
    from hydroservo.runs.provenance import origin_of_loop
    from hydroservo.scenario import parse_override
    from hydroservo.scenario.sampling import loops_over

    if len(vary) > 1:
        raise ParameterError(VARY, ", ".join(vary), "must be one number: five values of it are a picture")
    loop = load_loop(scenario, changes, plugins)  # first, for commands are read in its unit
    point: dict[str, Any] = {
        "command": parse_quantity("--command", command, "V"),
        "force": parse_quantity("--load", force, "N"),
        "band": parse_band(band),
    }
    measured: dict[str, Any] = {
        "amplitude": parse_quantity("--amplitude", amplitude, "V"),
        "periods": periods,
        "realisations": realisations,
        "excitation": excitation.value,
        "measure": not linear,
    }

    def ask(report: "Report") -> "xr.Dataset":
        if vary:
            ((path, entry),) = parse_ranges(vary).items()
            given = dict(map(parse_override, changes))
            loops, unit = loops_over(scenario, path, entry, VALUES, given, plugins, load_with_warnings)
            data = bode_over(loops, path, unit, **point)
        else:
            data = bode(loop, **point, **measured, progress=lambda done: report(done, scenario))
        return with_logs(data, loop, logs, log_columns_of(scenario, changes, plugins)) if logs else data

    def describe(data: "xr.Dataset") -> "Finding":
        finding = bode_finding(data, scenario, logs)
        return finding._replace(origins=[origin_of_loop(scenario, loop)]) if vary else finding

    answer(scenario, ask, describe)


def parse_band(text: str | None) -> tuple[float, float] | None:
    """Both ends of ``--band LOW..HIGH`` [Hz]."""
    from hydroservo.core.field import Field
    from hydroservo.scenario.ranges import as_entries, both_ends

    if text is None:
        return None
    (entry,) = as_entries({"--band": text}, "bode").values()
    return both_ends(entry, Field("Hz", "", above=0), None)
