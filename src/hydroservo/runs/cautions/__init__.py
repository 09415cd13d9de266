"""What is doubtful of a loop or a run: lines of the attribute ``warning`` of its result.

The modules find them, and :mod:`.every` has the list. Those of records are not in it:
:mod:`.records` looks at the loop alone, before it is run.
"""

import inspect
import warnings
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, Protocol, Self, TypeVar

from hydroservo.core.errors import HydroservoWarning

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["WithAttributes", "quietly", "warnings_of", "warns", "with_warning"]

P = ParamSpec("P")


class WithAttributes(Protocol):
    """A result with attributes: a Dataset, or a Trace."""

    @property
    def attrs(self) -> Mapping[Any, Any]: ...

    def assign_attrs(self, **attrs: Any) -> Self: ...


Result = TypeVar("Result", bound=WithAttributes)


def warns(function: "Callable[P, xr.Dataset]") -> "Callable[P, xr.Dataset]":
    """A function that says its result's ``warning`` as a :class:`HydroservoWarning` of its caller's line."""

    @wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> "xr.Dataset":
        data = function(*args, **kwargs)
        for line in warnings_of(data):
            warnings.warn(line, HydroservoWarning, stacklevel=2)
        return data

    return called


def quietly(function: "Callable[P, xr.Dataset]") -> "Callable[P, xr.Dataset]":
    """A function that says warnings, without that: its result has them all the same."""
    inner: Callable[P, xr.Dataset] = inspect.unwrap(function)
    return inner


def with_warning(data: Result, lines: Iterable[str]) -> Result:
    """A result whose ``warning`` has these lines too, each once and empty ones left out."""
    said = warnings_of(data)
    every = list(dict.fromkeys(filter(None, [*said, *lines])))
    return data if every == said else data.assign_attrs(warning="\n".join(every))


def warnings_of(data: WithAttributes) -> list[str]:
    """The lines of a result's ``warning``."""
    return str(data.attrs.get("warning", "")).splitlines()
