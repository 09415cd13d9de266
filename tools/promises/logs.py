"""Logs as files of text, Parquet and MATLAB: after changes of their headers, cells and bytes."""

import io
import math
import random
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hydroservo.core.field import Field
from hydroservo.identification.log import read_log
from hydroservo.scenario.records.series import read_series

Draw = random.Random
Columns = dict[str, list[Any]]

HEADERS = ("time [s]", "command [V]", "velocity [mm/s]", "position [mm]", "pressure_a [bar]")
STRANGE = (
    "time",
    "time [ms]",
    "time [V]",
    "command",
    "v [mm/s]",
    "velocity [mm/s",
    "[s]",
    "",
    " ",
    "é [m]",
    "\x00",
    "time [s] [s]",
    "x" * 300,
    "velocity (m/s)",
    "Zeit [s]",
    "position [degC]",
)
CELLS = (
    "",
    " ",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "1e999",
    "1,5",
    "1.000,5",
    "1_000",
    "0x1p3",
    "12:30:01",
    "abc",
    '"',
    "1e-400",
    "\u2212 1",
    "\u0661",
    "1 000",
    "TRUE",
    "#N/A",
)
NUMBERS = (math.nan, math.inf, -math.inf, 0.0, -1.0, 1e308, 1e-308, 5e-324)
SIGNAL = Field("m/s", "velocity")


def clean(rows: int = 24) -> Columns:
    """A log with nothing wrong."""
    time = [round(0.001 * i, 6) for i in range(rows)]
    return {
        name: time if i == 0 else [round(math.sin(i + 40.0 * t), 6) for t in time]
        for i, name in enumerate(HEADERS)
    }


def read(path: Path) -> None:
    """Read a log as ``identify`` does, and, of text, as a recorded demand."""
    if path.suffix == ".csv" and path.stem == "demand":
        read_series(path, SIGNAL, "velocity")
    else:
        read_log(path, {})


def drawn_log(draw: Draw) -> tuple[str, bytes, Any]:
    """The name of a log's file, what is in it, and that in words."""
    columns = clean(draw.choice((0, 1, 2, 16, 24)))
    changed = columns
    for _ in range(draw.choice((0, 1, 1, 2, 3))):
        changed = change(changed, draw)
    name = draw.choice(
        [*["log.csv"] * 20, *["demand.csv"] * 12, *["log.parquet"] * 8, *["log.mat"] * (draw.random() < 0.2)]
    )
    content = WRITERS[name.rpartition(".")[2]](changed, draw)
    if draw.random() < 0.3:
        content = bytes_changed(content, draw)
    return name, content, [name, content.decode("latin-1")]


def change(columns: Columns, draw: Draw) -> Columns:
    """A log with one change."""
    pairs = [(name, list(cells)) for name, cells in columns.items()]
    at = draw.randrange(len(pairs))
    name, cells = pairs[at]
    how = draw.randrange(6)
    if how == 0:
        pairs[at] = draw.choice(STRANGE), cells
    elif how == 1 and len(pairs) > 1:
        del pairs[at]
    elif how == 2:
        draw.shuffle(pairs)
    elif cells and how == 3:
        cells[draw.randrange(len(cells))] = draw.choice(CELLS)
    elif cells and how == 4:
        cells[draw.randrange(len(cells))] = draw.choice(NUMBERS)
    else:
        pairs[at] = name, cells[: draw.randrange(len(cells) + 1)]
    return dict(pairs)


def text(columns: Columns, draw: Draw) -> bytes:
    """Columns as text, between marks of one kind."""
    mark = draw.choice((",", ",", ",", ";", "\t"))
    longest = max(map(len, columns.values()), default=0)
    rows = [[str(cells[i]) if i < len(cells) else "" for cells in columns.values()] for i in range(longest)]
    lines = [mark.join(map(str, row)) for row in ([*columns], *rows)]
    return draw.choice(("\n", "\n", "\r\n")).join(lines).encode("utf-8", "replace")


def parquet(columns: Columns, _draw: Draw) -> bytes:
    import pyarrow as pa
    import pyarrow.parquet as pq

    file = io.BytesIO()
    longest = max(map(len, columns.values()), default=0)
    padded = [array(cells, longest) for cells in columns.values()]
    pq.write_table(pa.table(padded, names=list(columns)), file)
    return file.getvalue()


def array(cells: Sequence[Any], length: int) -> Any:
    """Cells as a column: of numbers, or of text if any is."""
    import pyarrow as pa

    padded = [*cells, *[None] * (length - len(cells))]
    return pa.array(
        [None if one is None else str(one) for one in padded]
        if any(isinstance(one, str) for one in cells)
        else padded,
        pa.string() if any(isinstance(one, str) for one in cells) else pa.float64(),
    )


def matlab(columns: Columns, _draw: Draw) -> bytes:
    from scipy.io import savemat

    file = io.BytesIO()
    names = {re.sub(r"[^A-Za-z_]", "x", name.partition(" ")[0] or "x")[:31]: name for name in columns}
    rows: dict[str, Any] = {short: np.array(columns[name]) for short, name in names.items()}
    units = {short: name.partition("[")[2].rstrip("]") for short, name in names.items()}
    savemat(file, rows | {"units": units}, do_compression=False)
    return file.getvalue()


WRITERS: Mapping[str, Callable[[Columns, Draw], bytes]] = {"csv": text, "parquet": parquet, "mat": matlab}


def bytes_changed(content: bytes, draw: Draw) -> bytes:
    """Bytes with some of them exchanged, left out or said twice."""
    found = bytearray(content)
    for _ in range(draw.choice((1, 2, 8))):
        if found:
            at = draw.randrange(len(found))
            found[at : at + draw.choice((0, 1, 4))] = draw.choice(
                (bytes([draw.randrange(256)]), b"", b"\0\0\0\0", found[at : at + 20])
            )
    return bytes(found)


def wrong_log(draw: Draw) -> tuple[str, bytes, Any, str]:
    """A log that must be refused: as :func:`drawn_log`, and what is wrong with it."""
    columns = clean()
    kind = draw.choice([*["csv"] * 20, *["parquet"] * 10, "mat"])
    said = draw.choice(
        (
            "no unit",
            "a wrong dimension",
            "no time",
            "time that stands",
            "infinite",
            "too few",
            "no number",
            "a time that is nan",
        )
    )
    at = draw.randrange(1, 24)
    if said == "no unit":
        columns = {name.replace(" [s]", ""): cells for name, cells in columns.items()}
    elif said == "a wrong dimension":
        columns = {
            name.replace("mm/s", draw.choice(("bar", "mm", "kg/s"))): cells for name, cells in columns.items()
        }
    elif said == "no time":
        del columns["time [s]"]
    elif said == "time that stands":
        columns["time [s]"][at] = columns["time [s]"][at - 1]
    elif said == "infinite":
        columns[draw.choice(HEADERS)][at] = draw.choice((math.inf, -math.inf))
    elif said == "too few":
        columns = {name: cells[: draw.randrange(16)] for name, cells in columns.items()}
    elif said == "no number":
        columns[draw.choice(HEADERS)][at] = "abc"
    else:
        columns["time [s]"][at] = math.nan
    content = WRITERS[kind](columns, draw)
    return f"log.{kind}", content, [said, kind, at], said
