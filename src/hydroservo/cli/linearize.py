"""The command that linearises a scenario."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo.cli.frame import CommandOutput, with_output
from hydroservo.cli.options import Changes, CommandAt, Force, Plugins, Scenario, load_loop, parse_quantity

if TYPE_CHECKING:
    from hydroservo.linear import Linearization
    from hydroservo.linear.textbook import Textbook


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
    answer: CommandOutput,
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
    from hydroservo.linear.linearization_finding import linearization_finding
    from hydroservo.linear.linearize import linearized, point_of
    from hydroservo.linear.textbook import textbook

    loop = load_loop(scenario, changes, plugins)
    at_command, at_force = parse_quantity("--command", command, "V"), parse_quantity("--load", force, "N")
    time = parse_quantity("--at", at, "s")

    def ask(_: object) -> "tuple[Linearization, Textbook | None]":
        point = point_of(loop, unit.value, at_command, at_force, time)
        model = linearized(point, unit.value, sampled=sampled)._replace(loop=loop)
        return model, textbook(point) if unit is LinearizedPart.MACHINE else None

    answer(scenario, ask, lambda found: linearization_finding(found[0], scenario, found[1]))
