"""A recorded log beside a run, and the machine's numbers from it."""

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.app.downloads import Report
from hydroservo.app.source import Home, Source
from hydroservo.app.trajectory import thinned
from hydroservo.errors import HydroservoError, ScenarioError, short
from hydroservo.formatting import quantity
from hydroservo.identification.identified import identify
from hydroservo.identification.log import log_mapping, read_log
from hydroservo.identification.log_summary import log_summary, rate_lines, signal_rows
from hydroservo.identification.segments import understood
from hydroservo.identification.signals import SIGNALS
from hydroservo.scenario.records import RECORD_ENDINGS

__all__ = ["drawn_log", "found_in_log", "log_file"]

LOG_KEY = re.compile("[0-9a-f]{16}")
MOST_SOUGHT = 8
PLOTTED = {"command": "controller.u", "pressure_a": "plant.pressure_a", "pressure_b": "plant.pressure_b"}


def log_file(home: Home, key: str) -> Path:
    """The file of a log that a page sent.

    Raises:
        HydroservoError: there is none.
    """
    found = [home.folder / f"{key}{ending}" for ending in RECORD_ENDINGS if LOG_KEY.fullmatch(key)]
    file = next((one for one in found if one.exists()), None)
    if file is None:
        raise HydroservoError("the log is no longer here; drag it in again")
    return file


def drawn_log(source: Source, file: Path) -> tuple[dict[str, Any], NDArray[np.float32]]:
    """The signals of a log, each for the panel in which it is drawn.

    Raises:
        ScenarioError: the file is no log.
    """
    assembly = source.assembled()
    controlled = assembly.loop.controls.declared()
    try:
        whole = understood(read_log(file, log_mapping(assembly.log_columns)))
    except ScenarioError as error:
        raise ScenarioError("", "", ": ".join(part for part in (error.key, error.problem) if part)) from None
    log, summary = whole.log, log_summary(whole)
    lines = [
        {"path": PLOTTED.get(name, "controlled.value" if name == controlled.meaning else ""), "name": name}
        for name in log.signals
    ]
    units = [SIGNALS[name].unit for name in log.signals]
    rows = thinned(log.time - log.time[0], list(log.signals.values()))
    about = {
        "lines": [{**line, "unit": unit} for line, unit in zip(lines, units, strict=True)],
        "points": int(rows.shape[1]),
        "samples": len(log.time),
        "signals": signal_rows(summary),
        "remarks": [*rate_lines(summary), *whole.remarks],
    }
    return about, rows


def found_in_log(source: Source, file: Path, ranges: Mapping[str, str], report: Report) -> dict[str, Any]:
    """Numbers of the machine from a log.

    Args:
        source: the scenario.
        file: the log.
        ranges: between what each number is sought, by path.
        report: called with the fraction done.

    Raises:
        HydroservoError: nothing or too much is sought, or the log does not go with the machine.
    """
    if not 0 < len(ranges) <= MOST_SOUGHT:
        raise HydroservoError(f"choose between 1 and {MOST_SOUGHT} numbers of the machine")
    wrong = [path for path, text in ranges.items() if not isinstance(text, str)]
    if wrong:
        raise HydroservoError(f"{short(wrong[0])} must have a range such as 50..200 kg")
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
