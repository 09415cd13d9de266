"""What the user of a result should know of it, in lines of its attribute ``warning``."""

import inspect
import warnings
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, Protocol, Self, TypeVar

import numpy as np

from hydroservo.constants import ATMOSPHERE
from hydroservo.errors import HydroservoWarning

if TYPE_CHECKING:
    import xarray as xr

Arguments = ParamSpec("Arguments")


class WithAttributes(Protocol):
    """A result with attributes: a Dataset, or a Trace."""

    @property
    def attrs(self) -> Mapping[Any, Any]: ...

    def assign_attrs(self, **attrs: Any) -> Self: ...


Result = TypeVar("Result", bound=WithAttributes)


def warns(function: "Callable[Arguments, xr.Dataset]") -> "Callable[Arguments, xr.Dataset]":
    """A function that says its result's ``warning`` as a :class:`HydroservoWarning` of its caller's line."""

    @wraps(function)
    def called(*args: Arguments.args, **kwargs: Arguments.kwargs) -> "xr.Dataset":
        data = function(*args, **kwargs)
        for line in warnings_of(data):
            warnings.warn(line, HydroservoWarning, stacklevel=2)
        return data

    return called


def quietly(function: "Callable[Arguments, xr.Dataset]") -> "Callable[Arguments, xr.Dataset]":
    """A function that says warnings, without that: its result has them all the same."""
    inner: Callable[Arguments, xr.Dataset] = inspect.unwrap(function)
    return inner


def with_warning(data: Result, lines: Iterable[str]) -> Result:
    """A result whose ``warning`` has these lines too, each once and empty ones left out."""
    said = warnings_of(data)
    every = list(dict.fromkeys(filter(None, [*said, *lines])))
    return data if every == said else data.assign_attrs(warning="\n".join(every))


def warnings_of(data: WithAttributes) -> list[str]:
    """The lines of a result's ``warning``."""
    return str(data.attrs.get("warning", "")).splitlines()


def pressure_caution(data: Mapping[Any, Any]) -> str:
    """That a chamber's pressure fell below absolute zero, in a run or in some of many; else empty."""
    if "pressure_min" not in data:
        return ""
    lost = np.isfinite(data["diverged_at"])  # what overflows passes every pressure
    lowest = np.where(lost, np.nan, data["pressure_min"])
    below = np.atleast_1d(lowest < -ATMOSPHERE)
    if not below.any():
        return ""
    where = "" if lowest.ndim == 0 else f" in {below.sum():,} of {below.size:,} runs"
    return (
        f"the pressure in a chamber fell to {1e-5 * np.nanmin(lowest):.3g} bar{where}, below absolute "
        f"zero ({-1e-5 * ATMOSPHERE:.3g} bar gauge): real oil cavitates before that, as an AeratedOil does"
    )
