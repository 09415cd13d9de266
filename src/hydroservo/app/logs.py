"""A recorded log beside a run, and the machine's numbers from it."""

import math
import re
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.app.drawing import panel_on_axes, thin_lines
from hydroservo.app.form import NUMBER, all_numbers, form_of
from hydroservo.app.source import Home, Report, Source
from hydroservo.control.loop import Loop
from hydroservo.core.errors import HydroservoError, ScenarioError, short
from hydroservo.core.formatting import quantity
from hydroservo.identification.experiment import experiment, first_steps
from hydroservo.identification.finding import log_finding
from hydroservo.identification.identify import identify
from hydroservo.identification.log import (
    COMMAND,
    EXTERNAL_FORCE,
    OUTPUTS,
    SIGNALS,
    TIME,
    log_mapping,
    read_log,
)
from hydroservo.identification.segments import UnderstoodLog, understand_log
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import simulate
from hydroservo.scenario.records import RECORD_ENDINGS
from hydroservo.show.table import texts_of

LOG_KEY = re.compile("[0-9a-f]{16}")
MOST_SOUGHT = 8
BARE = re.compile(rf"{NUMBER}\s*\.\.\s*{NUMBER}")  # a range that a page does not take for SI

Vector = NDArray[np.float64]


def log_file(home: Home, key: str) -> Path:
    """The file of a log that a page sent."""
    found = [home.folder / f"{key}{ending}" for ending in RECORD_ENDINGS if LOG_KEY.fullmatch(key)]
    file = next((one for one in found if one.exists()), None)
    if file is None:
        raise HydroservoError("the log is no longer here; drag it in again")
    return file


def draw_log(source: Source, file: Path, report: Report) -> tuple[dict[str, Any], NDArray[np.float32]]:
    """The signals of a log, each with what the machine shows under the command that was recorded."""
    assembly = source.assemble()
    try:
        whole = understand_log(read_log(file, log_mapping(assembly.log_columns), (TIME,)))
    except ScenarioError as error:
        raise ScenarioError("", "", ": ".join(part for part in (error.key, error.problem) if part)) from None
    log, finding = whole.log, log_finding(whole)
    try:
        replay, said = replay_log(assembly.loop, whole, report)
    except HydroservoError as error:
        replay, said = {}, f"Not replayed: {error}"
    panels = [log_panel(name, log.signals[name], replay.get(name)) for name in SIGNALS if name in log.signals]
    lines = [line.pop("values") for panel in panels for line in panel["lines"]]
    rows = thin_lines(log.time - log.time[0], lines)
    about = {
        "panels": panels,
        "duration": float(log.time[-1] - log.time[0]),
        "replay": said,
        "points": int(rows.shape[1]),
        "signals": texts_of(finding.tables[0]).rows,
        "remarks": [*map(str, finding.lead), *whole.remarks],
    }
    return about, rows


def replay_log(loop: Loop, whole: UnderstoodLog, report: Report) -> tuple[dict[str, Vector], str]:
    """What the machine of a loop shows under a log's command, at the log's instants, and a line about it.

    Each stretch of the log begins in the state that was measured there, and else as the loop does.
    """
    if any(COMMAND not in one.inputs for one in whole.segments):
        raise HydroservoError("the log has no command")
    found = {name: np.full(whole.log.time.size, np.nan) for name in OUTPUTS}
    ends = []
    for i, segment in enumerate(whole.segments):
        every = loop._replace(simulation=loop.simulation._replace(record_period=segment.period))
        played = experiment(every, segment, (), first_steps(every, segment)).given
        progress = partial(of_segment, report, i, len(whole.segments))
        run = quietly(simulate)(played, record=[f"seen.{name}" for name in OUTPUTS], progress=progress)
        if bool(run["diverged"]):
            ends.append(f"it is lost at {segment.start + float(run['diverged_at']):.3g} s")
        near = (whole.log.time >= segment.time[0]) & (whole.log.time <= segment.time[-1])
        for name, values in found.items():
            values[near] = np.interp(whole.log.time[near], segment.time, run[f"seen.{name}"].values)
    force = any(EXTERNAL_FORCE in one.inputs for one in whole.segments)
    load = "the recorded external force" if force else "the scenario's load"
    said = f"Replayed: the recorded command drives the scenario's machine, under {load}"
    return found, "; ".join([said, *ends])


def of_segment(report: Report, number: int, count: int, done: float) -> None:
    """Report what is done of one of some segments."""
    report((number + done) / count, "replaying the log")


def log_panel(name: str, measured: Vector, replay: Vector | None) -> dict[str, Any]:
    """A signal of a log as it was recorded, and as the machine shows it in a replay."""
    lines = [{"name": "log", "values": measured}]
    if replay is not None and np.isfinite(replay).any():  # the machine has such a signal
        lines.append({"name": "replay", "values": replay})
    return panel_on_axes(name.replace("_", " "), SIGNALS[name].unit, lines)


def identify_from_log(
    source: Source, file: Path, ranges: Mapping[str, str], report: Report
) -> dict[str, Any]:
    """Numbers of the machine from a log."""
    if not 0 < len(ranges) <= MOST_SOUGHT:
        raise HydroservoError(f"choose between 1 and {MOST_SOUGHT} numbers of the machine")
    wrong = [path for path, text in ranges.items() if not isinstance(text, str)]
    if wrong:
        raise HydroservoError(f"{short(wrong[0])} must have a range such as 50..200 kg")
    units = {one["path"]: one["unit"] for one in all_numbers(form_of(source.assemble()))}
    for path, text in ranges.items():
        if BARE.fullmatch(text.strip()) and units.get(path):
            raise ScenarioError("", path, f"{text.strip()} has no unit: {text.strip()} {units[path]}?")
    found = identify(
        source.scenario,
        file,
        ranges,
        changes=source.changes,
        threads=1,
        progress=lambda done: report(done, "identifying"),
    )
    return {
        "parameters": [
            {
                "path": path,
                "meaning": one.meaning,
                "text": quantity(one.value, one.unit),
                "low": quantity(one.low, one.unit),
                "high": quantity(one.high, one.unit),
                "told": one.identifiable,
                "value": one.value,
            }
            for path, one in found.parameters.items()
        ],
        "remarks": list(found.remarks),
        "explained": {
            name: fit.explained for name, fit in found.logs[0].signals.items() if math.isfinite(fit.explained)
        },
    }
