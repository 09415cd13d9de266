"""The command that shows a scenario in frequency."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydroservo.cli.options import (
    VARY,
    Changes,
    CommandAt,
    DecimalComma,
    FigureFormat,
    FigureSize,
    Force,
    Json,
    Plugins,
    Scenario,
    checked_decimal_comma,
    loaded,
    loaded_aloud,
    log_columns_of,
    quantity_of,
    ranges_in,
)
from hydroservo.cli.places import WHERE, file_or_folder
from hydroservo.cli.remarks import say_remarks

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

RESPONSES = ("machine", "open", "closed", "sensitivity", "compliance", "open_compliance")
VALUES = 5  # of a range, evenly


class Excitation(StrEnum):
    """What a loop is excited with."""

    MULTISINE = "multisine"
    CHIRP = "chirp"


def bode(
    context: typer.Context,
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    logs: Annotated[
        list[Path],
        typer.Option(
            "--log",
            metavar="FILE",
            default_factory=list,
            show_default=False,
            help="Show what a recorded log says beside it: a table with the command or the demand "
            "(`reference`) and what is controlled, as of `identify`. May be given again.",
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
        Excitation, typer.Option("--excitation", help="Many tones at once, or one of rising frequency.")
    ] = Excitation.MULTISINE,
    periods: Annotated[int, typer.Option("--periods", help="Periods of the excitation to measure.")] = 2,
    realisations: Annotated[
        int, typer.Option("--realisations", help="Experiments, each with random phases of its own.")
    ] = 4,
    linear: Annotated[
        bool, typer.Option("--linear", help="Only the linear model, nothing measured.")
    ] = False,
    out: Annotated[
        str | None,
        typer.Option(
            "--out",
            metavar="FILE|DIR",
            help=f"Draw it: a .png, .svg or .pdf. Into a folder goes a report too. {WHERE}",
        ),
    ] = None,
    figure_size: FigureSize = None,
    figure_format: FigureFormat = None,
    decimal_comma: DecimalComma = False,
    json: Json = False,
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
    from hydroservo.cli.files import list_files, result_files, write_results
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.tables import show
    from hydroservo.cli.writing import try_outputs, write_or_keep
    from hydroservo.identification.recorded import with_logs
    from hydroservo.linear.bode import bode as bode_of
    from hydroservo.reports.folder import Files
    from hydroservo.reports.journal import journal_of
    from hydroservo.runs.results import as_json

    loop = loaded(scenario, changes, plugins)  # first, for commands are read in its unit
    volts = quantity_of("--amplitude", amplitude, "V")
    point: dict[str, Any] = {
        "command": quantity_of("--command", command, "V"),
        "force": quantity_of("--load", force, "N"),
        "band": band_in(band),
    }
    file, folder = destination(out)
    journal = journal_of(figure_format, figure_size, folder, checked_decimal_comma(decimal_comma, folder))
    if file:
        try_outputs([file])
    if folder:
        try_outputs(result_files(folder, (), Files(["bode"], ["margins"], journal)))
    with progress_bar(scenario) as report:
        if not vary:
            asked: dict[str, Any] = {"amplitude": volts, "periods": periods, "realisations": realisations}
            data = bode_of(
                loop,
                **point,
                **asked,
                excitation=excitation.value,
                measure=not linear,
                progress=lambda done: report(done, scenario),
            )
        else:
            data = varied(one_range(vary), scenario, changes, plugins, point)
        if logs:
            data = with_logs(data, loop, logs, log_columns_of(scenario, changes, plugins))
        said = as_object(scenario, data)
        if file:
            draw(data, file)

        def write(place: Path) -> list[Path]:
            from hydroservo.cli.reporting import again
            from hydroservo.cli.reports.bode import bode_report

            page = bode_report(again(context), scenario, data, logs)
            return write_results(place, {}, page, said, journal)

        left = write_or_keep(folder, write)
    say_remarks(scenario, data)
    if json:
        typer.echo(as_json(said))
    else:
        show(margins_table(scenario, data), *lines_of(data))
        if file:
            typer.echo(f"written: {file}")
        list_files(left.files)
    left.check()


def destination(out: str | None) -> tuple[Path | None, Path | None]:
    """The picture that ``--out`` names, or the folder.

    Raises:
        ParameterError: its ending names no format.
    """
    from hydroservo.cli.files import PICTURE_ENDINGS
    from hydroservo.errors import ParameterError

    file, folder = file_or_folder(out)
    if file and file.suffix.lower() not in PICTURE_ENDINGS:
        allowed = f"must end in one of {', '.join(PICTURE_ENDINGS)}, or in a / for a folder"
        raise ParameterError("--out", str(file), allowed)
    return file, folder


def one_range(vary: list[str]) -> str:
    """The only range.

    Raises:
        ParameterError: there are more.
    """
    from hydroservo.errors import ParameterError

    if len(vary) > 1:
        raise ParameterError(VARY, ", ".join(vary), "must be one number: five values of it are a picture")
    return vary[0]


def band_in(text: str | None) -> tuple[float, float] | None:
    """Both ends of ``--band LOW..HIGH`` [Hz].

    Raises:
        ScenarioError: it is no such range.
    """
    from hydroservo.field import Field
    from hydroservo.scenario.ranges import as_entries, both_ends

    if text is None:
        return None
    (entry,) = as_entries({"--band": text}).values()
    entry = entry._replace(origin=entry.origin._replace(name="bode"))
    return both_ends(entry, Field("Hz", "", above=0), None)


def varied(
    vary: str,
    scenario: str,
    changes: list[str],
    plugins: list[Path],
    point: dict[str, Any],
) -> "xr.Dataset":
    """The linear model for values of a number, evenly over its range; a law believes what it believed."""
    import numpy as np

    from hydroservo.block import field_at
    from hydroservo.linear.bode import bode_over
    from hydroservo.scenario import assembled, parse_override
    from hydroservo.scenario.load import Machine
    from hydroservo.scenario.sampling import variation

    ((path, entry),) = ranges_in([vary]).items()
    given = dict(map(parse_override, changes))
    whole = assembled(scenario, given, plugins)
    one = variation(whole, path, entry)
    field = whole.arguments[path].field if path in whole.arguments else field_at(whole.loop, path)
    name = f"truth.{path}" if path.partition(".")[0] in Machine._fields else path
    loops = {}
    for value in np.linspace(one.low, one.high, VALUES).tolist():
        loops[value] = loaded_aloud(scenario, given | {name: value}, plugins)
    return bode_over(loops, path, field.unit, **point)


def draw(data: "xr.Dataset", out: Path) -> None:
    """Write the picture."""
    from hydroservo.figures.bode import plot_bode
    from hydroservo.figures.style import save_picture

    save_picture(plot_bode(data), out, data.attrs["hash"])


def as_object(scenario: str, data: "xr.Dataset") -> dict[str, Any]:
    """What ``--json`` prints: of several points a list of what it prints of one."""
    if "point" in data.dims:
        name, unit = data["point"].attrs["long_name"], data["point"].attrs["units"]
        values = data["point"].values.tolist()
        points = [{"value": value, **of_point(data.isel(point=i))} for i, value in enumerate(values)]
        return {"scenario": scenario, "varied": name, "unit": unit, "points": points, "logs": of_logs(data)}
    return {"scenario": scenario, "hash": data.attrs["hash"], **of_point(data), "logs": of_logs(data)}


def of_point(data: "xr.Dataset") -> dict[str, Any]:
    """The numbers and the responses about one point."""
    numbers = {str(name): one.values.tolist() for name, one in data.data_vars.items() if not plotted(one)}
    found = {
        name: curve(data["frequency"], data[name]) | {"unit": data[name].attrs["units"]} for name in RESPONSES
    }
    for name in RESPONSES:
        if f"{name}_measured" in data:
            coherence = data[f"{name}_coherence"].values.tolist()
            found[name]["measured"] = curve(data["tone"], data[f"{name}_measured"]) | {"coherence": coherence}
    return {"command": data.attrs.get("command"), "force": data.attrs.get("force"), **numbers, **found}


def of_logs(data: "xr.Dataset") -> list[dict[str, Any]]:
    """What each log tells, by the name of the response."""
    import numpy as np

    found = []
    names = data["log"].values if "log" in data.coords else np.array([], dtype=object)
    for log in dict.fromkeys(names.tolist()):
        told: dict[str, Any] = {"log": log}
        for name in ("machine", "closed"):
            coherence = data[f"{name}_recorded_coherence"]
            own = data.isel(recorded=np.flatnonzero((names == log) & coherence.notnull()))
            if own.sizes["recorded"]:
                said = curve(own["recorded"], own[f"{name}_recorded"])
                told[name] = said | {"coherence": own[f"{name}_recorded_coherence"].values.tolist()}
        found.append(told)
    return found


def plotted(one: "xr.DataArray") -> bool:
    """Whether it is a curve and no number."""
    return bool({"frequency", "tone", "recorded"} & set(one.dims))


def curve(frequencies: "xr.DataArray", response: "xr.DataArray") -> dict[str, Any]:
    """A response as sizes and phases [rad], over frequencies [Hz]."""
    import numpy as np

    return {
        "frequency": frequencies.values.tolist(),
        "magnitude": np.abs(response.values).tolist(),
        "phase": np.unwrap(np.angle(response.values)).tolist(),
    }


def points_of(data: "xr.Dataset") -> "list[xr.Dataset]":
    """What is known about each point."""
    return [data.isel(point=i) for i in range(data.sizes["point"])] if "point" in data.dims else [data]


def margins_table(scenario: str, data: "xr.Dataset") -> "Table":
    """Margins and bandwidths, a column for each point."""
    from rich.markup import escape
    from rich.table import Table

    from hydroservo.cli.tables import NO_NUMBER
    from hydroservo.formatting import quantity
    from hydroservo.linear.reading import READ, read_as

    points = points_of(data)
    table = Table(title=escape(scenario), title_justify="left")
    table.add_column(escape(data["point"].attrs["long_name"]) if "point" in data.dims else "quantity")
    for one in points:
        heading = "value"
        if "point" in data.dims:
            heading = quantity(float(one["point"]), one["point"].attrs["units"])
        table.add_column(heading, justify="right", no_wrap=True)
    for name, (text, unit) in READ.items():
        table.add_row(text, *(read_as(float(one[name]), unit, NO_NUMBER) for one in points))
    return table


def measured_line(data: "xr.Dataset") -> str:
    """The margins that were measured, or why there are none."""
    from hydroservo.cli.tables import NO_NUMBER
    from hydroservo.formatting import number
    from hydroservo.linear.measured_margins import measured_margins
    from hydroservo.linear.reading import READ, read_as

    said = []
    for name, one in zip(("gain_margin", "phase_margin"), measured_margins(data), strict=True):
        text, unit = READ[name]
        why = one.remark or f"at {number(one.frequency)} Hz"
        said.append(f"{text} {read_as(one.margin, unit, NO_NUMBER)} ({why})")
    return f"Measured: {', '.join(said)}."


def lines_of(data: "xr.Dataset") -> list[str]:
    """What a reader should know of the responses."""
    from rich.markup import escape

    from hydroservo.formatting import number

    lines, points = [], points_of(data)
    if any(float(one["oscillation_gain"]) == 1.0 for one in points):
        lines.append("[bold red]The loop oscillates[/] as it stands, so it has no margins.")
    elif not all(bool(one["stable"]) for one in points):
        lines.append("[bold red]Unstable[/] for small motions, so the loop has no margins.")
    for one in points:
        if "tone" in one.coords:
            least = {name: float(one[f"{name}_coherence"].min()) for name in ("open", "closed", "compliance")}
            said = ", ".join(f"{name} {value:.3f}" for name, value in least.items())
            lines.append(f"Measured at {one.sizes['tone']} frequencies; least coherence: {said}.")
            lines.append(measured_line(one))
    for told in of_logs(points[0]):
        for name in ("machine", "closed"):
            if name in told:
                high = [
                    f
                    for f, one in zip(told[name]["frequency"], told[name]["coherence"], strict=True)
                    if one > 0.95
                ]
                band = f"{number(min(high))} to {number(max(high))} Hz" if high else "none"
                lines.append(escape(f"{told['log']}: {name}, coherence above 0.95: {band}."))
    return lines
