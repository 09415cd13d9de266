"""Logs in formats that hold numbers as they are: Parquet, MATLAB, NetCDF and MDF."""

import io
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import HydroservoError, ScenarioError
from hydroservo.identification.signals import TIME
from hydroservo.identification.text_tables import Choose, Samples

__all__ = ["BINARY", "read_binary_table"]

MAT_PROCESS = Path(__file__).with_name("mat_process.py")
Found = Mapping[str, NDArray[Any]]  # by header, such as "velocity [m/s]"


def read_binary_table(path: Path, choose: Choose) -> tuple[Samples, list[str]]:
    """The chosen columns of a file whose ending is one of :data:`BINARY`, in its units, and all headers.

    Args:
        path: of the file.
        choose: the columns.

    Raises:
        ScenarioError: it cannot be read, or a column is no row of numbers as long as the time's.
    """
    name = str(path)
    try:
        table = BINARY[path.suffix.lower()](path)
    except HydroservoError:
        raise
    except Exception as error:  # whatever a library says of a file that is not what its ending says
        raise ScenarioError(name, "", f"cannot be read as {path.suffix.lower()}: {error}") from None
    headers = list(table)
    columns = choose(headers)
    found = {one.signal: numbers(table[headers[one.place]], name, one.header) for one in columns}
    for one in columns:
        if found[one.signal].size != found[TIME].size:
            problem = f"has {found[one.signal].size} samples, and the time {found[TIME].size}"
            raise ScenarioError(name, f"column {one.header}", problem)
    late = np.flatnonzero(~(np.diff(found[TIME]) > 0.0))
    if late.size:
        problem = "is not after the instant in the row before"
        raise ScenarioError(name, f"row {late[0] + 2}, column {columns[0].header}", problem)
    return found, headers


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


def parquet(path: Path) -> Found:
    import pyarrow.parquet as pq

    table = pq.read_table(path)
    units = [(field.metadata or {}).get(b"units", b"").decode() for field in table.schema]
    pairs = zip(table.column_names, units, strict=True)
    return {headed(name, unit): table.column(name).to_numpy() for name, unit in pairs}


def matlab(path: Path) -> Found:
    command = [sys.executable, "-P", str(MAT_PROCESS), str(path)]
    done = subprocess.run(command, capture_output=True, check=False)  # noqa: S603 - our own program
    if done.returncode:
        said = done.stderr.decode("utf-8", "replace").strip().rpartition("\n")[2]
        raise ValueError(said if done.returncode > 0 else "it is damaged")
    with np.load(io.BytesIO(done.stdout)) as archive:
        names = archive["names"].tolist()
        return {headed(name, unit): archive[f"arr_{i}"] for i, (name, unit) in enumerate(names)}


def netcdf(path: Path) -> Found:
    import xarray as xr

    with xr.open_dataset(path, decode_times=False) as data:
        rows = {str(name): one for name, one in data.variables.items() if one.ndim == 1}
        return {headed(name, one.attrs.get("units")): one.values for name, one in rows.items()}


def mdf(path: Path) -> Found:
    """Where signals were sampled at instants of their own, each is nan at those of the others."""
    try:
        from asammdf import MDF
    except ImportError:
        raise HydroservoError("an MDF file needs asammdf: pip install 'hydroservo[mdf]'") from None
    with MDF(path) as file:
        frame = file.to_dataframe(time_from_zero=False, use_interpolation=False)
        units = {name: file.get(name).unit for name in frame.columns}
    columns = {headed(name, units[name]): frame[name].to_numpy() for name in frame.columns}
    return {"time [s]": frame.index.to_numpy(), **columns}


BINARY: Mapping[str, Callable[[Path], Found]] = {
    ".parquet": parquet,
    ".mat": matlab,
    ".nc": netcdf,
    ".mf4": mdf,
    ".mdf": mdf,
}
"""What reads a file, by its ending."""
