"""The command that asks whether a loop is what its law assumes."""

from enum import StrEnum
from functools import partial
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

    from hydroservo.cli.messages import Report
    from hydroservo.linear import Linearization
    from hydroservo.linear.textbook import Textbook
    from hydroservo.show import Finding


VALUES = 5  # of a range, evenly


@with_output()
def audit_command(scenario: Scenario, changes: Changes, plugins: Plugins, output: CommandOutput) -> None:
    """Check what a scenario's law assumes, whether its loop oscillates and why, and predict its chatter.

    Each assumption has a margin, the factor by which it holds: bounds on disturbances, the sample rate, the
    valve's lag, noise, limits. Those measured on a run say when it was worst. Where that run oscillates to
    its end, it goes on without each possible cause in turn, and what ends the oscillation is named. Chatter
    is predicted by harmonic balance, without a run. With --out it also writes a report (report.html, its
    tables as CSV and LaTeX in tables), a picture of the margins (margins.png, margins.svg) and the numbers
    (metrics.json).

    Examples:

    - `hydroservo audit paper/sine-tsmc`
    - `hydroservo audit rig/1khz-tsmc-sine --set valve.time_constant=4ms --out audit`
    """
    from hydroservo.audits import audit
    from hydroservo.audits.finding import audit_finding

    loop = load_loop(scenario, changes, plugins)
    output.present(scenario, lambda _: audit(loop), partial(audit_finding, scenario=scenario))


@with_output()
def limit_command(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    output: CommandOutput,
    periods: Annotated[
        str | None,
        typer.Option(
            "--period",
            metavar="TIME,TIME,...",
            help="Do so at each of these sample periods, `1ms,2ms,4ms`. The law keeps its gains, and a "
            "computing delay its share of the period.",
        ),
    ] = None,
) -> None:
    """Show how close a scenario's law comes to the best that any command could do.

    The commands with the least rms error are found by optimal control of the same machine, at the same
    sample rate and within the limits of the command, and played back: where all is known in advance
    (clairvoyant), and where jumps of demand and load are known only once they are there (causal). That takes
    from seconds to minutes. With --out it also writes a report (report.html, its tables as CSV and LaTeX in
    tables), a picture of the three runs (limit.png, limit.svg), the trajectory of each (law.csv, causal.csv,
    clairvoyant.csv) and the numbers (metrics.json). With --period there are no trajectories, and the picture
    is of the errors over the sample period (limits.png, limits.svg).

    Examples:

    - `hydroservo limit rig/1khz-pi-square`
    - `hydroservo limit rig/1khz-pi-square --set valve.time_constant='5 ms' --out limit`
    - `hydroservo limit rig/1khz-pi-square --set simulation.duration=0.4s --period 1ms,2ms,4ms,10ms`
    """
    from hydroservo.limits import limit, limit_over_periods
    from hydroservo.limits.finding import MEANINGS, limits_finding, over_periods_finding
    from hydroservo.runs.trace import trace_size

    loop = load_loop(scenario, changes, plugins)
    if periods is not None:
        wanted = parse_periods(periods, loop.simulation.duration)
        output.present(
            scenario,
            lambda report: limit_over_periods(loop, wanted, progress=lambda done: report(done, scenario)),
            partial(over_periods_finding, scenario=scenario),
        )
        return
    output.present(
        scenario,
        lambda report: limit(loop, progress=lambda fraction: report(fraction, scenario)),
        partial(limits_finding, scenario=scenario),
        size=len(MEANINGS) * trace_size(loop) if output.folder else 0,
    )


def parse_periods(text: str, duration: float) -> list[float]:
    """The times of ``--period TIME,TIME,...`` [s] of a run of some duration."""
    from hydroservo.limits.over_periods import checked_periods

    periods = [parse_quantity("--period", part.strip(), "s") or 0.0 for part in text.split(",")]
    try:
        return checked_periods(periods, duration)
    except ParameterError as error:
        raise ParameterError("--period", error.value, error.allowed) from None


class LinearizedPart(StrEnum):
    """What of a loop is linearised."""

    MACHINE = "machine"
    CONTROLLER = "controller"
    LOOP = "loop"


@with_output()
def linearize_command(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    *,
    unit: Annotated[
        LinearizedPart, typer.Option("--unit", help="What to linearise.")
    ] = LinearizedPart.MACHINE,
    command: CommandAt = None,
    force: Force = None,
    at: Annotated[
        str | None,
        typer.Option(
            "--at", metavar="TIME", help="Linearise at this instant of the run, settled or not: `0.5s`."
        ),
    ] = None,
    sampled: Annotated[
        bool,
        typer.Option(
            "--sampled", help="The machine from sample to sample, behind the loop's hold and delay."
        ),
    ] = False,
    output: CommandOutput,
) -> None:
    """Linearise a scenario's machine, its controller or the whole loop, about a point.

    The point is where the machine has settled under a command and a load, or an instant of the run. It prints
    poles, natural frequencies and damping, beside what a textbook's formulas say of the oil's spring; with
    --json the matrices too. Slopes are exact; where a kink leaves none it says so, and how much they may be
    off. With --out it also writes a report (report.html, its tables as CSV and LaTeX in tables), a picture of
    the poles (poles.png, poles.svg) and the matrices (metrics.json).

    Examples:

    - `hydroservo linearize axis/force`
    - `hydroservo linearize rig/1khz-pi-sine --unit loop --command 0.1V --load 200N --json`
    - `hydroservo linearize rig/1khz-tsmc-sine --set plant.bulk_modulus=9000bar --at 0.25s --out model`
    """
    from hydroservo.linear.finding import linearization_finding
    from hydroservo.linear.linearize import linearization_at, linearization_point
    from hydroservo.linear.textbook import textbook

    loop = load_loop(scenario, changes, plugins)
    at_command, at_force = parse_quantity("--command", command, "V"), parse_quantity("--load", force, "N")
    time = parse_quantity("--at", at, "s")

    def ask(_: object) -> "tuple[Linearization, Textbook | None]":
        point = linearization_point(loop, unit.value, at_command, at_force, time)
        model = linearization_at(point, unit.value, sampled=sampled)._replace(loop=loop)
        return model, textbook(point) if unit is LinearizedPart.MACHINE else None

    output.present(scenario, ask, lambda found: linearization_finding(found[0], scenario, found[1]))


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
    output: CommandOutput,
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
    from hydroservo.identification.log_responses import with_logs
    from hydroservo.linear.bode import bode, bode_over
    from hydroservo.linear.finding import bode_finding
    from hydroservo.runs.provenance import origin_of_loop
    from hydroservo.scenario import parse_override
    from hydroservo.scenario.parameter_draws import loops_over

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

    output.present(scenario, ask, describe)


def parse_band(text: str | None) -> tuple[float, float] | None:
    """Both ends of ``--band LOW..HIGH`` [Hz]."""
    from hydroservo.core.field import Field
    from hydroservo.scenario.ranges import as_entries, both_ends

    if text is None:
        return None
    (entry,) = as_entries({"--band": text}, "bode").values()
    return both_ends(entry, Field("Hz", "", above=0), None)
