"""Logs in formats that hold numbers as they are: Parquet, MATLAB, NetCDF and MDF."""

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

from hydroservo.errors import HydroservoError, ScenarioError
from hydroservo.identification.signals import TIME
from hydroservo.identification.text_tables import LARGEST, Choose, Samples
from hydroservo.inputs import check_regular
from hydroservo.outputs import temporary_folder

__all__ = ["BINARY", "read_binary_table"]

TABLE_PROCESS = Path(__file__).with_name("table_process.py")
MOST_READ = 1 << 30  # bytes of the columns that are chosen
MOST_MEMORY = 4 << 30  # bytes that a library may take
PATIENCE = 120.0  # s that it may take
BYTES = 8  # of a number
NUMBERS = ("int", "uint", "float", "double", "halffloat", "bool", "decimal")  # kinds of Arrow's


class Table(NamedTuple):
    """The columns of a file, of which nothing was read yet.

    Attributes:
        headers: such as "velocity [m/s]".
        counts: how many samples each has.
        read: what gives some of them, by their places.
    """

    headers: Sequence[str]
    counts: Sequence[int]
    read: Callable[[Sequence[int]], Sequence[NDArray[Any]]]


def read_binary_table(path: Path, choose: Choose) -> tuple[Samples, list[str]]:
    """The chosen columns of a file whose ending is one of :data:`BINARY`, in its units, and all headers.

    Args:
        path: of the file.
        choose: the columns.

    Raises:
        ScenarioError: it cannot be read, is too large, or a column is not a row of numbers as long as the
            time's.
    """
    name, kind = str(path), path.suffix.lower()
    check_regular(path, LARGEST, name)
    try:
        with BINARY[kind](path) as table:
            columns = choose(table.headers)
            places = [column.place for column in columns]
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
    found = {one.signal: numbers(row, name, one.header) for one, row in zip(columns, rows, strict=True)}
    for one in columns:
        if found[one.signal].size != found[TIME].size:
            problem = f"has {found[one.signal].size} samples, and the time {found[TIME].size}"
            raise ScenarioError(name, f"column {one.header}", problem)
    late = np.flatnonzero(~(np.diff(found[TIME]) > 0.0))
    if late.size:
        problem = "is not after the instant in the row before"
        raise ScenarioError(name, f"row {late[0] + 2}, column {columns[0].header}", problem)
    return found, list(table.headers)


def numbers(values: NDArray[Any], name: str, header: str) -> NDArray[np.float64]:
    """A column as a row of numbers."""
    try:
        found = np.asarray(values, dtype=np.float64).squeeze()
    except (TypeError, ValueError):
        raise ScenarioError(name, f"column {header}", "must be numbers") from None
    if found.ndim != 1:
        raise ScenarioError(
            name,
            f"column {header}",
            f"has shape {found.shape}; it must be a one-dimensional array of numbers",
        )
    infinite = np.flatnonzero(np.isinf(found))
    if infinite.size:
        raise ScenarioError(
            name, f"row {infinite[0] + 1}, column {header}", "must be finite, or nan where missing"
        )
    return found


def headed(name: str, unit: object) -> str:
    return f"{name} [{unit}]" if unit else name


@contextmanager
def parquet(path: Path) -> Iterator[Table]:
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        schema = file.schema_arrow
        units = [(field.metadata or {}).get(b"units", b"").decode() for field in schema]

        def read(places: Sequence[int]) -> list[NDArray[Any]]:
            names = [schema.names[place] for place in places]
            for name, place in zip(names, places, strict=True):
                if not str(schema.field(place).type).startswith(NUMBERS):
                    raise ScenarioError(str(path), f"column {name}", "must be numbers")
            table = file.read(columns=names)
            return [table.column(name).to_numpy() for name in names]

        headers = list(map(headed, schema.names, units))
        yield Table(headers, [file.metadata.num_rows] * len(headers), read)


@contextmanager
def netcdf(path: Path) -> Iterator[Table]:
    import xarray as xr

    with xr.open_dataset(path, decode_times=False) as data:
        rows = {str(name): one for name, one in data.variables.items() if one.ndim == 1}
        columns = list(rows.values())
        headers = [headed(name, one.attrs.get("units")) for name, one in rows.items()]
        yield Table(
            headers, [one.size for one in columns], lambda places: [columns[i].values for i in places]
        )


@contextmanager
def process_table(path: Path) -> Iterator[Table]:
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
                columns = json.loads(process.stdout.readline())  # type: ignore[union-attr]
                headers = [headed(name, unit) for name, unit, _ in columns]
                yield Table(
                    headers, [count for *_, count in columns], lambda places: receive_columns(process, places)
                )
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
    """The columns at some places, from a process that waits for them."""
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


def matlab(path: Path) -> AbstractContextManager[Table]:
    return process_table(path)


def mdf(path: Path) -> AbstractContextManager[Table]:
    """Where signals were sampled at instants of their own, each is nan at those of the others."""
    from importlib.util import find_spec

    if find_spec("asammdf") is None:
        raise HydroservoError("an MDF file needs asammdf: pip install 'hydroservo[mdf]'")
    return process_table(path)


BINARY: Mapping[str, Callable[[Path], AbstractContextManager[Table]]] = {
    ".parquet": parquet,
    ".mat": matlab,
    ".nc": netcdf,
    ".mf4": mdf,
    ".mdf": mdf,
}
"""What reads a file, by its ending."""
