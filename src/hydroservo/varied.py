"""What differs between the runs of a batch: arrays of parameters by path, checked before anything runs."""

from collections.abc import Mapping
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo.block import designed, field_at, leaves, replace, value_at
from hydroservo.checks import allowed, number
from hydroservo.errors import ParameterError
from hydroservo.loop import Loop

__all__ = ["SEED", "Columns", "checked_columns", "designs"]

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
    if path != SEED and (not isinstance(present, float) or path.startswith(("simulation.", "hold."))):
        wanted = "must be a float outside the simulation and hold blocks, or the seed"
        raise ParameterError("parameters", path, wanted)
    try:
        found = np.atleast_1d(np.asarray(values, dtype=np.float64))
    except (OverflowError, TypeError, ValueError):
        raise ParameterError(path, type(values).__name__, "must be an array of numbers") from None
    if found.ndim != 1 or not found.size:
        raise ParameterError(path, f"shape {found.shape}", "must be an array of shape (runs,)")
    field = field_at(loop, path)
    if field.derived:
        raise ParameterError("parameters", path, "is computed before a run; vary what it is computed from")
    for worst in (found[~np.isfinite(found)][:1], found.min(keepdims=True), found.max(keepdims=True)):
        for value in worst:
            number(float(value), path, field, float)
    if path == SEED and (found % 1.0).any():
        wrong = float(found[found % 1.0 != 0.0][0])
        raise ParameterError(path, wrong, f"must be {allowed(field, whole=True)}")
    return found


def designs(loop: Loop, columns: Columns) -> Columns:
    """What the controllers of runs compute before they start, where it differs between them.

    Args:
        loop: the loop, its controller designed.
        columns: what is given for each run.

    Raises:
        ParameterError: a run's parameters allow no design.
    """
    computed = [path for path, _ in leaves(loop.controller) if field_at(loop.controller, path).derived]
    ruling = [path for path in columns if path.startswith(("controller.", "nominal."))]
    if not computed or not ruling:
        return {}

    @cache
    def design(*numbers: float) -> list[float]:
        own = replace(loop, dict(zip(ruling, numbers, strict=True)))
        controller = designed(own.controller, own.simulation.period, own.nominal)
        return [value_at(controller, path) for path in computed]

    rows = zip(*(columns[path].tolist() for path in ruling), strict=True)
    table = np.array([design(*numbers) for numbers in rows], dtype=np.float64).T
    return {f"controller.{path}": row for path, row in zip(computed, table, strict=True)}
