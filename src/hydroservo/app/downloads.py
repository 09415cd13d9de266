"""What a page hands to the browser to keep: trajectories, pictures, C and FMUs."""

import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from hydroservo.app.source import Source
from hydroservo.core.errors import HydroservoError, short
from hydroservo.core.outputs import temporary_folder
from hydroservo.runs.run import simulate

Report = Callable[[float, str], None]  # called with the fraction done, and what is being done
FORMATS = {"csv": "text/csv", "parquet": "application/octet-stream", "mat": "application/octet-stream"}
PICTURES = {"png": "image/png", "svg": "image/svg+xml"}
KINDS = (*FORMATS, *PICTURES, "c", "fmu")


class Download(NamedTuple):
    """A file for the browser."""

    name: str
    kind: str  # its media type
    content: bytes


def make_download(source: Source, kind: str, report: Report) -> Download:
    """A file of the page's loop.

    Args:
        source: its scenario.
        kind: one of ``KINDS``.
        report: called with the fraction done, and what is being done.
    """
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
    from hydroservo.runs.results import save

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
    """The law as an FMU."""
    from hydroservo.export.products import export_fmu

    file = folder / "controller.fmu"
    export_fmu(source.assemble().loop, file, progress=report)
    return Download(file.name, "application/octet-stream", file.read_bytes())
