"""Columns of a record, by the ending of its file."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hydroservo.errors import ScenarioError
from hydroservo.inputs import exists
from hydroservo.scenario.records.binary import BINARY, read_binary
from hydroservo.scenario.records.columns import Column
from hydroservo.scenario.records.headers import Header
from hydroservo.scenario.records.text import TIME, Choose, Samples, read_text

__all__ = ["ENDINGS", "LARGEST", "read_columns"]

LARGEST = 512 << 20  # bytes
ENDINGS = (".csv", ".txt", *BINARY)
"""Of files that a page offers; text may have any other, too."""


def read_columns(
    path: Path, choose: Choose, period: float | None = None, *, gaps: bool = True
) -> tuple[Samples, list[Header]]:
    """The chosen columns of a file in SI units, and all headers.

    Args:
        path: of the file: Parquet, MATLAB, NetCDF, HDF5, MDF or TDMS by its ending, else text.
        choose: the columns, by the headers.
        period: of the samples [s] where no column holds their instants.
        gaps: samples may be missing, and are nan; else each must be there.

    Raises:
        ScenarioError: in one line, the file, the place and what is wrong there.
    """
    name, kind = str(path), path.suffix.lower()
    if not exists(path):
        raise ScenarioError(name, "", "there is no such file")
    chosen: list[Column] = []

    def remember(headers: Sequence[Header], place: str) -> list[Column]:
        chosen[:] = choose(headers, place)
        return chosen

    if kind in BINARY:
        raw, headers = read_binary(path, remember, LARGEST, gaps=gaps)
    else:
        raw, headers = read_text(path, remember, LARGEST, gaps=gaps, fewest=1 if period else 2)
    samples = {column.signal: column.in_si(raw[column.signal]) for column in chosen}
    for column in chosen:
        if np.isinf(samples[column.signal]).any():
            raise ScenarioError(name, f"column {column.header.text}", "has numbers too large for SI units")
    if period is not None:
        count = next(iter(samples.values())).size
        samples[TIME] = period * np.arange(count, dtype=np.float64)
    return samples, headers
