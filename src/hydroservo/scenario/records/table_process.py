"""Reads a file of a binary format in a process of its own: its library may crash, chatter or leave copies.

    python -P table_process.py FORMAT FILE MEMORY

The first line of standard output is JSON: the name, unit and number of samples of each column, whether these
are dates, and what else is in the file. The first line of standard input then names the columns that are
wanted, by their numbers, which follow one after the other as numpy's arrays. The process ends with standard
input, and takes no more memory than it may.
"""

import contextlib
import io
import json
import os
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from functools import cache, partial
from queue import Queue
from threading import Thread
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.format import write_array

NUMBERS = re.compile("double|single|u?int[0-9]+|logical")  # kinds of MATLAB's
MOST_COLUMNS = 4096  # of one matrix
DEEPEST = 8  # structures within structures
ASKED: Queue[str] = Queue(1)


class FileColumn(NamedTuple):
    """A column of a file."""

    name: str  # what it is called
    unit: str  # "" where the file has none
    samples: int  # how many it has
    read: Callable[[], Any]  # what reads them
    dates: bool = False  # whether they are dates


class FileTable(NamedTuple):
    """A file as a table."""

    columns: list[tuple[str, str, int, bool]]  # name, unit, number of samples, whether dates
    others: list[str]  # what else it holds, such as "log: timeseries object"
    read: Callable[[Sequence[int]], Iterable[Any]]  # what reads some of the columns, by their numbers


Parts = tuple[list[FileColumn], list[str]]  # columns, and what else there is


def file_table(columns: Sequence[FileColumn], others: list[str]) -> FileTable:
    about = [(one.name, one.unit, one.samples, one.dates) for one in columns]
    return FileTable(about, others, lambda places: (columns[i].read() for i in places))


def join_parts(parts: Sequence[Parts]) -> Parts:
    """Several parts of a file as one."""
    return [one for columns, _ in parts for one in columns], [one for _, others in parts for one in others]


def array_columns(name: str, shape: Sequence[int], read: Callable[[], Any], unit: str = "") -> Parts:
    """The columns of an array of numbers: one, or those of a matrix, along whose longer side time runs."""
    sides = [size for size in shape if size != 1]
    if len(sides) == 1:
        return [FileColumn(name, unit, sides[0], lambda: np.squeeze(read()))], []
    if len(sides) != 2 or min(sides) > MOST_COLUMNS or not min(sides):
        return [], [f"{name}: {' x '.join(map(str, shape)) or 'one number'}"]
    whole = cache(read)

    def part(i: int) -> Any:
        matrix = np.squeeze(whole())
        return matrix[:, i] if sides[0] >= sides[1] else matrix[i]

    columns = [FileColumn(f"{name}[{i + 1}]", unit, max(sides), partial(part, i)) for i in range(min(sides))]
    return columns, []


def value_columns(name: str, value: Any, unit: str = "", depth: int = 0) -> Parts:
    """The columns of what a MATLAB file holds: an array, a structure, or several of them."""
    if isinstance(value, np.ndarray) and value.dtype.kind in "fiub":
        return array_columns(name, value.shape, lambda: value, unit)
    if isinstance(value, str | int | float):
        return [], []
    inside: list[tuple[str, Any, str]] = []
    if isinstance(value, dict):
        units = units_in(value.get("units"))
        inside = [(f"{name}.{key}", one, units.get(key, "")) for key, one in value.items() if key != "units"]
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype.kind == "O"):
        inside = [(f"{name}[{i}]", one, unit) for i, one in enumerate(np.ravel(value), 1)]
    if not inside or depth == DEEPEST:
        return [], [f"{name}: {type(value).__name__}"]
    return join_parts([value_columns(*one, depth + 1) for one in inside])


def units_in(units: Any) -> dict[str, str]:
    return {name: str(unit) for name, unit in units.items()} if isinstance(units, dict) else {}


def read_matlab(path: str) -> FileTable:
    """The arrays of a MATLAB file, those in structures among them; objects are only named."""
    from h5py import is_hdf5
    from scipy.io import loadmat, whosmat

    if is_hdf5(path):
        return read_hdf5(path)
    contents = [(name, shape, kind) for name, shape, kind in whosmat(path) if isinstance(name, str)]

    def load(name: str) -> Any:
        return loadmat(path, variable_names=[name], squeeze_me=True, simplify_cells=True).get(name)

    units = units_in(load("units")) if "units" in [name for name, *_ in contents] else {}

    def part(name: str, shape: Sequence[int], kind: str) -> Parts:
        if NUMBERS.fullmatch(kind):
            return array_columns(name, shape, partial(load, name), units.get(name, ""))
        if kind in ("struct", "cell"):
            return value_columns(name, load(name))
        return [], [f"{name}: {'x'.join(map(str, shape))} {kind}"]

    return file_table(*join_parts([part(*one) for one in contents if one[0] != "units"]))


def read_hdf5(path: str) -> FileTable:
    """The arrays of an HDF5 file, as MATLAB 7.3 and NetCDF 4 have it, named by their groups."""
    import h5py

    file: Any = h5py.File(path, "r")
    units = file.get("units")
    words = {key: matlab_text(one) for key, one in units.items()} if isinstance(units, h5py.Group) else {}
    parts: list[Parts] = []

    def visit(place: str, item: Any) -> None:
        name = place.replace("/", ".")
        if isinstance(item, h5py.Dataset) and not place.startswith(("#", "units/")):
            parts.append(dataset_columns(name, item, words.get(name, "")))
        elif "MATLAB_object_decode" in item.attrs:
            parts.append(([], [f"{name}: {attribute_text(item.attrs.get('MATLAB_class', ''))} object"]))

    file.visititems(visit)
    return file_table(*join_parts(parts))


def dataset_columns(name: str, item: Any, unit: str) -> Parts:
    """The columns of one dataset; of a table those of its fields."""
    kind = attribute_text(item.attrs.get("MATLAB_class", ""))
    if (
        attribute_text(item.attrs.get("NAME", "")).startswith("This is a netCDF dimension but not")
        or kind == "char"
    ):
        return [], []
    unit = attribute_text(item.attrs.get("units", item.attrs.get("unit", ""))) or unit
    fields = [field for field in item.dtype.names or () if item.dtype[field].kind in "fiub"]
    if fields:
        each = (array_columns(f"{name}.{one}", item.shape, partial(item.__getitem__, one)) for one in fields)
        return [column for columns, _ in each for column in columns], []
    if "MATLAB_object_decode" in item.attrs or kind == "cell" or item.dtype.kind not in "fiub":
        return [], [f"{name}: {kind or item.dtype}"]
    return array_columns(name, item.shape, partial(unpacked_values, item), unit)


def attribute_text(value: Any) -> str:
    """A text attribute, which may be bytes, or an array of either."""
    first = value.ravel()[0] if isinstance(value, np.ndarray) and value.size else value
    return first.decode(errors="replace") if isinstance(first, bytes) else str(first)


def matlab_text(item: Any) -> str:
    """A text of MATLAB's, which HDF5 holds as numbers."""
    return "".join(map(chr, np.ravel(item[()]))) if is_text(item) else ""


def is_text(item: Any) -> bool:
    return attribute_text(item.attrs.get("MATLAB_class", "")) == "char"


def unpacked_values(item: Any) -> Any:
    """The numbers that a dataset stands for: NetCDF packs some, and marks what is missing."""
    values = item[()]
    fill = item.attrs.get("_FillValue")
    if fill is None and "scale_factor" not in item.attrs and "add_offset" not in item.attrs:
        return values
    lacks = np.zeros(values.shape, bool) if fill is None else values == np.ravel(fill)[0]
    scale, offset = np.ravel(item.attrs.get("scale_factor", 1)), np.ravel(item.attrs.get("add_offset", 0))
    return np.where(lacks, np.nan, values * float(scale[0]) + float(offset[0]))


def read_mdf(path: str) -> FileTable:
    """The channels of an MDF file; each is nan at the instants that others have of their own."""
    from asammdf import MDF

    file: Any = MDF(path)
    channels: dict[str, tuple[int, int]] = {}
    twice: set[str] = set()
    samples = 0
    for group, part in enumerate(file.groups):
        master, count = file.masters_db.get(group), int(part.channel_group.cycles_nr)
        samples += count
        for index, channel in enumerate(part.channels):
            if index != master:
                twice |= {channel.name} & channels.keys()
                channels.setdefault(channel.name, (group, index))

    units = {name: file.get_channel_unit(name, *place) for name, place in channels.items()}
    columns = [(name, unit, samples, False) for name, unit in {"time": "s", **units}.items()]
    columns += [(name, "", samples, False) for name in sorted(twice)]  # so that they are seen to be two

    def read(places: Sequence[int]) -> Iterable[Any]:
        wanted = [(columns[i][0], *channels[columns[i][0]]) for i in places if i]
        frame = file.to_dataframe(wanted, time_from_zero=False, use_interpolation=False)
        return ((frame[columns[i][0]] if i else frame.index).to_numpy() for i in places)

    return FileTable(columns, [], read)


def read_tdms(path: str) -> FileTable:
    """The channels of a TDMS file, by their groups, with the instants that waveforms imply.

    Where waveforms have clocks of their own, each is nan at the instants that others have.
    """
    from nptdms import TdmsFile

    groups = TdmsFile.open(path).groups()
    waveforms = [one for group in groups for one in group.channels() if is_waveform(one)]
    clocks = {(one.properties.get("wf_start_time"), *map(float, clock_of(one))) for one in waveforms}
    instants = union_of(waveforms) if len(clocks) > 1 else None
    return file_table(*join_parts([group_columns(group, instants) for group in groups]))


def is_waveform(channel: Any) -> bool:
    return channel.properties.get("wf_increment", 0.0) > 0.0 and len(channel) > 0


def clock_of(channel: Any) -> tuple[float, float, int]:
    """The start of a waveform, the time between its samples, and how many it has."""
    about = channel.properties
    return about.get("wf_start_offset", 0.0), about["wf_increment"], len(channel)


def instants_of(channel: Any, first: Any) -> Any:
    """The instants of a waveform [s] after the start of the first one."""
    offset, increment, count = clock_of(channel)
    start = channel.properties.get("wf_start_time")
    late = 0.0 if start is None or first is None else (start - first) / np.timedelta64(1, "s")
    return np.round(offset + late + increment * np.arange(count), 9)


def union_of(waveforms: Sequence[Any]) -> tuple[Any, Any]:
    """The start of the first waveform, and all instants of all of them."""
    first = min(
        (one.properties["wf_start_time"] for one in waveforms if "wf_start_time" in one.properties),
        default=None,
    )
    return first, np.unique(np.concatenate([instants_of(one, first) for one in waveforms]))


def group_columns(group: Any, instants: tuple[Any, Any] | None) -> Parts:
    """The channels of a group of a TDMS file, on instants of all where waveforms have clocks of their own."""
    columns: list[FileColumn] = []
    others: list[str] = []
    time: FileColumn | None = None
    for channel in group.channels():
        name = f"{group.name}.{channel.name}"
        if channel.dtype is None or channel.dtype.kind not in "fiubM":
            others.append(f"{name}: {channel.dtype}")
            continue
        unit = str(channel.properties.get("unit_string", ""))
        read = partial(channel.__getitem__, slice(None))
        count = len(channel)
        if is_waveform(channel):
            times = channel.time_track if instants is None else partial(instants.__getitem__, 1)
            if instants is not None:
                read, count = partial(spread_samples, channel, *instants), instants[1].size
            time = FileColumn(f"{group.name}.time", "s", count, times)
        columns.append(FileColumn(name, unit, count, read, channel.dtype.kind == "M"))
    return ([time, *columns] if time else columns), others


def spread_samples(channel: Any, first: Any, instants: Any) -> Any:
    """The samples of a waveform at its own instants among others, nan at these."""
    values = np.full(instants.size, np.nan)
    values[np.searchsorted(instants, instants_of(channel, first))] = channel[:]
    return values


FORMATS: dict[str, Callable[[str], FileTable]] = {
    ".mat": read_matlab,
    ".nc": read_hdf5,
    ".h5": read_hdf5,
    ".hdf5": read_hdf5,
    ".mdf": read_mdf,
    ".mf4": read_mdf,
    ".tdms": read_tdms,
}


def limit_memory(most: int) -> None:
    """Take no more than some bytes beyond what there is, where the system can see to it."""
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (most, most))


def serve_table(kind: str, path: str, memory: str) -> None:
    Thread(target=listen, daemon=True).start()
    limit_memory(int(memory))
    out, sys.stdout = os.fdopen(os.dup(1), "wb"), io.TextIOWrapper(io.BytesIO())
    os.dup2(2, 1)  # what libraries print is no answer
    table = FORMATS[kind](path)
    out.write(json.dumps([table.columns, table.others]).encode() + b"\n")
    out.flush()
    writer: Any = SimpleNamespace(write=out.write)  # numpy asks a file for its position, which a pipe has not
    for column in table.read(json.loads(ASKED.get())):
        values = column if column.dtype.kind in "fiubmM" else column.astype(str)
        write_array(writer, values, allow_pickle=False)
    out.flush()
    os._exit(0)


def listen() -> None:
    """Hear what is wanted, and end when whoever asked does."""
    ASKED.put(sys.stdin.readline())
    sys.stdin.read()
    os._exit(1)


if __name__ == "__main__":
    serve_table(*sys.argv[1:])
