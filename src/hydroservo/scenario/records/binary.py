"""Columns of a record in formats that hold numbers as they are."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from threading import Event, Timer
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.format import read_array
from numpy.typing import NDArray

from hydroservo.core.errors import HydroservoError, ScenarioError, require
from hydroservo.core.inputs import check_regular
from hydroservo.core.outputs import temporary_folder
from hydroservo.scenario.records.columns import (
    TIME,
    Choose,
    Header,
    RecordColumn,
    RecordedColumns,
    Samples,
    header_of,
)

TABLE_PROCESS = Path(__file__).with_name("table_process.py")
MOST_READ = 1 << 30  # bytes of the columns that are chosen
MOST_MEMORY = 4 << 30  # bytes that a library may take
PATIENCE = 120.0  # s that it may take
BYTES = 8  # of a number
NAMED = 8  # at most so many other things in a file are named in a message
HDF5 = b"\x89HDF"  # the first bytes
NUMBERS = ("int", "uint", "float", "double", "halffloat", "bool", "decimal")  # kinds of Arrow's
DATES = ("timestamp", "duration")
ADVICE = "; save each signal as a vector, such as t = ts.Time; x = ts.Data; save('log.mat', 't', 'x')"


class BinaryTable(NamedTuple):
    """The columns of a file, of which nothing was read yet."""

    headers: Sequence[Header]  # of the columns
    counts: Sequence[int]  # how many samples each has
    read: Callable[[Sequence[int]], Sequence[NDArray[Any]]]  # what gives some of them, by their places
    others: Sequence[str] = ()  # what else is in the file


def read_binary_columns(path: Path, choose: Choose, largest: int, *, gaps: bool) -> RecordedColumns:
    """The chosen columns of a file whose ending is one of :data:`BINARY`, in its units.

    It has at most ``largest`` bytes; samples are missing only where ``gaps`` allows it.
    """
    name, kind = str(path), path.suffix.lower()
    check_regular(path, largest, name)
    try:
        with BINARY[kind](path) as table:
            columns = choose_from(table, choose, name)
            places = [column.header.place for column in columns]
            size = BYTES * sum(table.counts[place] for place in places)
            if size > MOST_READ:
                problem = f"the columns to read take {size >> 20} MiB; at most {MOST_READ >> 20} MiB are read"
                raise ScenarioError(name, "", problem)
            rows = table.read(places)
    except HydroservoError:
        raise
    except Exception as error:  # whatever a library says of a file that is not what its ending says
        problem = " ".join(str(error).split()) or type(error).__name__
        raise ScenarioError(name, "", f"cannot be read as {kind}: {problem}") from None
    samples = {
        one.signal: column_numbers(row, name, one, gaps) for one, row in zip(columns, rows, strict=True)
    }
    check_lengths(columns, samples, name)
    return RecordedColumns(columns, table.headers, samples)


def choose_from(table: BinaryTable, choose: Choose, name: str) -> Sequence[RecordColumn]:
    others = f"{', '.join(table.others[:NAMED])}{' ...' if len(table.others) > NAMED else ''}"
    advice = ADVICE if name.lower().endswith(".mat") else ""
    if not table.headers:
        raise ScenarioError(name, "", f"has no columns of numbers; it holds {others or 'nothing'}{advice}")
    try:
        return choose(table.headers, "")
    except ScenarioError as error:
        if not others:
            raise
        problem = f"{error.problem}; it also holds {others}{advice}"
        raise ScenarioError(error.file, error.key, problem) from None


def check_lengths(columns: Sequence[RecordColumn], samples: Samples, name: str) -> None:
    """Refuse columns that are not those of one table."""
    first, *others = columns
    size = samples[first.signal].size
    for one in others:
        if samples[one.signal].size != size:
            problem = f"has {samples[one.signal].size} samples, and {first.header.name} {size}"
            raise ScenarioError(name, f"column {one.header.text}", problem)
    for one in columns:
        if one.signal == TIME:
            check_increasing(one, samples[TIME], name)


def check_increasing(column: RecordColumn, instants: NDArray[np.float64], name: str) -> None:
    late = np.flatnonzero(~(np.diff(instants) > 0.0))
    if late.size:
        place = f"row {late[0] + 2}, column {column.header.text}"
        raise ScenarioError(name, place, "is not after that in the row before")


def column_numbers(values: NDArray[Any], name: str, column: RecordColumn, gaps: bool) -> NDArray[np.float64]:
    """A column as a row of numbers; of dates, the seconds from the first."""
    place = f"column {column.header.text}"
    try:
        if values.dtype.kind in "mM":
            return np.asarray((values - values[:1]) / np.timedelta64(1, "s"), dtype=np.float64)
        row = np.atleast_1d(np.asarray(values, dtype=np.float64).squeeze())
    except (TypeError, ValueError):
        raise ScenarioError(name, place, "must be numbers") from None
    if row.ndim != 1:
        raise ScenarioError(
            name, place, f"has shape {row.shape}; it must be a one-dimensional array of numbers"
        )
    wrong = np.flatnonzero(np.isinf(row) if gaps else ~np.isfinite(row))
    if wrong.size:
        allowed = "finite, or nan where missing" if gaps else "finite"
        raise ScenarioError(name, f"row {wrong[0] + 1}, {place}", f"must be {allowed}")
    return row


@contextmanager
def open_parquet(path: Path) -> Iterator[BinaryTable]:
    require("pyarrow", "parquet", "Parquet")
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        schema = file.schema_arrow
        units = [(field.metadata or {}).get(b"units", b"").decode() for field in schema]

        def read(places: Sequence[int]) -> list[NDArray[Any]]:
            names = [schema.names[place] for place in places]
            for name, place in zip(names, places, strict=True):
                if not str(schema.field(place).type).startswith(NUMBERS + DATES):
                    raise ScenarioError(str(path), f"column {name}", "must be numbers")
            table = file.read(columns=names)
            return [table.column(name).to_numpy() for name in names]

        dates = [str(field.type).startswith(DATES) for field in schema]
        columns = zip(schema.names, units, dates, strict=True)
        headers = [header_of(name, i, unit, clock) for i, (name, unit, clock) in enumerate(columns)]
        yield BinaryTable(headers, [file.metadata.num_rows] * len(headers), read)


@contextmanager
def open_netcdf(path: Path) -> Iterator[BinaryTable]:
    import xarray as xr

    with path.open("rb") as file:
        new = file.read(4) == HDF5
    if new:  # NetCDF 4
        with open_in_process(path) as table:
            yield table
        return
    with xr.open_dataset(path, decode_times=False) as data:
        rows = {str(name): one for name, one in data.variables.items() if one.ndim == 1}
        columns = list(rows.values())
        units = [netcdf_unit(one.attrs.get("units", "")) for one in columns]
        headers = [header_of(name, i, unit) for i, (name, unit) in enumerate(zip(rows, units, strict=True))]
        yield BinaryTable(
            headers, [one.size for one in columns], lambda places: [columns[i].values for i in places]
        )


@contextmanager
def open_in_process(path: Path) -> Iterator[BinaryTable]:
    """A table that a process of its own reads, for its library may crash, chatter, or never end."""
    kind = path.suffix.lower()
    with temporary_folder() as folder, (folder / "said").open("w+") as said:
        command = [sys.executable, "-P", str(TABLE_PROCESS), kind, str(path), str(MOST_MEMORY)]
        surroundings = {**os.environ, "TMPDIR": str(folder), "OPENBLAS_NUM_THREADS": "1"}
        pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": said}
        with subprocess.Popen(command, env=surroundings, **pipes) as process:  # noqa: S603 - our own program
            late = Event()

            def give_up() -> None:
                late.set()
                process.kill()

            timer = Timer(PATIENCE, give_up)
            timer.start()
            try:
                columns, others = json.loads(process.stdout.readline())  # type: ignore[union-attr]
                headers = [
                    header_of(name, i, netcdf_unit(unit), clock)
                    for i, (name, unit, _, clock) in enumerate(columns)
                ]
                counts = [count for _, _, count, _ in columns]
                yield BinaryTable(headers, counts, lambda places: receive_columns(process, places), others)
            except (ValueError, OSError) as error:
                with suppress(OSError):  # at the end of Popen it would raise again
                    process.stdin.close()  # type: ignore[union-attr]
                try:
                    status = process.wait(1.0)
                except subprocess.TimeoutExpired:
                    raise error from None
                raise ValueError(why_ended(status, said, late.is_set()) or str(error)) from None
            finally:
                timer.cancel()
                process.kill()


def receive_columns(process: Any, places: Sequence[int]) -> list[NDArray[Any]]:
    process.stdin.write(json.dumps(list(places)).encode() + b"\n")
    process.stdin.flush()
    there: Any = SimpleNamespace(read=process.stdout.read)
    return [read_array(there, allow_pickle=False) for _ in places]


def why_ended(status: int, said: Any, late: bool) -> str:
    """What a process said as it ended."""
    if late:
        return f"it takes more than {PATIENCE:g} s"
    said.seek(0)
    last = str(said.read()).strip().rpartition("\n")[2]
    if "MemoryError" in last or "Unable to allocate" in last:
        return f"it takes more than {MOST_MEMORY >> 30} GiB of memory"
    return "it is damaged" if status < 0 or not last else last.partition(": ")[2] or last


def netcdf_unit(text: object) -> str:
    """A unit as NetCDF has it, where instants may be in "seconds since" a date."""
    return str(text).partition(" since ")[0]


def process_with(
    library: str, extra: str, kind: str
) -> Callable[[Path], AbstractContextManager[BinaryTable]]:
    """What reads a format for which another library must be installed."""

    def read(path: Path) -> AbstractContextManager[BinaryTable]:
        require(library, extra, f"{kind} file")
        return open_in_process(path)

    return read


open_mdf = process_with("asammdf", "mdf", "an MDF")
BINARY: Mapping[str, Callable[[Path], AbstractContextManager[BinaryTable]]] = {
    ".parquet": open_parquet,
    ".mat": open_in_process,
    ".nc": open_netcdf,
    ".h5": open_in_process,
    ".hdf5": open_in_process,
    ".mf4": open_mdf,
    ".mdf": open_mdf,
    ".tdms": process_with("nptdms", "tdms", "a TDMS"),
}
"""What reads a file, by its ending."""
