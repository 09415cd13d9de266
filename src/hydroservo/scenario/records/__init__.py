"""Records of signals in files: text, Parquet, MATLAB, NetCDF, HDF5, MDF and TDMS."""

from hydroservo.scenario.records.columns import (
    ColumnSource,
    Header,
    RecordColumn,
    choose_columns,
    column_source,
)
from hydroservo.scenario.records.read import RECORD_ENDINGS, read_columns
from hydroservo.scenario.records.series import read_curve

__all__ = [
    "RECORD_ENDINGS",
    "ColumnSource",
    "Header",
    "RecordColumn",
    "choose_columns",
    "column_source",
    "read_columns",
    "read_curve",
]
