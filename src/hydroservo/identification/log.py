"""A log: what drove a machine, and what was measured of it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.core.field import Field, declared_fields
from hydroservo.core.signals import MachineOutputs
from hydroservo.runs.arguments import checked_path
from hydroservo.scenario.records import (
    ColumnSource,
    Header,
    RecordColumn,
    choose_columns,
    column_source,
    read_columns,
)
from hydroservo.scenario.records.columns import first_names
from hydroservo.scenario.records.series import sample_period
from hydroservo.scenario.tables import TableEntry

TIME = "time"
COMMAND = "command"
EXTERNAL_FORCE = "external_force"
REFERENCE = "reference"

# What drives the machine: the command must be there; a force stands in place of the scenario's load.
INPUTS: Mapping[str, Field] = MappingProxyType(
    {
        COMMAND: Field("V", "command of the valve or the pump"),
        EXTERNAL_FORCE: Field("N", "external force on the rod, positive against motion"),
    }
)
FEWEST = 16  # samples
LARGEST_NUMBER = 1e30  # in SI units
PERIOD = "period"  # beside the signals of a mapping

LogSource = str | Path | Mapping[str, Any]
# What is measured; at least one of these must be there.
OUTPUTS: Mapping[str, Field] = MappingProxyType(dict(declared_fields(MachineOutputs)))
# All of them, in SI units, by the name that a column of a log has.
SIGNALS: Mapping[str, Field] = MappingProxyType({TIME: Field("s", "time"), **INPUTS, **OUTPUTS})
# What a scenario may say the column of: the demand too, whose unit is that of what is controlled.
NAMES = (*SIGNALS, REFERENCE)
# Other usual names, and the columns of a run's trajectory, which is a log too, measured ones first.
WRITTEN: Mapping[str, Sequence[str]] = MappingProxyType(
    {
        TIME: ("t", "timestamp", "datetime"),
        COMMAND: ("controller.u",),
        EXTERNAL_FORCE: ("load.force",),
        REFERENCE: ("reference.value",),
    }
    | {name: (f"sensors.{name}.value", f"sensors.{name}", f"plant.{name}") for name in OUTPUTS}
)


class SignalLog(NamedTuple):
    """Signals over time, as they were recorded."""

    name: str  # of the log, such as its file
    time: NDArray[np.float64]  # instants [s], increasing, shape (n,)
    # by their names in :data:`~hydroservo.identification.log.SIGNALS`, in SI units, shape (n,); nan where a
    # sample is missing
    signals: Mapping[str, NDArray[np.float64]]
    unused: Sequence[str] = ()  # columns that hold no signal
    columns: Mapping[str, str] = {}  # the header of each signal's column, where it was read from a file


def read_logs(
    logs: Sequence[LogSource], mapping: Mapping[str, Any], needed: Sequence[str] = (TIME, COMMAND)
) -> list[SignalLog]:
    """Logs in files, or at hand."""
    if not logs:
        raise ParameterError("logs", "[]", "must be at least one")
    return [
        log_of_arrays(one, f"log {i}", needed) if isinstance(one, Mapping) else read_log(one, mapping, needed)
        for i, one in enumerate(logs, 1)
    ]


def read_log(
    path: str | Path,
    mapping: Mapping[str, Any],
    needed: Sequence[str] = (TIME, COMMAND),
    sought: Mapping[str, Field] = SIGNALS,
) -> SignalLog:
    """The log in a file, as :func:`~hydroservo.scenario.records.read_columns` reads it.

    Args:
        path: of the file.
        mapping: the column of a signal, such as ``{"velocity": "v_piston [mm/s]"}`` or ``{"command":
            {"column": "I [mA]", "scale": "0.25 V/mA"}}``; a signal without one has a column of its own name,
            or of that which a run of ours writes. Where there is no column of instants, ``period`` is the
            time between samples, such as "10 ms".
        needed: signals without which the log is none.
        sought: the signals that are looked for.
    """
    file = checked_path("logs", path)
    name = str(file)
    sources, period = sources_in(mapping)
    signals = {
        signal: (field, (signal, *WRITTEN.get(signal, ())))
        for signal, field in sought.items()
        if period is None or signal != TIME
    }

    def choose(headers: Sequence[Header], place: str) -> list[RecordColumn]:
        columns = choose_columns(headers, sources, signals, (name, place))
        dates = [one for one in headers if one.clock]
        if period is None and TIME not in {one.signal for one in columns} and len(dates) == 1:
            columns = [RecordColumn(TIME, dates[0], "s"), *columns]  # however it is called
        there = {one.signal for one in columns} | ({TIME} if period is not None else set())
        for signal in needed:
            if signal not in there:
                raise missing_signal(signal, headers, (name, place))
        if not there & set(OUTPUTS):
            raise nothing_measured(headers, (name, place))
        return columns

    record = read_columns(file, choose, period)
    used = {one.header.place for one in record.columns}
    unused = [one.text for one in record.headers if one.place not in used and one.text]
    texts = {one.signal: column_text(one) for one in record.columns}
    rows = dict(record.samples)
    return check_log(SignalLog(name, rows.pop(TIME), rows, unused, texts))


def column_text(column: RecordColumn) -> str:
    """The header of a column, and the unit that is read where the mapping gives another."""
    other = column.header.unit not in ("", column.unit) and not column.header.clock
    return f"{column.header.text}, read in {column.unit}" if other else column.header.text


def sources_in(mapping: Mapping[str, Any]) -> tuple[dict[str, ColumnSource], float | None]:
    """The columns that a mapping names, and the time between samples [s]; None where it says none."""
    sources, period = {}, None
    for signal, value in mapping.items():
        try:
            if signal == PERIOD:
                period = sample_period(value)
            else:
                sources[signal] = column_source(value)
        except ValueError as error:
            raise ParameterError(f"columns.{signal}", value, str(error)) from None
    if period is not None and TIME in sources:
        raise ParameterError("columns.period", mapping[PERIOD], "must be left out where time names a column")
    return sources, period


def missing_signal(signal: str, headers: Sequence[Header], where: tuple[str, str]) -> ScenarioError:
    """That a log lacks a column that it must have."""
    unit = SIGNALS[signal].unit
    example = f'[identify.columns] {signal} = "COLUMN [{unit}]" names it'
    if signal == TIME:
        example += ', or period = "1 ms" stands for it'
    problem = f'column "{signal} [{unit}]" is missing among {first_names(headers)}; {example}'
    return ScenarioError(*where, problem)


def nothing_measured(headers: Sequence[Header], where: tuple[str, str]) -> ScenarioError:
    """That a log has no column of what is measured."""
    problem = f"has no column of anything measured among {first_names(headers)}"
    signals = f"one must be {', '.join(OUTPUTS)}, or [identify.columns] says which is which"
    return ScenarioError(*where, f"{problem}; {signals}")


def log_mapping(columns: Mapping[str, TableEntry]) -> dict[str, Any]:
    """The column of each signal that a scenario's ``[identify.columns]`` names."""
    for signal, entry in columns.items():
        if signal not in (*NAMES, PERIOD):
            raise entry.unknown(signal, (*NAMES, PERIOD))
    return {signal: entry.value for signal, entry in columns.items()}


def log_of_arrays(given: Mapping[str, Any], name: str, needed: Sequence[str] = (TIME, COMMAND)) -> SignalLog:
    """The log that arrays in SI units by name make."""
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
    return check_log(SignalLog(name, rows.pop(TIME), rows))


def check_log(log: SignalLog) -> SignalLog:
    """A log long enough to tell anything."""
    for name, row in {TIME: log.time, **log.signals}.items():
        if np.nanmax(np.abs(row), initial=0.0) > LARGEST_NUMBER:
            problem = f"has a number beyond {LARGEST_NUMBER:g} {SIGNALS[name].unit}; check its unit"
            raise ScenarioError(log.name, name, problem)
    if log.time.size < FEWEST:
        problem = f"too few samples to tell anything, {log.time.size}; at least {FEWEST} are needed"
        raise ScenarioError(log.name, "", problem)
    return log
