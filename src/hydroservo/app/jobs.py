"""What a page may ask for, by name: each gives what is said of the answer, and its bytes."""

import io
import warnings
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.app.drawing import draw_bode, draw_page_run, sketch_bode
from hydroservo.app.form import form_of
from hydroservo.app.logs import draw_log, identify_from_log, log_file
from hydroservo.app.retype import complete_retyped, retype
from hydroservo.app.source import Home, Report, Source, page_scenario_text, page_source
from hydroservo.control.loop import AUTO, Loop
from hydroservo.core.errors import HydroservoError, HydroservoWarning, short
from hydroservo.core.outputs import temporary_folder
from hydroservo.runs.kernels import Mode
from hydroservo.runs.results import save
from hydroservo.runs.run import PreparedRun, simulate
from hydroservo.runs.step_sizes import with_substeps
from hydroservo.runs.trace import run_dataset

if TYPE_CHECKING:
    import xarray as xr

MOST_SUBSTEPS = 10**6
LOWEST, HIGHEST = 1e-9, 1e9  # Hz
Request = Mapping[str, Any]
Answer = tuple[dict[str, Any], bytes]
FORMATS = {"csv": "text/csv", "parquet": "application/octet-stream", "mat": "application/octet-stream"}
PICTURES = {"png": "image/png", "svg": "image/svg+xml"}
KINDS = (*FORMATS, *PICTURES, "c", "fmu")


def run_job(request: Request, home: Home, report: Report) -> Answer:
    """A run, and the form where it is asked for."""
    assembly = page_source(request, home).assemble()
    fields = {"form": form_of(assembly)} if request.get("form") else {}
    report(0.0, "simulating")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HydroservoWarning)  # the answer has them
        data = simulate_or_sketch(assembly.loop, request.get("substeps"), report)
    more = request.get("signals")
    drawn = draw_page_run(assembly.loop, data, more if isinstance(more, list) else [])
    return {**drawn.about, **fields}, drawn.rows.tobytes()


def simulate_or_sketch(loop: Loop, substeps: object, report: Report) -> "xr.Dataset":
    """A run; where a page says with how many substeps the last one went, one for while a slider moves."""

    def progress(done: float) -> None:
        report(done, "simulating")

    if isinstance(substeps, int) and 0 < substeps <= MOST_SUBSTEPS:
        return sketch_run(loop, substeps, progress)
    return simulate(loop, progress=progress)


def form_job(request: Request, home: Home, _: Report) -> Answer:
    """The form alone, before a first run."""
    return {"form": form_of(page_source(request, home).assemble())}, b""


def frequency_job(request: Request, home: Home, _: Report) -> Answer:
    """A loop in frequency; its curves alone between two frequencies, where these are given."""

    loop, band = page_source(request, home).assemble().loop, request.get("band")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HydroservoWarning)
        if isinstance(band, list) and is_band(band):
            about, rows = sketch_bode(loop, *band)
        else:
            about, rows = draw_bode(loop)
    return about, rows.tobytes()


def is_band(band: list[Any]) -> bool:
    """Whether a page sent two frequencies [Hz]."""
    if len(band) != 2 or not all(isinstance(one, int | float) for one in band):
        return False
    return bool(LOWEST < band[0] < band[1] < HIGHEST)


def retype_job(request: Request, home: Home, _: Report) -> Answer:
    """Changes with another type for a block, and with numbers that it asked for where these are given."""
    source = page_source(request, home)
    found, given = retype(source, str(request.get("path")), str(request.get("type"))), request.get("given")
    if isinstance(given, Mapping):
        found = complete_retyped(source, found, given)
    return found._asdict(), b""


def toml_job(request: Request, home: Home, _: Report) -> Answer:
    """The scenario as text."""
    return {"text": page_scenario_text(page_source(request, home))}, b""


def export_job(request: Request, home: Home, report: Report) -> Answer:
    """A file for the browser."""
    file = make_download(page_source(request, home), str(request.get("kind")), report)
    return {"name": file.name, "type": file.kind}, file.content


def log_job(request: Request, home: Home, report: Report) -> Answer:
    """A log to be drawn, with its replay."""
    about, rows = draw_log(page_source(request, home), log_file(home, str(request.get("log"))), report)
    return about, rows.tobytes()


def identify_job(request: Request, home: Home, report: Report) -> Answer:
    """Numbers of the machine from a log."""
    ranges = request.get("ranges")
    file = log_file(home, str(request.get("log")))
    found = identify_from_log(
        page_source(request, home), file, ranges if isinstance(ranges, dict) else {}, report
    )
    return found, b""


JOBS: Mapping[str, Callable[[Request, Home, Report], Answer]] = {
    "run": run_job,
    "form": form_job,
    "frequency": frequency_job,
    "retype": retype_job,
    "toml": toml_job,
    "export": export_job,
    "log": log_job,
    "identify": identify_job,
}


def sketch_run(loop: Loop, substeps: int, progress: Callable[[float], None]) -> "xr.Dataset":
    """What :func:`~hydroservo.simulate` returns, but for what it says of its steps."""
    run = PreparedRun.of(loop, None, Mode(compiled=True, strict=False))
    if loop.simulation.substeps == AUTO:
        run = run._replace(loop=with_substeps(run.loop, substeps))
    return run_dataset(run.trace(progress))


class Download(NamedTuple):
    """A file for the browser."""

    name: str
    kind: str  # its media type
    content: bytes


def make_download(source: Source, kind: str, report: Report) -> Download:
    """A file of the page's loop."""
    with temporary_folder() as folder:
        if kind in FORMATS or kind in PICTURES:
            return download_run(source, kind, folder, report)
        if kind == "c":
            return download_c(source, folder, report)
        if kind == "fmu":
            return download_fmu(source, folder, report)
    raise HydroservoError(f"{short(kind)} is not an export; there are {', '.join(KINDS)}")


def download_run(source: Source, kind: str, folder: Path, report: Report) -> Download:
    """The trajectory, or a picture of it."""
    from hydroservo.findings import plot

    file = folder / f"run.{kind}"
    run = simulate(source.assemble().loop, progress=lambda done: report(0.8 * done, "simulating"))
    report(0.8, "writing")
    if kind in PICTURES:
        plot(run).save(file)
    else:
        save(run, file)
    return Download(file.name, (FORMATS | PICTURES)[kind], file.read_bytes())


def download_c(source: Source, folder: Path, report: Report) -> Download:
    """The law as a folder of C, in an archive."""
    from hydroservo.export.products import export_c

    export = export_c(source.assemble().loop, folder, progress=report)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in export.files:
            archive.write(file, f"controller/{file.name}")
    return Download("controller.zip", "application/zip", out.getvalue())


def download_fmu(source: Source, folder: Path, report: Report) -> Download:
    from hydroservo.export.products import export_fmu

    file = folder / "controller.fmu"
    export_fmu(source.assemble().loop, file, progress=report)
    return Download(file.name, "application/octet-stream", file.read_bytes())
