"""``python -m benchmarks``: every job, every peer, one table."""

import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, TypeVar

import typer
from rich.console import Console
from rich.table import Table

from benchmarks import isa
from benchmarks.jobs import Job, device_job, jobs
from benchmarks.machine import described, device_described
from benchmarks.machines import loops
from benchmarks.machines import machines as machine_times
from benchmarks.masters import ALL as MASTERS
from benchmarks.masters.measure import RESULTS as MASTERS_RESULTS
from benchmarks.masters.measure import exported_systems, updated
from benchmarks.masters.table import page as masters_page
from benchmarks.masters.table import table as masters_table
from benchmarks.measure import measured
from benchmarks.peer import Peer
from benchmarks.peers import ALL, DEVICE_YARDSTICK, ON_DEVICE, YARDSTICK
from benchmarks.picture import draw
from benchmarks.profile import profile
from benchmarks.results import RESULTS, load, save
from benchmarks.scaling import scaling
from benchmarks.start_up import start_up
from benchmarks.table import (
    Line,
    Section,
    device_table,
    job_table,
    machines_table,
    notes,
    put,
    summary,
    write,
)
from benchmarks.targets.table import measured as measured_units
from benchmarks.targets.table import page as target_page
from benchmarks.targets.table import tables as target_tables
from benchmarks.targets.units import units
from hydroservo.engine.cuda_driver import has_device
from tools.targets.controllers import controllers

app = typer.Typer(add_completion=False)
Named = TypeVar("Named", Job, Peer)
told = Console(stderr=True, highlight=False)
AVX2_JOBS = "J2,J3"  # the ones that the instruction set matters to
AVX2_PEERS = "hydroservo,hydroservo strict,C scalar,C SIMD,JAX"


@app.callback(invoke_without_command=True)
def run(
    context: typer.Context,
    only_jobs: Annotated[str, typer.Option("--jobs", help="names with commas between; all if empty")] = "",
    only_peers: Annotated[str, typer.Option("--peers", help="names with commas between; all if empty")] = "",
    rounds: Annotated[int, typer.Option(min=1, help="how often each contender runs each job")] = 5,
    instructions: Annotated[
        str, typer.Option("--isa", help="native or avx2 (a part of the jobs)")
    ] = "native",
    quick: Annotated[bool, typer.Option("--quick", help="tiny sizes, to see that all works")] = False,
    out: Annotated[Path | None, typer.Option(help="where to save; a complete run goes to its place")] = None,
) -> None:
    """Run every job against every peer, in interleaved rounds, and save what was measured."""
    if context.invoked_subcommand is not None:
        return
    whole = not (only_jobs or only_peers or quick)
    if instructions == "avx2":
        only_jobs, only_peers = only_jobs or AVX2_JOBS, only_peers or AVX2_PEERS
    elif instructions != "native":
        raise typer.BadParameter(f"{instructions!r} is none of {', '.join(isa.ISAS)}")
    offered = jobs(quick)
    target = out or (RESULTS if whole else None)
    section: Section = {"machine": described() | {"instructions": isa.used(instructions)}, "jobs": []}
    for job in picked(offered, only_jobs):
        section["jobs"].append(done(job, picked(ALL, only_peers), rounds, instructions))
        keep(target, instructions, section)
    if whole and instructions == "native":
        section["scaling"] = scaling(picked(offered, "J3 all")[0], rounds, tell)
        keep(target, instructions, section)
        tell("where the time goes")
        section["profile"] = profile(rounds)
        keep(target, instructions, section)
        tell("start-up")
        section["start_up"] = start_up(rounds)
        keep(target, instructions, section)
        section["machines"] = machine_times(loops(), rounds, tell)
        keep(target, instructions, section)
    show(tables(section))
    for note in notes(section):
        terminal().print(note)


def keep(target: Path | None, instructions: str, section: Section) -> None:
    """Saves what there is so far, so that nothing measured is lost, on other processors neither."""
    if target is not None:
        save(target, kept(load(target), instructions) | {instructions: section})


def kept(results: Section, instructions: str) -> Section:
    """The results, with those of another processor under its name."""
    before = results.get(instructions, {}).get("machine", described())["processor"]
    here = described()["processor"]
    if before == here:
        return results
    moved = {f"{instructions} on {before}": results[instructions]}
    return {name: one for name, one in results.items() if name != f"{instructions} on {here}"} | moved


@app.command()
def machines(
    only: Annotated[str, typer.Option(help="names with commas between; all if empty")] = "",
    rounds: Annotated[int, typer.Option(min=1, help="how often each machine runs")] = 5,
    quick: Annotated[bool, typer.Option("--quick", help="tiny sizes, to see that all works")] = False,
    out: Annotated[Path | None, typer.Option(help="where to save; a complete run goes to its place")] = None,
) -> None:
    """Time per simulated second for each machine, alone and side by side, and save it with the rest."""
    offered = loops()
    chosen = {name: offered[name] for name in named(only, list(offered))}
    measured = machine_times(chosen, rounds, tell, quick)
    target = out or (None if quick or only else RESULTS)
    if target is not None:
        results = load(target)
        save(target, results | {"native": results.get("native", {}) | {"machines": measured}})
    show([("", machines_table(measured))])


@app.command()
def device(
    rounds: Annotated[int, typer.Option(min=1, help="how often each contender runs the job")] = 5,
    quick: Annotated[bool, typer.Option("--quick", help="tiny sizes, to see that all works")] = False,
    out: Annotated[Path | None, typer.Option(help="where to save; a complete run goes to its place")] = None,
) -> None:
    """Very many loops on this machine's CUDA device, against CUDA C, and save it with the rest."""
    if not has_device():
        raise typer.BadParameter("there is no CUDA device to measure, or cuda-bindings is missing")
    section: Section = {"machine": device_described(), "jobs": []}
    section["jobs"].append(done(device_job(quick), ON_DEVICE, rounds, "native", DEVICE_YARDSTICK))
    target = out or (None if quick else RESULTS)
    if target is not None:
        save(target, load(target) | {"device": section})
    show([("", device_table(section))])


@app.command()
def targets(
    only: Annotated[str, typer.Option(help="scenarios with commas between; all if empty")] = "",
) -> None:
    """Memory, stack and instructions of exported controllers; all of them go into the documentation."""
    offered = controllers()
    found = list(measured_units(units({name: offered[name] for name in named(only, list(offered))}), tell))
    if not only:
        put("docs/target.md", target_page(found))
    show(target_tables(found))


@app.command()
def masters(
    only: Annotated[str, typer.Option(help="names with commas between; all if empty")] = "",
) -> None:
    """What tools that couple FMUs make of a loop; those that are not installed keep their last result."""
    wanted = named(only, [one.name for one in MASTERS])
    chosen = [one for one in MASTERS if one.name in wanted]
    with TemporaryDirectory() as folder:
        results = updated(load(MASTERS_RESULTS), chosen, exported_systems(Path(folder)), tell)
    save(MASTERS_RESULTS, results)
    put("docs/export.md", masters_page(results))
    show([("", masters_table(results))])


@app.command()
def table() -> None:
    """Write the tables and the picture of the last complete run into the documentation."""
    results = load(RESULTS)
    write(results)
    draw(results["native"]["scaling"])


def picked(offered: Sequence[Named], names: str) -> list[Named]:
    """Those of these names; all if there are none."""
    wanted = named(names, [one.name for one in offered])
    return [one for one in offered if one.name in wanted]


def named(names: str, known: Sequence[str]) -> Sequence[str]:
    """The names that a text with commas has; all if it has none."""
    wanted = [name.strip() for name in names.split(",") if name.strip()]
    for name in wanted:
        if name not in known:
            raise typer.BadParameter(f"{name!r} is none of {', '.join(known)}")
    return wanted or known


def done(
    job: Job, chosen: Sequence[Peer], rounds: int, instructions: str, yardstick: Peer = YARDSTICK
) -> Section:
    """A job with what was measured of it."""
    entries, missing = measured(job, chosen, rounds, instructions, tell, yardstick)
    return {
        "name": job.name,
        "title": job.title,
        "entries": [entry._asdict() for entry in entries],
        "missing": [one._asdict() for one in missing],
    }


def tell(text: str) -> None:
    """What is being done, for who waits."""
    told.print(text)


def tables(section: Section) -> list[tuple[str, tuple[Line, list[Line]]]]:
    """What was measured, by title."""
    jobs = [(f"{job['name']}: {job['title']}", job_table(job)) for job in section["jobs"]]
    machines = [("", machines_table(section["machines"]))] if "machines" in section else []
    return [("", summary(section)), *jobs, *machines]


def show(tables: Sequence[tuple[str, tuple[Line, list[Line]]]]) -> None:
    """Tables on the terminal."""
    for title, (header, rows) in tables:
        shown = Table(title=title or None, title_justify="left")
        for i, text in enumerate(header):
            shown.add_column(text, justify="right" if i else "left")
        for row in rows:
            shown.add_row(*(text.replace("**", "") for text in row))
        terminal().print(shown)


def terminal() -> Console:
    """Where results go; wide enough for the tables where nobody sees it."""
    return Console(width=None if sys.stdout.isatty() else 160, highlight=False)


if __name__ == "__main__":
    app()
