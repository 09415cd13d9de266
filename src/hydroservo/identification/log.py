"""A log: what drove a machine, and what was measured of it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import ParameterError, ScenarioError
from hydroservo.field import Field
from hydroservo.identification.binary_tables import BINARY, read_binary_table
from hydroservo.identification.columns import Column, chosen_columns
from hydroservo.identification.signals import COMMAND, NAMES, OUTPUTS, SIGNALS, TIME
from hydroservo.identification.text_tables import read_text_table
from hydroservo.inputs import exists
from hydroservo.runs.arguments import checked_path
from hydroservo.scenario.tables import Entry

__all__ = ["Given", "Log", "checked_log", "log_mapping", "read_log", "read_logs"]

FEWEST = 16  # samples
LARGEST_NUMBER = 1e30  # in SI units

Given = str | Path | Mapping[str, Any]


class Log(NamedTuple):
    """Signals over time, as they were recorded.

    Attributes:
        name: of the log, such as its file.
        time: instants [s], increasing, shape (n,).
        signals: by their names in :data:`~hydroservo.identification.signals.SIGNALS`, in SI units, shape
            (n,); nan where a sample is missing.
        unused: columns that hold no signal.
    """

    name: str
    time: NDArray[np.float64]
    signals: Mapping[str, NDArray[np.float64]]
    unused: Sequence[str] = ()


def read_logs(
    logs: Sequence[Given], mapping: Mapping[str, str], needed: Sequence[str] = (TIME, COMMAND)
) -> list[Log]:
    """Logs in files, or at hand.

    Args:
        logs: paths, or mappings of signals.
        mapping: as :func:`read_log` takes it.
        needed: signals without which a log is none.

    Raises:
        ParameterError: there is none.
        ScenarioError: one is not what it must be.
    """
    if not logs:
        raise ParameterError("logs", "[]", "must be at least one")
    return [
        checked_log(one, f"log {i}", needed) if isinstance(one, Mapping) else read_log(one, mapping, needed)
        for i, one in enumerate(logs, 1)
    ]


def read_log(
    path: str | Path,
    mapping: Mapping[str, str],
    needed: Sequence[str] = (TIME, COMMAND),
    sought: Mapping[str, Field] = SIGNALS,
) -> Log:
    """The log in a file: Parquet, MATLAB, NetCDF or MDF by its ending, else text with a header.

    Args:
        path: of the file.
        mapping: which column holds which signal, as
            :func:`~hydroservo.identification.columns.chosen_columns` has it.
        needed: signals without which the log is none.
        sought: the signals that are looked for.

    Raises:
        ScenarioError: in one line, the file, the place and what is wrong there.
    """
    file = checked_path("logs", path)
    name = str(file)
    if not exists(file):
        raise ScenarioError(name, "", "there is no such file")
    binary = file.suffix.lower() in BINARY
    read, place = (read_binary_table, "") if binary else (read_text_table, "line 1")
    columns: list[Column] = []

    def choose(headers: Sequence[str]) -> Any:
        columns[:] = chosen_columns(headers, mapping, name, needed, sought, place)
        return columns

    found, headers = read(file, choose)
    with np.errstate(over="ignore"):
        in_si = {one.signal: found[one.signal] * one.factor for one in columns}
    for one in columns:
        if np.isinf(in_si[one.signal]).any():
            raise ScenarioError(name, f"column {one.header}", "has numbers too large for SI units")
    used = {one.place for one in columns}
    unused = [header for i, header in enumerate(headers) if i not in used and header.strip()]
    return checked(Log(name, in_si.pop(TIME), in_si, unused))


def log_mapping(columns: Mapping[str, Entry]) -> dict[str, str]:
    """The column of each signal that a scenario's ``[identify.columns]`` names.

    Raises:
        ScenarioError: a signal is none.
    """
    for signal, entry in columns.items():
        if signal not in NAMES:
            raise entry.unknown(signal, NAMES)
    return {signal: entry.value for signal, entry in columns.items()}


def checked_log(given: Mapping[str, Any], name: str, needed: Sequence[str] = (TIME, COMMAND)) -> Log:
    """The log that arrays in SI units by name make.

    Args:
        given: ``time``, ``command`` and what was measured, each of shape (n,).
        name: of the log.
        needed: signals without which the log is none.

    Raises:
        ParameterError: they are not that.
        ScenarioError: there are too few samples, or they tell nothing.
    """
    rows = {str(key): np.asarray(one, dtype=np.float64) for key, one in given.items()}
    for key, row in rows.items():
        if key not in SIGNALS:
            raise ParameterError(name, key, f"is not a signal; they are {', '.join(SIGNALS)}")
        if row.ndim != 1 or row.size != rows.get(TIME, row).size:
            raise ParameterError(name, key, f"has shape {row.shape}; each must be as long as time")
    if not set(needed) <= rows.keys() or not rows.keys() & set(OUTPUTS):
        problem = f"must have {', '.join(needed)} and one of {', '.join(OUTPUTS)}"
        raise ParameterError(name, ", ".join(rows), problem)
    if not (np.diff(rows[TIME]) > 0.0).all():
        raise ParameterError(name, "time", "must increase")
    return checked(Log(name, rows.pop(TIME), rows))


def checked(log: Log) -> Log:
    """A log long enough to tell anything.

    Raises:
        ScenarioError: it is not, or has numbers whose squares would be too large.
    """
    for name, row in {TIME: log.time, **log.signals}.items():
        if np.nanmax(np.abs(row), initial=0.0) > LARGEST_NUMBER:
            problem = f"has a number beyond {LARGEST_NUMBER:g} {SIGNALS[name].unit}; check its unit"
            raise ScenarioError(log.name, name, problem)
    if log.time.size < FEWEST:
        problem = f"too few samples to tell anything, {log.time.size}; at least {FEWEST} are needed"
        raise ScenarioError(log.name, "", problem)
    return log
