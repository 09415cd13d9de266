"""The command that linearises a scenario."""

import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydroservo.cli.options import (
    Changes,
    CommandAt,
    DecimalComma,
    FigureFormat,
    FigureSize,
    Folder,
    Force,
    Json,
    Plugins,
    Scenario,
    checked_decimal_comma,
    loaded,
    quantity_of,
)

if TYPE_CHECKING:
    from rich.table import Table

    from hydroservo.linear import Linearization
    from hydroservo.linear.textbook import Textbook


class Unit(StrEnum):
    """What of a loop is linearised."""

    MACHINE = "machine"
    CONTROLLER = "controller"
    LOOP = "loop"


def linearize(
    context: typer.Context,
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    unit: Annotated[Unit, typer.Option("--unit", help="What to linearise.")] = Unit.MACHINE,
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
    out: Folder = None,
    figure_size: FigureSize = None,
    figure_format: FigureFormat = None,
    decimal_comma: DecimalComma = False,
    json: Json = False,
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
    from hydroservo.cli.files import list_files, result_files, write_results
    from hydroservo.cli.tables import show
    from hydroservo.cli.writing import try_outputs, write_or_keep
    from hydroservo.linear.linearize import linearized, point_of
    from hydroservo.linear.textbook import textbook
    from hydroservo.reports.folder import Files
    from hydroservo.reports.journal import journal_of
    from hydroservo.runs.results import as_json

    loop = loaded(scenario, changes, plugins)
    journal = journal_of(figure_format, figure_size, out, checked_decimal_comma(decimal_comma, out))
    if out:
        try_outputs(result_files(out, (), Files(["poles"], ["poles", "gains"], journal)))
    point = point_of(
        loop,
        unit.value,
        quantity_of("--command", command, "V"),
        quantity_of("--load", force, "N"),
        quantity_of("--at", at, "s"),
    )
    found = linearized(point, unit.value, sampled=sampled)
    said = as_object(scenario, found)
    book = textbook(point) if unit is Unit.MACHINE else None

    def write(place: Path) -> list[Path]:
        from hydroservo.cli.reporting import again
        from hydroservo.cli.reports.linearize import linearization_report

        page = linearization_report(again(context), scenario, loop, found, book)
        return write_results(place, {}, page, said, journal)

    left = write_or_keep(out, write)
    if json:
        typer.echo(as_json(said))
    else:
        show(poles_table(scenario, found), gains_table(found), *lines_of(found, book))
        list_files(left.files)
    left.check()


def as_object(scenario: str, found: "Linearization") -> dict[str, Any]:
    """What ``--json`` prints."""
    names = {what: [one.name for one in getattr(found, what)] for what in ("states", "inputs", "outputs")}
    units = {what: [one.unit for one in getattr(found, what)] for what in names}
    matrices = {name: getattr(found, name).tolist() for name in "ABCD"}
    return {
        "scenario": scenario,
        "unit": found.unit,
        "period": found.period or None,
        **names,
        "units": units,
        **matrices,
        "poles": [[pole.real, pole.imag] for pole in found.poles.tolist()],
        "frequencies": found.frequencies.tolist(),
        "damping": found.damping.tolist(),
        "inexact": [one._asdict() for one in found.inexact],
    }


def poles_table(scenario: str, found: "Linearization") -> "Table":
    """The poles; of a pair one."""
    from rich.markup import escape
    from rich.table import Table

    from hydroservo.formatting import number

    plane = f"z, {1e3 * found.period:.4g} ms apart" if found.period else "s [1/s]"
    poles = Table(title=f"{escape(scenario)}: {found.unit}", title_justify="left")
    for heading in (f"pole, {plane}", "natural frequency [Hz]", "damping ratio"):
        poles.add_column(heading, justify="right", no_wrap=True)
    for pole, frequency, damping in zip(found.poles, found.frequencies, found.damping, strict=True):
        if pole.imag >= 0.0:
            poles.add_row(as_text(pole), number(frequency / (2.0 * math.pi), 5), number(damping, 4))
    return poles


def gains_table(found: "Linearization") -> "Table":
    """The steady gain of each output by each input."""
    from rich.markup import escape
    from rich.table import Table

    from hydroservo.command_scale import in_command_unit
    from hydroservo.formatting import number

    inputs, outputs = (
        [(one.name, *in_command_unit(one.unit)) for one in each] for each in (found.inputs, found.outputs)
    )
    gains = Table(title="steady gain", title_justify="left")
    gains.add_column("of", no_wrap=True)
    for name, unit, _ in inputs:
        gains.add_column(escape(f"{name} [{unit}]"), justify="right")
    for out, unit, factor in outputs:
        shown = [number(factor * found.steady_gain(out, name) / own, 4) for name, _, own in inputs]
        gains.add_row(escape(f"{out} [{unit}]"), *shown)
    return gains


def lines_of(found: "Linearization", book: "Textbook | None") -> list[str]:
    """What the textbook says, and what is not exact."""
    from rich.markup import escape

    from hydroservo.formatting import number

    lines = []
    if book is not None:
        lines.append(
            f"By the textbook's formulas: {number(book.natural_frequency / (2.0 * math.pi), 5)} Hz, damping "
            f"ratio {number(book.damping_ratio, 4)} ({number(book.mass, 4)} kg on "
            f"{number(1e-6 * book.stiffness, 4)} kN/mm of oil)."
        )
    if found.inexact:
        lines.append("[yellow]From differences, for there is no slope[/]:")
        lines += [
            escape(f"  {one.of} by {one.by}: {number(one.value, 4)} ± {number(one.error, 2)}")
            for one in found.inexact
        ]
    return lines


def as_text(pole: complex) -> str:
    """A pole, or a pair of them."""
    from hydroservo.formatting import number

    return number(pole.real, 5) + (f" ± {number(pole.imag, 5)} j" if pole.imag > 0.0 else "")
