"""What a run leaves on disk, and what it says in numbers."""

import json
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydroservo.core.command_scale import in_command_unit
from hydroservo.core.errors import HydroservoError, ParameterError, require
from hydroservo.core.field import Field
from hydroservo.core.outputs import atomic_path
from hydroservo.runs.arguments import checked_path, checked_run, is_result
from hydroservo.show.files import json_value

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    import pyarrow as pa
    import xarray as xr


def save(dataset: "xr.Dataset", path: Path | str) -> Path:
    """Write the trajectory of a run, or the table of many, in the format that the file's ending names.

    All are in SI units, but on the command line the commands of a ``.csv``, which are in the scenario's.
    ``.csv`` has the unit in each column's header, 0 or 1 for a flag, and nothing but columns. ``.parquet``
    (units, attributes and a run's metrics in the schema's metadata), ``.nc`` (NetCDF 3, 0 or 1 for a flag)
    and ``.mat`` (MATLAB 5, dots in names become underscores) hold everything.

    Returns:
        The path written.

    Raises:
        ParameterError: it is not what ``simulate`` or ``simulate_batch`` returned, or the path is none.
        HydroservoError: the ending names no format, or the file cannot be written.
    """
    if not is_result(dataset):
        raise ParameterError("dataset", dataset, "must be what simulate or simulate_batch returned")
    path = checked_path("path", path)
    form = FORMATS.get(path.suffix.lower())
    if form is None:
        endings = ", ".join(FORMATS)
        raise HydroservoError(
            f"{path}: the ending {path.suffix!r} is not a known format; use one of {endings}"
        )
    with atomic_path(path) as temporary:
        form.write(dataset, temporary)
    return path


def metrics_of(dataset: "xr.Dataset") -> dict[str, float | bool]:
    """The metrics of a run by name, in SI units.

    Args:
        dataset: what ``simulate`` returned.

    Raises:
        ParameterError: it is something else, such as the table of many runs.
    """
    return scalars_of(checked_run(dataset, "dataset"))


def scalars_of(dataset: "xr.Dataset") -> dict[str, float | bool]:
    """The metrics of a run by name; of the table of many runs none."""
    return {
        str(name): variable.values.item() for name, variable in dataset.data_vars.items() if not variable.dims
    }


def trajectory_of(dataset: "xr.Dataset") -> dict[str, Any]:
    """Each recorded signal of a run by its path, time first: arrays of one length, in SI units.

    Of the table of many runs, each column, the number of the run first.
    """
    (index,) = map(str, dataset.dims)
    signals = {str(name): variable.values for name, variable in dataset.data_vars.items() if variable.dims}
    return {index: dataset[index].values, **signals}


def scenario_tables(dataset: "xr.Dataset") -> dict[str, Any]:
    """The scenario of a run as nested tables, every value in SI units."""
    return tomllib.loads(dataset.attrs["scenario"])


def metric_fields(dataset: "xr.Dataset") -> dict[str, Field]:
    """The declaration of each metric of a run, or of the table of many, by name."""
    dims = ("run",) if "run" in dataset.dims else ()
    return {
        str(name): Field(
            about["units"],
            about["long_name"],
            smaller_is_better=about.get("better") == "smaller",
            least_is_worst=about.get("worst") == "least",
        )
        for name, variable in dataset.data_vars.items()
        if variable.dims == dims and "kind" in (about := variable.attrs)
    }


def best_runs(runs: Sequence[Mapping[str, float | bool]], name: str) -> set[int]:
    """Which runs, given by their metrics, have the smallest value of one.

    None where there is nothing to choose between. A run that diverged or lacks the metric is never best.
    """
    values = {
        i: metrics[name]
        for i, metrics in enumerate(runs)
        if not metrics["diverged"] and math.isfinite(metrics.get(name, math.nan))
    }
    best = {i for i, value in values.items() if value == min(values.values())}
    return best if len(best) < len(values) else set()


def metrics_csv(runs: "pd.DataFrame", fields: Mapping[str, Field]) -> str:
    """A row for each run, in SI units and that of commands, which the headers name; flags are 0 or 1."""
    named = {name: in_command_unit(field.unit) for name, field in fields.items() if field.unit}
    factors = {name: factor for name, (_, factor) in named.items() if factor != 1.0 and name in runs}
    units = {name: f"{name} [{unit}]" for name, (unit, _) in named.items()}
    flags = [name for name, kind in runs.dtypes.items() if kind.kind == "b"]
    scaled = runs.assign(**{name: runs[name] * factor for name, factor in factors.items()})
    table = scaled.astype(dict.fromkeys(flags, int)).rename(columns=units)
    return str(table.to_csv(index=False, na_rep="nan", lineterminator="\n"))


def variable_unit(dataset: "xr.Dataset", name: str) -> str:
    return str(dataset[name].attrs.get("units", ""))


def save_csv(dataset: "xr.Dataset", path: Path) -> None:
    import pandas as pd

    columns = {}
    for name, values in trajectory_of(dataset).items():
        unit, factor = in_command_unit(variable_unit(dataset, name))
        scaled = values * 1 if values.dtype == bool else values if factor == 1.0 else values * factor
        columns[f"{name} [{unit}]" if unit else name] = scaled
    pd.DataFrame(columns, copy=False).to_csv(path, index=False, na_rep="nan", lineterminator="\n")


def save_parquet(dataset: "xr.Dataset", path: Path) -> None:
    require("pyarrow", "parquet", "Parquet")
    import pyarrow.parquet as pq

    pq.write_table(arrow_table(dataset), path)


def arrow_table(dataset: "xr.Dataset") -> "pa.Table":
    """A trajectory or a table as Arrow has it, with units and attributes in its schema's metadata."""
    import pyarrow as pa

    columns = trajectory_of(dataset)
    fields = [
        pa.field(name, arrow_type(values.dtype), metadata=text_attributes(dataset[name].attrs))
        for name, values in columns.items()
    ]
    metrics = scalars_of(dataset)
    about = text_attributes(dataset.attrs) | ({"metrics": json.dumps(json_value(metrics))} if metrics else {})
    return pa.table(columns, schema=pa.schema(fields, metadata=about))


def arrow_type(kind: "np.dtype[Any]") -> "pa.DataType":
    """Arrow's type for a column; texts of a table that is read as needed are objects."""
    import pyarrow as pa

    return pa.string() if kind.kind == "O" else pa.from_numpy_dtype(kind)


def save_netcdf(dataset: "xr.Dataset", path: Path) -> None:
    # NetCDF 3 knows no booleans and no 64-bit integers, which seeds may need; doubles hold them exactly.
    known = {"bool": "int8", "int64": "float64"}
    other = {
        name: dataset[name].astype(known[str(variable.dtype)])
        for name, variable in dataset.data_vars.items()
        if str(variable.dtype) in known
    }
    dataset.assign(other).assign_attrs(text_attributes(dataset.attrs)).to_netcdf(path, engine="scipy")


def save_mat(dataset: "xr.Dataset", path: Path) -> None:
    from scipy.io import savemat

    columns = trajectory_of(dataset)
    names = matlab_names(columns)
    metrics = scalars_of(dataset)
    groups = {
        "units": {names.get(name, name): variable_unit(dataset, name) for name in [*columns, *metrics]},
        "attributes": {str(name): value for name, value in dataset.attrs.items()},
    } | ({"metrics": metrics} if metrics else {})
    signals = {names[name]: values for name, values in columns.items()}
    savemat(path, signals | groups, oned_as="column", long_field_names=True, do_compression=True)


def matlab_names(paths: Iterable[str]) -> dict[str, str]:
    """A legal and distinct MATLAB name for each path: letters, digits and underscores, 63 at most."""
    names: dict[str, str] = {}
    for path in paths:
        legal = re.sub(r"[^A-Za-z0-9_]", "_", path)
        legal = legal if legal[:1].isalpha() else f"x{legal}"
        name, count = legal[:63], 1
        while name in names.values():
            count += 1
            name = f"{legal[:60]}_{count}"
        names[path] = name
    return names


def text_attributes(attributes: Mapping[Any, Any]) -> dict[str, str]:
    return {str(name): str(value) for name, value in attributes.items()}


class ResultFormat(StrEnum):
    """The formats of a trajectory or a table, by the name that ``--format`` gives them."""

    ending: str  # of the file's name
    write: Callable[["xr.Dataset", Path], None]  # writes a dataset to a file

    def __new__(cls, name: str, ending: str, write: Callable[["xr.Dataset", Path], None]) -> "ResultFormat":
        form = str.__new__(cls, name)
        form._value_, form.ending, form.write = name, ending, write
        return form

    CSV = "csv", ".csv", save_csv
    PARQUET = "parquet", ".parquet", save_parquet
    NETCDF = "netcdf", ".nc", save_netcdf
    MAT = "mat", ".mat", save_mat


FORMATS: Mapping[str, ResultFormat] = {form.ending: form for form in ResultFormat}
"""The formats by the file's ending."""
