"""What differs between the runs of a batch: arrays of parameters by path, checked before anything runs."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo.block import field_at, value_at
from hydroservo.checks import allowed, number
from hydroservo.errors import ParameterError
from hydroservo.loop import Loop

__all__ = ["SEED", "Columns", "checked_columns"]

SEED = "simulation.seed"  # the one whole number that may differ between runs; doubles hold it exactly

Columns = dict[str, NDArray[np.float64]]


def checked_columns(loop: Loop, parameters: Mapping[str, ArrayLike]) -> Columns:
    """The parameters as vectors of one length, each number in the range of its field.

    Raises:
        ParameterError: they are not.
    """
    if not isinstance(parameters, Mapping):
        raise ParameterError("parameters", type(parameters).__name__, "must map paths to arrays of numbers")
    columns = {path: column(loop, path, values) for path, values in parameters.items()}
    sizes = {path: values.size for path, values in columns.items()}
    if not sizes:
        raise ParameterError("parameters", "{}", "must name at least one parameter")
    if len(set(sizes.values())) > 1:
        raise ParameterError("parameters", sizes, "must be arrays of one length")
    return columns


def column(loop: Loop, path: str, values: ArrayLike) -> NDArray[np.float64]:
    try:
        present = value_at(loop, str(path))
    except KeyError as error:
        raise ParameterError("parameters", path, error.args[0]) from None
    if path != SEED and (not isinstance(present, float) or path.startswith("simulation.")):
        raise ParameterError("parameters", path, "must be a float outside the simulation block, or its seed")
    try:
        found = np.atleast_1d(np.asarray(values, dtype=np.float64))
    except (OverflowError, TypeError, ValueError):
        raise ParameterError(path, type(values).__name__, "must be an array of numbers") from None
    if found.ndim != 1 or not found.size:
        raise ParameterError(path, f"shape {found.shape}", "must be an array of shape (runs,)")
    field = field_at(loop, path)
    for worst in (found[~np.isfinite(found)][:1], found.min(keepdims=True), found.max(keepdims=True)):
        for value in worst:
            number(float(value), path, field, float)
    if path == SEED and (found % 1.0).any():
        wrong = float(found[found % 1.0 != 0.0][0])
        raise ParameterError(path, wrong, f"must be {allowed(field, whole=True)}")
    return found
