"""Records of signals in files: text, Parquet, MATLAB, NetCDF, HDF5, MDF and TDMS."""

from hydroservo.scenario.records.columns import Column, ColumnSource, Header, choose_columns, column_source
from hydroservo.scenario.records.read import RECORD_ENDINGS, read_columns
from hydroservo.scenario.records.series import recorded

__all__ = [
    "RECORD_ENDINGS",
    "Column",
    "ColumnSource",
    "Header",
    "choose_columns",
    "column_source",
    "read_columns",
    "recorded",
]
