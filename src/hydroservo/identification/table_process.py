"""Reads a MAT or MDF file in a process of its own: its library may crash, chatter or leave copies.

    python -P table_process.py FORMAT FILE MEMORY

The first line of standard output is a list of the columns in JSON: name, unit and number of samples of each.
The first line of standard input then names those that are wanted, by their numbers, which follow one after
the other as numpy's arrays. The process ends with standard input, and takes no more memory than it may.
"""

import contextlib
import io
import json
import os
import re
import sys
from collections.abc import Callable, Sequence
from queue import Queue
from threading import Thread
from types import SimpleNamespace
from typing import Any, NamedTuple

from numpy.lib.format import write_array

__all__: list[str] = []

NUMBERS = re.compile("double|single|u?int[0-9]+|logical")  # kinds of MATLAB's
ASKED: Queue[str] = Queue(1)


class Table(NamedTuple):
    """The columns of a file, and what reads some of them."""

    columns: list[tuple[str, str, int]]  # name, unit, samples
    read: Callable[[Sequence[int]], list[Any]]


def matlab(path: str) -> Table:
    """The rows of numbers of a MATLAB file; those in matrices and structures are not seen."""
    from scipy.io import loadmat, whosmat

    found = {name: (shape, kind) for name, shape, kind in whosmat(path)}
    rows = {
        name: max(shape)
        for name, (shape, kind) in found.items()
        if NUMBERS.fullmatch(kind) and sum(size != 1 for size in shape) == 1
    }
    options: dict[str, Any] = {"squeeze_me": True, "simplify_cells": True}
    units = loadmat(path, variable_names=["units"], **options).get("units") if "units" in found else {}
    unit_of = units if isinstance(units, dict) else {}
    columns = [(name, str(unit_of.get(name, "")), count) for name, count in rows.items()]

    def read(chosen: Sequence[int]) -> list[Any]:
        names = [columns[i][0] for i in chosen]
        table = loadmat(path, variable_names=names, **options)
        return [table[name] for name in names]

    return Table(columns, read)


def mdf(path: str) -> Table:
    """The channels of an MDF file; each is nan at the instants that others have of their own."""
    from asammdf import MDF

    file: Any = MDF(path)
    channels: dict[str, tuple[int, int]] = {}
    samples = 0
    for group, part in enumerate(file.groups):
        master, count = file.masters_db.get(group), int(part.channel_group.cycles_nr)
        samples += count
        for index, channel in enumerate(part.channels):
            if index != master and channel.name not in channels:
                channels[channel.name] = (group, index)
    columns = [("time", "s", samples)]
    columns += [(name, file.get_channel_unit(name, *place), samples) for name, place in channels.items()]

    def read(chosen: Sequence[int]) -> list[Any]:
        names = [columns[i][0] for i in chosen if i]
        wanted = [(name, *channels[name]) for name in names]
        frame = file.to_dataframe(wanted, time_from_zero=False, use_interpolation=False)
        return [frame[columns[i][0]].to_numpy() if i else frame.index.to_numpy() for i in chosen]

    return Table(columns, read)


FORMATS: dict[str, Callable[[str], Table]] = {".mat": matlab, ".mdf": mdf, ".mf4": mdf}


def limit_memory(most: int) -> None:
    """Take no more than some bytes beyond what there is, where the system can see to it."""
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (most, most))


def main(kind: str, path: str, memory: str) -> None:
    Thread(target=listen, daemon=True).start()
    limit_memory(int(memory))
    out, sys.stdout = os.fdopen(os.dup(1), "wb"), io.TextIOWrapper(io.BytesIO())
    os.dup2(2, 1)  # what libraries print is no answer
    table = FORMATS[kind](path)
    out.write(json.dumps(table.columns).encode() + b"\n")
    out.flush()
    writer: Any = SimpleNamespace(write=out.write)  # numpy asks a file for its position, which a pipe has not
    for column in table.read(json.loads(ASKED.get())):
        values = column if column.dtype.kind in "fiub" else column.astype(str)
        write_array(writer, values, allow_pickle=False)
    out.flush()
    os._exit(0)


def listen() -> None:
    """Hear what is wanted, and end when whoever asked does."""
    ASKED.put(sys.stdin.readline())
    sys.stdin.read()
    os._exit(1)


if __name__ == "__main__":
    main(*sys.argv[1:])
