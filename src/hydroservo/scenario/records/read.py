"""Columns of a record, by the ending of its file."""

from pathlib import Path

import numpy as np

from hydroservo.errors import ScenarioError
from hydroservo.inputs import exists
from hydroservo.scenario.records.binary import BINARY, read_binary_columns
from hydroservo.scenario.records.columns import TIME, Choose, Record
from hydroservo.scenario.records.text import read_text_columns

LARGEST = 512 << 20  # bytes
RECORD_ENDINGS = (".csv", ".txt", *BINARY)
"""Of files that a page offers; text may have any other, too."""


def read_columns(path: Path, choose: Choose, period: float | None = None, *, gaps: bool = True) -> Record:
    """The chosen columns of a file, in SI units.

    Args:
        path: of the file: Parquet, MATLAB, NetCDF, HDF5, MDF or TDMS by its ending, else text.
        choose: the columns, by the headers.
        period: of the samples [s] where no column holds their instants.
        gaps: samples may be missing, and are nan; else each must be there.

    Raises:
        ScenarioError: in one line, the file, the place and what is wrong there.
    """
    name = str(path)
    if not exists(path):
        raise ScenarioError(name, "", "there is no such file")
    if path.suffix.lower() in BINARY:
        record = read_binary_columns(path, choose, LARGEST, gaps=gaps)
    else:
        record = read_text_columns(path, choose, LARGEST, gaps=gaps, fewest=1 if period else 2)
    samples = {column.signal: column.in_si(record.samples[column.signal]) for column in record.columns}
    for column in record.columns:
        if np.isinf(samples[column.signal]).any():
            raise ScenarioError(name, f"column {column.header.text}", "has numbers that overflow in SI units")
    if period is not None:
        count = next(iter(samples.values())).size
        samples[TIME] = period * np.arange(count, dtype=np.float64)
    return record._replace(samples=samples)
