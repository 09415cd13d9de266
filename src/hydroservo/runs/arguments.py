"""What the functions of ``import hydroservo as hs`` are given: of the right kind, or refused in one line."""

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

from hydroservo.control.loop import Loop
from hydroservo.core.block import is_block
from hydroservo.core.errors import ParameterError, short

if TYPE_CHECKING:
    import xarray as xr


def checked_loop(value: object, name: str = "loop") -> Loop:
    """A loop, with a block in each of its places."""
    if not isinstance(value, Loop):
        named = isinstance(value, str | Path)
        hint = f"load_scenario({short(str(value))}) makes one" if named else "such as load_scenario returns"
        raise ParameterError(name, value, f"must be a Loop; {hint}" if named else f"must be a Loop, {hint}")
    for field, block in value._asdict().items():
        if not is_block(block):
            given = (
                "; simulate, simulate_batch and Aim take monitors as metrics" if field == "metrics" else ""
            )
            raise ParameterError(
                field, block, f"must be a block: a NamedTuple with the methods of its role{given}"
            )
    return value


def checked_loops(value: object, name: str = "loops") -> list[Loop]:
    found = as_list(name, value, "loops, such as [loop]")
    if not found:
        raise ParameterError(name, value, "must be at least one")
    return [checked_loop(one, f"{name}[{i}]") for i, one in enumerate(found)]


def checked_mapping(name: str, value: object, wanted: str) -> Mapping[Any, Any]:
    if not isinstance(value, Mapping):
        raise ParameterError(name, value, f"must map {wanted}")
    return value


def as_list(name: str, value: object, wanted: str) -> list[Any]:
    """What a list or another iterable holds that is no text, no mapping and no block."""
    if not isinstance(value, Iterable) or isinstance(value, str | Path | Mapping | type) or is_block(value):
        raise ParameterError(name, value, f"must be a list of {wanted}")
    return list(value)


def checked_path(name: str, value: object) -> Path:
    """The path of a file or a folder."""
    if not isinstance(value, str | os.PathLike):
        raise ParameterError(name, value, "must be a path: a string or a pathlib.Path")
    return Path(value)


def is_result(value: object) -> TypeGuard["xr.Dataset"]:
    """Whether it is what ``simulate`` or ``simulate_batch`` returned."""
    import xarray as xr

    return isinstance(value, xr.Dataset) and "scenario" in value.attrs


def checked_run(value: object, name: str = "run") -> "xr.Dataset":
    """What ``simulate`` returned."""
    if is_result(value) and "run" not in value.dims:
        return value
    table = "; of the table of many runs, table['rms_error'] has a metric of each" if is_result(value) else ""
    raise ParameterError(name, value, f"must be what simulate returned{table}")


def check_one_signal(name: str, signals: Sequence[str]) -> None:
    """Refuse runs or loops side by side whose errors are of different signals."""
    if len(set(signals)) > 1:
        every = ", ".join(dict.fromkeys(signals))
        raise ParameterError(name, every, "must all be of one controlled signal")


def checked_runs(value: object, name: str = "runs") -> list["xr.Dataset"]:
    """What ``simulate`` returned for each of some runs, at least one."""
    found = [] if is_result(value) else as_list(name, value, "what simulate returned for each run")
    if not found:
        raise ParameterError(name, value, "must be a list of what simulate returned, with at least one run")
    return [checked_run(one, f"{name}[{i}]") for i, one in enumerate(found)]


def checked_table(value: object, name: str = "table") -> "xr.Dataset":
    """What ``simulate_batch`` returned."""
    if is_result(value) and "run" in value.dims:
        return value
    raise ParameterError(name, value, "must be what simulate_batch returned")
