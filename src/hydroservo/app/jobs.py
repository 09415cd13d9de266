"""What a page may ask for, by name: each gives what is said of the answer, and its bytes."""

import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from hydroservo.app.downloads import Report, exported
from hydroservo.app.form import form_of
from hydroservo.app.logs import drawn_log, found_in_log, log_file
from hydroservo.app.retyped import completed, retyped
from hydroservo.app.saved import scenario_text
from hydroservo.app.sketch import sketched_run
from hydroservo.app.source import Home, source_of
from hydroservo.app.trajectory import drawn_run
from hydroservo.control.loop import Loop
from hydroservo.core.errors import HydroservoWarning
from hydroservo.runs.run import simulate

if TYPE_CHECKING:
    import xarray as xr

MOST_SUBSTEPS = 10**6
LOWEST, HIGHEST = 1e-9, 1e9  # Hz
Request = Mapping[str, Any]
Answer = tuple[dict[str, Any], bytes]


def run(request: Request, home: Home, report: Report) -> Answer:
    """A run, and the form where it is asked for."""
    assembly = source_of(request, home).assembled()
    fields = {"form": form_of(assembly)} if request.get("form") else {}
    report(0.0, "simulating")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HydroservoWarning)  # the answer has them
        data = whole_or_sketched(assembly.loop, request.get("substeps"), report)
    more = request.get("signals")
    drawn = drawn_run(assembly.loop, data, more if isinstance(more, list) else [])
    return {**drawn.about, **fields}, drawn.rows.tobytes()


def whole_or_sketched(loop: Loop, substeps: object, report: Report) -> "xr.Dataset":
    """A run; where a page says with how many substeps the last one went, one for while a slider moves."""

    def progress(done: float) -> None:
        report(done, "simulating")

    if isinstance(substeps, int) and 0 < substeps <= MOST_SUBSTEPS:
        return sketched_run(loop, substeps, progress)
    return simulate(loop, progress=progress)


def form(request: Request, home: Home, _: Report) -> Answer:
    """The form alone, before a first run."""
    return {"form": form_of(source_of(request, home).assembled())}, b""


def frequency(request: Request, home: Home, _: Report) -> Answer:
    """A loop in frequency; its curves alone between two frequencies, where these are given."""
    from hydroservo.app.frequency import drawn_bode, sketched_bode

    loop, band = source_of(request, home).assembled().loop, request.get("band")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HydroservoWarning)
        if isinstance(band, list) and is_band(band):
            about, rows = sketched_bode(loop, *band)
        else:
            about, rows = drawn_bode(loop)
    return about, rows.tobytes()


def is_band(band: list[Any]) -> bool:
    """Whether a page sent two frequencies [Hz]."""
    if len(band) != 2 or not all(isinstance(one, int | float) for one in band):
        return False
    return bool(LOWEST < band[0] < band[1] < HIGHEST)


def retype(request: Request, home: Home, _: Report) -> Answer:
    """Changes with another type for a block, and with numbers that it asked for where these are given."""
    source = source_of(request, home)
    found, given = retyped(source, str(request.get("path")), str(request.get("type"))), request.get("given")
    if isinstance(given, Mapping):
        found = completed(source, found, given)
    return found._asdict(), b""


def toml(request: Request, home: Home, _: Report) -> Answer:
    """The scenario as text."""
    return {"text": scenario_text(source_of(request, home))}, b""


def export(request: Request, home: Home, report: Report) -> Answer:
    """A file for the browser."""
    file = exported(source_of(request, home), str(request.get("kind")), report)
    return {"name": file.name, "type": file.kind}, file.content


def log(request: Request, home: Home, report: Report) -> Answer:
    """A log to be drawn, with its replay."""
    about, rows = drawn_log(source_of(request, home), log_file(home, str(request.get("log"))), report)
    return about, rows.tobytes()


def identification(request: Request, home: Home, report: Report) -> Answer:
    """Numbers of the machine from a log."""
    ranges = request.get("ranges")
    file = log_file(home, str(request.get("log")))
    found = found_in_log(source_of(request, home), file, ranges if isinstance(ranges, dict) else {}, report)
    return found, b""


JOBS: Mapping[str, Callable[[Request, Home, Report], Answer]] = {
    "run": run,
    "form": form,
    "frequency": frequency,
    "retype": retype,
    "toml": toml,
    "export": export,
    "log": log,
    "identify": identification,
}
