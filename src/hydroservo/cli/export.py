"""The commands that take a scenario to a target."""

import shlex
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydroservo.cli.messages import progress_bar
from hydroservo.cli.options import (
    WHERE,
    Changes,
    Json,
    Plugins,
    Scenario,
    file_at,
    folder_at,
    list_option,
    load_loop,
    parse_ranges,
)
from hydroservo.core.formatting import counted
from hydroservo.export.compilers import Platform, machine_name, platforms_named
from hydroservo.export.unit import FmiVersion, Part, Precision

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hydroservo.export.unit import CModule

export_app = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode="markdown",
    help="Write a scenario's controller, machine, equations, demand or loop as C99, Structured Text or FMUs, "
    "or as a page that runs it.",
)
SLIDER = "--slider"

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
    typer.Option("--prefix", metavar="NAME", show_default="the scenario's name", help="Prefix of all names."),
]

Digits = Annotated[
    Precision, typer.Option("--precision", help="Precision of all numbers; single for controllers only.")
]
Inline = Annotated[
    bool, typer.Option("--inline", help="Write the parameters as constants that cannot be changed later.")
]


def out_option(parser: Callable[[str], Path], metavar: str, what: str) -> Any:
    """The option for the place that an export is written to."""
    text = f"Write {what}. {WHERE}"
    return typer.Option("--out", metavar=metavar, parser=parser, show_default=False, help=text)


OutFolder = Annotated[Path, out_option(folder_at, "DIR", "the C to this folder")]
OutST = Annotated[Path, out_option(folder_at, "DIR", "the Structured Text to this folder")]
OutFile = Annotated[Path, out_option(file_at, "FILE.fmu", "the FMU to this file")]
OutPage = Annotated[Path, out_option(file_at, "FILE.html", "the page to this file")]
OutSystem = Annotated[Path, out_option(file_at, "FILE.ssp", "the system to this file")]
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
def export_c_command(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    out: OutFolder,
    part: PartOption = Part.CONTROLLER,
    prefix: Prefix = None,
    precision: Digits = Precision.DOUBLE,
    inline: Inline = False,
    json: Json = False,
) -> None:
    """Write C99 with test vectors, a program that replays them, a Makefile and a README.

    In double precision the C gives the bits of the strict simulation. Where this computer has a C compiler it
    is held against Python before it is written, on samples of the closed loop. Other files in the folder are
    left alone.

    Examples:

    - `hydroservo export c paper/sine-tsmc --out controller`
    - `hydroservo export c rig/encoder-pi-sine --out controller --prefix rig --precision single --inline`
    """
    from hydroservo.export.c.project import memory_size
    from hydroservo.export.products import export_c, proof_line
    from hydroservo.show.files import as_json

    options = {"part": part, "prefix": prefix, "precision": precision, "inlined": inline}
    unit, proof, files = export_loop(export_c, scenario, changes, plugins, out, **options)
    sizes = memory_size(unit)
    if json:
        about = {**export_identity(scenario, unit), **sizes._asdict(), "proof": proof._asdict()}
        typer.echo(as_json({**about, "files": list(map(str, files))}))
        return
    typer.echo(
        f"{unit.title}: {sizes.state_bytes} bytes of state, {sizes.parameter_bytes} of parameters, "
        f"{precision} precision"
    )
    typer.echo(proof_line(proof))
    typer.echo(f"written to {out}: {', '.join(file.name for file in files)}")
    typer.echo(f"next: make -C {shlex.quote(str(out))} check")


@export_app.command("st")
def export_st_command(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    out: OutST,
    part: Annotated[
        Part, typer.Option("--unit", help="`controller`, with its observer and wrappers, or `demand`.")
    ] = Part.CONTROLLER,
    prefix: Prefix = None,
    precision: Digits = Precision.DOUBLE,
    inline: Inline = False,
    json: Json = False,
) -> None:
    """Write a controller or a demand as a function block in Structured Text (IEC 61131-3) for a PLC.

    The folder has it as text, as PLCopen XML and as TwinCAT's files, with a block that replays samples of the
    simulation on the PLC, and a README. The same functions in C are held against Python before anything is
    written; no PLC compiler runs here.

    Examples:

    - `hydroservo export st axis/position --out plc`
    - `hydroservo export st axis/position --unit demand --out profile`
    - `hydroservo export st rig/encoder-pi-sine --out plc --prefix rig --precision single --inline`
    """
    from hydroservo.export.products import export_st, proof_line
    from hydroservo.show.files import as_json

    options = {"part": part, "prefix": prefix, "precision": precision, "inlined": inline}
    unit, proof, files = export_loop(export_st, scenario, changes, plugins, out, **options)
    if json:
        about = {**export_identity(scenario, unit), "proof": proof._asdict()}
        typer.echo(as_json({**about, "files": list(map(str, files))}))
        return
    real = "REAL" if precision is Precision.SINGLE else "LREAL"
    typer.echo(f"{unit.title}: function block fb_{unit.prefix}, {real}, for a task of {unit.period:g} s")
    typer.echo(f"C of the same functions: {proof_line(proof)}")
    top = [file.name for file in files if file.parent == out]
    typer.echo(f"written to {out}: {', '.join(top)}; and {len(files) - len(top)} files in {out / 'twincat'}")
    typer.echo(f"next: import {unit.prefix}.xml, or the files of twincat, into your PLC project")


@export_app.command("fmu")
def export_fmu_command(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    out: OutFile,
    part: PartOption = Part.CONTROLLER,
    prefix: Prefix = None,
    version: Version = FmiVersion.FMI2,
    clocked: Annotated[
        bool,
        typer.Option(
            "--clocked", help="Take samples at the ticks of a clock; for controllers in FMI 3.0 only."
        ),
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
    from hydroservo.export.products import export_fmu, proof_line
    from hydroservo.show.files import as_json

    platforms = platforms_named(platforms)
    options = {"part": part, "prefix": prefix, "version": version, "clocked": clocked, "platforms": platforms}
    unit, proof, _ = export_loop(export_fmu, scenario, changes, plugins, out, **options)
    if json:
        about = {**export_identity(scenario, unit), "proof": proof._asdict()}
        written = {"fmi": version, "clocked": clocked, "platforms": platforms, "file": str(out)}
        typer.echo(as_json(about | written))
        return
    typer.echo(fmu_summary(unit, version, clocked))
    typer.echo(proof_line(proof))
    typer.echo(f"written: {out}, {out.stat().st_size / 1024:.0f} KiB, for {', '.join(platforms)}")
    print_untried_platforms(platforms)
    typer.echo(f"next: fmpy validate {shlex.quote(str(out))}")


@export_app.command("ssp")
def export_ssp_command(
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
    from hydroservo.export.products import export_ssp, proof_line
    from hydroservo.show.files import as_json

    platforms = platforms_named(platforms)
    options = {"version": version, "platforms": platforms}
    exports = export_loop(export_ssp, scenario, changes, plugins, out, **options)
    if json:
        about = [export_identity(scenario, unit) | {"proof": proof._asdict()} for unit, proof, _ in exports]
        typer.echo(as_json({"units": about, "fmi": version, "platforms": platforms, "file": str(out)}))
        return
    for unit, proof, _ in exports:
        typer.echo(f"{unit.title}: {proof_line(proof)}")
    period, size = exports[0].unit.period, f"{out.stat().st_size / 1024:.0f} KiB"
    typer.echo(f"written: {out}, {size}, FMI {version}, steps of {period:g} s, for {', '.join(platforms)}")
    print_untried_platforms(platforms)


@export_app.command("page")
def export_page_command(
    scenario: Scenario,
    changes: Changes,
    plugins: Plugins,
    out: OutPage,
    sliders: Annotated[
        list[str],
        list_option(
            SLIDER,
            "PATH=LOW..HIGH",
            "A number of the loop that the page can change, as `batch --vary` has it: "
            "`controller.proportional_gain=0.3..30 V s/m`, `plant.mass=-50%..+100%`. [default: those of "
            "`[tune.vary]` that a run reads]",
        ),
    ],
    json: Json = False,
) -> None:
    """Write a page that runs the loop in a browser: one HTML file with sliders, plots and metrics.

    The file opens without a server or a network. The loop in it is that of export c, compiled to WebAssembly;
    before the file is written, its numbers are held against the strict simulation, bit for bit: as it is, and
    at both ends of each slider. Needs `pip install 'hydroservo[page]'`.

    Examples:

    - `hydroservo export page rig/1khz-pi-sine --out page.html`
    - `hydroservo export page axis/position --slider plant.mechanism.mass=50..500kg --out page.html`
    """
    from hydroservo.cli.messages import say_warning
    from hydroservo.core.errors import HydroservoError, HydroservoWarning
    from hydroservo.export.page import write_page
    from hydroservo.export.products import proof_line
    from hydroservo.scenario import assemble, parse_override
    from hydroservo.show.files import as_json

    ranges = parse_ranges(sliders, SLIDER)
    described = assemble(scenario, dict(map(parse_override, changes)), plugins)
    usual = {path: one.entry for path, one in described.search.ranges.items()}
    if not (ranges or usual):
        raise HydroservoError(f"nothing to change: give {SLIDER} PATH=LOW..HIGH, or the scenario [tune.vary]")
    title = f"{described.title}, changed" if described.title and changes else described.title
    options = {"ranges": ranges or usual, "fitting_only": not ranges, "title": title}
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", HydroservoWarning)
        page, moved = export_loop(write_page, scenario, changes, plugins, out, **options)
    for one in said:
        say_warning(scenario, str(one.message))
    if json:
        about = {**export_identity(scenario, page.unit), "proof": page.proof._asdict()}
        typer.echo(as_json({**about, "sliders": moved, "file": str(out)}))
        return
    typer.echo(f"{page.unit.title}: sliders for {', '.join(moved)}")
    if others := [path for path in ranges or usual if path not in moved]:
        typer.echo(f"left out, as they cannot be sliders: {', '.join(others)}")
    typer.echo(proof_line(page.proof))
    typer.echo(f"written: {out}, {out.stat().st_size / 1024:.0f} KiB; it opens in a browser")


def export_loop(
    export: Callable[..., Any],
    scenario: str,
    changes: "Sequence[str]",
    plugins: "Sequence[Path]",
    out: Path,
    **options: Any,
) -> Any:
    """What a function of ``export`` returns for a scenario's loop."""
    loop = load_loop(scenario, changes, plugins)
    with progress_bar("translating") as report:
        return export(loop, out, name=scenario_title(scenario), progress=report, **options)


def fmu_summary(unit: "CModule", version: FmiVersion, clocked: bool) -> str:
    """What an FMU has, and how it is used."""
    from hydroservo.export.fmu import variables_of

    kinds = Counter(one.causality for one in variables_of(unit))
    counts = [counted(kinds[kind], kind) for kind in ("input", "output")]
    parameters = counted(len(unit.parameters), "parameter")
    samples = f"{'a clock' if clocked else 'steps'} of {unit.period:g} s"
    use = "model exchange" if unit.part is Part.EQUATIONS else samples
    return f"{unit.title}: {', '.join([*counts, parameters])}, FMI {version}, {use}"


def print_untried_platforms(platforms: "Sequence[Platform]") -> None:
    """Say of which platforms nothing was run here."""
    others = [one for one in platforms if one != machine_name()]
    if others:
        typer.echo(f"cross compiled, and not run here: the binaries for {', '.join(others)}")


def scenario_title(scenario: str) -> str:
    """What a scenario is called in titles: its name, or its file's without folder and ending."""
    from hydroservo.scenario import scenarios

    return scenario if scenario in scenarios() else Path(scenario).stem


def export_identity(scenario: str, unit: "CModule") -> dict[str, object]:
    """What names an export in JSON."""
    return {
        "scenario": scenario,
        "hash": unit.hash,
        "version": unit.version,
        "unit": unit.part,
        "prefix": unit.prefix,
        "precision": "single" if unit.real == "float" else "double",
        "period": unit.period,
    }
