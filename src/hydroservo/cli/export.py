"""The commands that take a scenario to a target."""

import shlex
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo.cli.options import Changes, Json, Plugins, Scenario, loaded
from hydroservo.export.platforms import Platform, machine_name
from hydroservo.export.unit import FmiVersion, Part, Precision

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hydroservo.export.unit import Unit
    from hydroservo.loop import Loop

__all__ = ["export_app"]

export_app = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode="markdown",
    help="Write a scenario's controller, machine, equations, demand or whole loop as C99 or as FMUs.",
)


PartOption = Annotated[
    Part,
    typer.Option(
        "--unit",
        help="The controller with its observer and wrappers; the machine from its command to its sensors; "
        "its differential equations alone, for other integrators; the demand; or the whole closed loop.",
    ),
]
Prefix = Annotated[
    str | None,
    typer.Option(
        "--prefix",
        metavar="NAME",
        show_default="the scenario's name",
        help="What names begin with: a C identifier.",
    ),
]
OutFolder = Annotated[
    Path,
    typer.Option(
        "--out", metavar="DIR", file_okay=False, show_default=False, help="Write the C to this folder."
    ),
]
OutFile = Annotated[
    Path,
    typer.Option(
        "--out", metavar="FILE.fmu", dir_okay=False, show_default=False, help="Write the FMU to this file."
    ),
]

OutSystem = Annotated[
    Path,
    typer.Option(
        "--out", metavar="FILE.ssp", dir_okay=False, show_default=False, help="Write the system to this file."
    ),
]
Version = Annotated[FmiVersion, typer.Option("--fmi", help="Version of the standard.")]
Platforms = Annotated[
    list[Platform],
    typer.Option(
        "--platform",
        metavar="NAME",
        default_factory=list,
        show_default="that of this computer",
        help="What a binary is for, by its name in FMI 3.0: `x86_64-linux`, `aarch64-linux` or "
        "`x86_64-windows`, with a cross compiler where that is not this computer; others on such a computer "
        "alone. May be given again.",
    ),
]


@export_app.command("c")
def c(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    out: OutFolder,
    part: PartOption = Part.CONTROLLER,
    prefix: Prefix = None,
    precision: Annotated[
        Precision, typer.Option("--precision", help="Of all numbers in the C; single for a controller alone.")
    ] = Precision.DOUBLE,
    inline: Annotated[
        bool,
        typer.Option("--inline", help="Write the parameters into the source; they are a record otherwise."),
    ] = False,
    json: Json = False,
) -> None:
    """Write C99 with test vectors, a program that replays them, a Makefile and a README.

    In double precision the C gives the bits of the strict simulation. Where this computer has a C compiler it
    is held against Python before it is written, on samples that reach all branches for which some are found;
    gcov counts them. Other files in the folder are left alone.

    Examples:

    - `hydroservo export c paper/sine-tsmc --out controller`
    - `hydroservo export c rig/encoder-pi-sine --out controller --prefix rig --precision single --inline`
    """
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.proofs import proof_line
    from hydroservo.cli.writing import write_or_keep
    from hydroservo.export.c.project import check_project, memory, write_c_project
    from hydroservo.export.c.proof import proven_vectors
    from hydroservo.results import as_json

    loop = loaded(scenario, changes, plugins)
    check_project(out)  # before anything is computed; the names of the sources are known after it
    with progress_bar("translating") as report:
        unit = translated(scenario, loop, part, prefix, precision=precision, inlined=inline)
        check_project(out, unit.prefix)
        report(0.2, "making test vectors, and replaying them")
        vectors, proof = proven_vectors(loop, part, unit)
        report(0.9, "writing files")
        left = write_or_keep(out, lambda place: write_c_project(unit, vectors, place, proof))
        left.check()
    sizes, files = memory(unit), list(map(str, left.files))
    if json:
        about = {**identity(scenario, part, unit), **sizes._asdict(), "proof": proof._asdict()}
        typer.echo(as_json({**about, "files": files}))
        return
    typer.echo(
        f"{unit.title}: {sizes.state_bytes} bytes of state, {sizes.parameter_bytes} of parameters, "
        f"{precision} precision"
    )
    typer.echo(proof_line(proof, unit.prefix))
    typer.echo(f"written to {out}: {', '.join(file.name for file in left.files)}")
    typer.echo(f"next: make -C {shlex.quote(str(out))} check")


@export_app.command("fmu")
def fmu(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    out: OutFile,
    part: PartOption = Part.CONTROLLER,
    prefix: Prefix = None,
    version: Version = FmiVersion.FMI2,
    clocked: Annotated[
        bool,
        typer.Option("--clocked", help="Samples are the ticks of a clock; of a controller, in FMI 3.0."),
    ] = False,
    *,
    platforms: Platforms,
    json: Json = False,
) -> None:
    """Write a functional mock-up unit: of a machine's equations for model exchange, else for co-simulation.

    A communication step is the scenario's sample period, or any with a clock. The file holds C and a binary
    for each platform, no Python. The C is held against Python before it is written, as for export c; binaries
    for other platforms are not run.

    Examples:

    - `hydroservo export fmu paper/sine-tsmc --out controller.fmu`
    - `hydroservo export fmu rig/encoder-pi-sine --unit machine --fmi 3 --out machine.fmu`
    - `hydroservo export fmu rig/excavator-link --unit equations --out axis.fmu`
    - `hydroservo export fmu rig/1khz-tsmc-sine --fmi 3 --clocked --out controller.fmu`
    - `hydroservo export fmu paper/sine-pi --platform x86_64-linux --platform x86_64-windows --out pi.fmu`
    """
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.proofs import proof_line
    from hydroservo.cli.writing import write_or_keep
    from hydroservo.export.c.proof import proven_vectors
    from hydroservo.export.fmu import check_clock, check_tools, checked_ending, write_fmu
    from hydroservo.outputs import check_outputs
    from hydroservo.results import as_json

    loop = loaded(scenario, changes, plugins)
    check_outputs([checked_ending(out)])
    if clocked:
        check_clock(version, part)
    platforms = check_tools(platforms)
    stop_time = loop.simulation.duration
    with progress_bar("translating") as report:
        unit = translated(scenario, loop, part, prefix)
        report(0.2, "making test vectors, and replaying them")
        _, proof = proven_vectors(loop, part, unit)
        report(0.9, "writing the FMU")
        write_or_keep(
            out.parent,
            lambda place: [
                write_fmu(
                    unit,
                    place / out.name,
                    stop_time=stop_time,
                    version=version,
                    clocked=clocked,
                    platforms=platforms,
                )
            ],
        ).check()
    if json:
        about = {**identity(scenario, part, unit), "proof": proof._asdict()}
        written = {"fmi": version, "clocked": clocked, "platforms": platforms, "file": str(out)}
        typer.echo(as_json(about | written))
        return
    typer.echo(summary(unit, version, clocked))
    typer.echo(proof_line(proof, unit.prefix))
    typer.echo(f"written: {out}, {out.stat().st_size / 1024:.0f} KiB, for {', '.join(platforms)}")
    say_untried(platforms)
    typer.echo(f"next: fmpy validate {shlex.quote(str(out))}")


@export_app.command("ssp")
def ssp(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    out: OutSystem,
    version: Version = FmiVersion.FMI2,
    *,
    platforms: Platforms,
    json: Json = False,
) -> None:
    """Write the demand, the controller and the machine as FMUs, and how they are connected.

    A tool that asks for outputs in the order of their dependencies closes the loop as it is simulated. Each C
    is held against Python before it is written, as for export c.

    Examples:

    - `hydroservo export ssp rig/1khz-tsmc-sine --out loop.ssp`
    """
    from hydroservo.cli.progress import progress_bar
    from hydroservo.cli.proofs import proof_line
    from hydroservo.cli.writing import write_or_keep
    from hydroservo.export.c.proof import proven_vectors
    from hydroservo.export.fmu import PARTS, check_tools, checked_ending, write_ssp
    from hydroservo.outputs import check_outputs
    from hydroservo.results import as_json

    loop = loaded(scenario, changes, plugins)
    check_outputs([checked_ending(out, ".ssp")])
    platforms = check_tools(platforms)
    stop_time = loop.simulation.duration
    with progress_bar("translating") as report:
        units = {part: translated(scenario, loop, part, None) for part in PARTS}
        proofs = {}
        for i, part in enumerate(PARTS):
            report(0.2 + 0.2 * i, f"making test vectors of the {part}, and replaying them")
            proofs[part] = proven_vectors(loop, part, units[part])[1]
        report(0.9, "writing the system")
        write_or_keep(
            out.parent,
            lambda place: [
                write_ssp(units, place / out.name, stop_time=stop_time, version=version, platforms=platforms)
            ],
        ).check()
    if json:
        about = [identity(scenario, part, units[part]) | {"proof": proofs[part]._asdict()} for part in PARTS]
        typer.echo(as_json({"units": about, "fmi": version, "platforms": platforms, "file": str(out)}))
        return
    for part in PARTS:
        typer.echo(f"{units[part].title}: {proof_line(proofs[part], units[part].prefix)}")
    period = units[PARTS[0]].period
    size = f"{out.stat().st_size / 1024:.0f} KiB"
    typer.echo(f"written: {out}, {size}, FMI {version}, steps of {period:g} s, for {', '.join(platforms)}")
    say_untried(platforms)


def translated(
    scenario: str,
    loop: "Loop",
    part: Part,
    prefix: str | None,
    *,
    precision: Precision = Precision.DOUBLE,
    inlined: bool = False,
) -> "Unit":
    """The export of a scenario's part."""
    from hydroservo.export.of_loop import exported_unit
    from hydroservo.export.prefix import default_prefix

    name = default_prefix(scenario, part) if prefix is None else prefix
    about = title(scenario, loop, part)
    return exported_unit(loop, part, prefix=name, title=about, precision=precision, inlined=inlined)


def summary(unit: "Unit", version: FmiVersion, clocked: bool) -> str:
    """What an FMU has, and how it is used."""
    from hydroservo.export.fmu import variables_of

    kinds = Counter(one.causality for one in variables_of(unit))
    counts = [counted(kinds[kind], kind) for kind in ("input", "output")]
    parameters = counted(len(unit.parameters), "parameter")
    samples = f"{'a clock' if clocked else 'steps'} of {unit.period:g} s"
    use = "model exchange" if unit.part is Part.EQUATIONS else samples
    return f"{unit.title}: {', '.join([*counts, parameters])}, FMI {version}, {use}"


def say_untried(platforms: "Sequence[Platform]") -> None:
    """Say of which platforms nothing was run here."""
    others = [one for one in platforms if one != machine_name()]
    if others:
        typer.echo(f"cross compiled, and not run here: the binaries for {', '.join(others)}")


def counted(number: int, what: str) -> str:
    """Such as ``1 input`` or ``2 inputs``."""
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def title(scenario: str, loop: "Loop", part: Part) -> str:
    """What is exported, such as "TSMC of scenario paper/sine-tsmc"."""
    from hydroservo.scenario import builtin_scenarios
    from hydroservo.simulate import named

    what = named(loop.controller, "controller") if part is Part.CONTROLLER else part.value.capitalize()
    name = scenario if scenario in builtin_scenarios() else Path(scenario).stem
    return f"{what} of scenario {name}"


def identity(scenario: str, part: Part, unit: "Unit") -> dict[str, object]:
    """What names an export in JSON."""
    return {
        "scenario": scenario,
        "hash": unit.hash,
        "version": unit.version,
        "unit": part,
        "prefix": unit.prefix,
        "precision": "single" if unit.real == "float" else "double",
        "period": unit.period,
    }
