"""What differs between the runs of a batch: arrays of parameters by path, checked before anything runs."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace as replaced
from functools import cache, partial
from inspect import getattr_static
from itertools import repeat
from types import FunctionType, MethodType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo.control.loop import Loop, MachineState
from hydroservo.control.wiring import believed
from hydroservo.core.block import Block, field_at, is_block, leaves, replace, value_at
from hydroservo.core.errors import ParameterError
from hydroservo.core.hooks import designed, resting
from hydroservo.core.validation import allowed, check_own, checked_number
from hydroservo.runs.arguments import checked_mapping
from hydroservo.runs.steady import starts_found
from hydroservo.runs.step_sizes import fastest_rate

SEED = "simulation.seed"  # the one whole number that may differ between runs; doubles hold it exactly

Columns = dict[str, NDArray[np.float64]]


def checked_columns(loop: Loop, parameters: Mapping[str, ArrayLike], first: int = 0) -> Columns:
    """The parameters as vectors of one length, each number in the range of its field.

    The numbers of each run go together, too.
    """
    given = checked_mapping("parameters", parameters, "paths to arrays of numbers")
    columns = {path: parameter_column(loop, path, values) for path, values in given.items()}
    sizes = {path: values.size for path, values in columns.items()}
    if not sizes:
        raise ParameterError("parameters", "{}", "must name at least one parameter")
    if len(set(sizes.values())) > 1:
        raise ParameterError("parameters", sizes, "must be arrays of one length")
    check_runs(loop, columns, first)
    return columns


def check_runs(block: Block, columns: Columns, first: int, path: str = "") -> None:
    """Ask the blocks that have a method ``check``, and of which something varies, about each run."""
    own = {name.removeprefix(path): values for name, values in columns.items() if name.startswith(path)}
    if not own:
        return
    for name, value in zip(block._fields, block, strict=True):
        if is_block(value):
            check_runs(value, columns, first, f"{path}{name}.")
    differing = {name.partition(".")[0] for name in own}
    if hasattr(block, "check") and not differing.isdisjoint(fields_checked(block)):
        for run, one in enumerate(blocks_of_runs(block, own), first):
            try:
                check_own(one, path.rstrip("."))
            except ParameterError as error:
                raise error_in_run(run, error) from None


class FieldSpy:
    """A block that keeps the names of the fields that are asked for, and raises where more is asked of it.

    With it a check is asked once for 100,000 runs that differ elsewhere, in 0.3 ms; asked of each, 30 ms.
    """

    def __init__(self, block: Block) -> None:
        self.block, self.names = block, set[str]()

    @property  # type: ignore[misc]
    def __class__(self) -> Any:  # for isinstance
        return type(self.block)

    def __getattr__(self, name: str) -> Any:
        if name in self.block._fields:
            self.names.add(name)
            return getattr(self.block, name)
        if isinstance(method := getattr_static(self.block, name), FunctionType):
            return MethodType(method, self)
        raise TypeError(name)


def fields_checked(block: Any) -> Iterable[str]:
    """The fields that a block's check looks at; all of them where it does not only look at fields.

    No other field can change what it finds, so that runs which differ in others alone are checked as one.
    """
    noticing = FieldSpy(block)
    try:
        type(block).check(noticing)
    except Exception:  # a fault, of which the runs are asked one by one, or more than looks at fields
        return tuple(block._fields)
    return noticing.names


def error_in_run(run: int, error: ParameterError) -> ParameterError:
    """An error about one of many runs."""
    return ParameterError(error.path, error.value, f"{error.allowed}, in run {run}")


def blocks_of_runs(block: Block, columns: Columns) -> Iterator[Any]:
    """The block of each run, as quickly as Python makes tuples."""
    members = []
    for name, value in zip(block._fields, block, strict=True):
        start = f"{name}."
        own = {path.removeprefix(start): row for path, row in columns.items() if path.startswith(start)}
        if own:
            members.append(blocks_of_runs(value, own))
        else:
            members.append(iter(columns[name].tolist()) if name in columns else repeat(value))
    return map(type(block)._make, zip(*members, strict=False))


def parameter_column(loop: Loop, path: str, values: ArrayLike) -> NDArray[np.float64]:
    try:
        present = value_at(loop, path)
    except ParameterError as error:
        raise ParameterError("parameters", path, error.allowed) from None
    if path != SEED and (
        not isinstance(present, float) or path.startswith(("simulation.", "hold.", "metrics."))
    ):
        wanted = "must be a float outside simulation, hold and metrics, or the seed"
        raise ParameterError("parameters", path, wanted)
    found = number_per_run(path, values)
    field = field_at(loop, path)
    if field.derived:
        raise ParameterError("parameters", path, "is computed before a run; vary what it is computed from")
    if not np.isfinite(found).all():
        wrong = float(found[~np.isfinite(found)][0])
        raise ParameterError(path, wrong, f"must be {allowed(replaced(field, auto=None))}")
    for value in (found.min(), found.max()):
        checked_number(float(value), path, field, float)
    if path == SEED and (found % 1.0).any():
        wrong = float(found[found % 1.0 != 0.0][0])
        raise ParameterError(path, wrong, f"must be {allowed(field, whole=True)}")
    return found


def number_per_run(path: str, values: ArrayLike) -> NDArray[np.float64]:
    if is_block(values):
        raise ParameterError(path, values, "must be an array of numbers")
    try:
        found = np.atleast_1d(np.asarray(values, dtype=np.float64))
    except (OverflowError, TypeError, ValueError):
        raise ParameterError(path, values, "must be an array of numbers") from None
    if found.ndim != 1 or not found.size:
        raise ParameterError(path, f"shape {found.shape}", "must be an array of shape (runs,)")
    return found


def designed_columns(loop: Loop, columns: Columns) -> Columns:
    """What the controllers of runs compute before they start, where it differs between them."""
    computed = [path for path, _ in leaves(loop.controller) if field_at(loop.controller, path).derived]
    ruling = [path for path in columns if path.startswith("controller.")]
    if not computed or not ruling:
        return {}

    @cache
    def design(*numbers: float) -> list[float]:
        own = replace(loop, dict(zip(ruling, numbers, strict=True)))
        controller = designed(own.controller, own.simulation.period, partial(believed, own))
        return [value_at(controller, path) for path in computed]

    rows = zip(*(columns[path].tolist() for path in ruling), strict=True)
    table = np.array([design(*numbers) for numbers in rows], dtype=np.float64).T
    return {f"controller.{path}": row for path, row in zip(computed, table, strict=True)}


def start_columns(loop: Loop, columns: Columns, first: int = 0) -> Columns:
    """Where the plants and drives of runs start, where that is open and something of the machine differs."""
    if hasattr(loop.start, "found"):
        return found_start_columns(loop, columns, first)
    start = StartingMachine(loop.plant, loop.supply, loop.load, loop.drive)
    machine = {
        path: row for path, row in columns.items() if path.partition(".")[0] in StartingMachine._fields
    }
    open_ones = [
        path
        for path, value in leaves(start)
        if isinstance(value, float) and value == field_at(loop, path).auto and path not in columns
    ]
    if not machine or not open_ones:
        return {}
    table = []
    for run, own in enumerate(blocks_of_runs(start, machine), first):
        try:
            found = resting(own)
        except ParameterError as error:
            raise error_in_run(run, error) from None
        table.append([value_at(found, path) for path in open_ones])
    return dict(zip(open_ones, np.array(table).T, strict=True))


def found_start_columns(loop: Loop, columns: Columns, first: int) -> Columns:
    """The states in which runs begin, where a start finds them and something of the machine differs."""
    if not any(path.partition(".")[0] in (*MachineState._fields, "load", "start") for path in columns):
        return {}
    loops: list[Loop] = []
    wrong: list[Block | ParameterError] = []
    for own in blocks_of_runs(loop, columns):
        try:
            loops.append(resting(own))
        except ParameterError as error:
            wrong = [error]
            break
    given = {path for path, _ in leaves(loop.start.given)}
    table: list[dict[str, float]] = []
    for run, found in enumerate([*starts_found(loops), *wrong], first):
        if isinstance(found, ParameterError):
            raise error_in_run(run, found) from None
        table.append({path: value for path, value in leaves(found) if path not in given})
        if table[-1].keys() != table[0].keys():
            problem = "must find the same numbers of the state in each run"
            raise error_in_run(run, ParameterError("start", type(loop.start).__name__, problem))
    return {f"start.given.{path}": np.array([row[path] for row in table]) for path in table[0]}


class StartingMachine(NamedTuple):
    """What the start of a plant and its drive depends on."""

    plant: Block
    supply: Block
    load: Block
    drive: Block


def hardest_loop(loop: Loop, parts: Iterable[Mapping[str, NDArray[np.float64]]]) -> Loop:
    """The loop whose machine moves fastest at its start, among those with the extremes of each parameter."""
    found: Loop = max((replace(loop, row) for row in extremes(loop, parts)), key=fastest_rate)
    return found


def extremes(loop: Loop, parts: Iterable[Mapping[str, NDArray[np.float64]]]) -> list[dict[str, Any]]:
    """Which runs have the least or the largest of a number, the first run that does, in order."""
    ends: dict[tuple[str, bool], tuple[float, int]] = {}  # by path and which end: its value, and its run
    rows: dict[int, dict[str, Any]] = {}
    first = 0
    for columns in parts:
        size = next(iter(columns.values())).size
        for path in dict.fromkeys([*columns, *(path for path, _ in ends)]):
            own = float(value_at(loop, path))
            values = columns[path] if path in columns else np.array([own])
            for largest, i in ((False, int(values.argmin())), (True, int(values.argmax()))):
                value, before = float(values[i]), ends.get((path, largest), (own, 0) if first else None)
                if before is None or (value > before[0] if largest else value < before[0]):
                    before = value, first + i
                ends[path, largest] = before
        runs = {run for _, run in ends.values()} | {0}
        for run in runs - rows.keys():
            rows[run] = {p: type(value_at(loop, p))(values[run - first]) for p, values in columns.items()}
        rows = {run: rows[run] for run in sorted(runs)}
        first += size
    asked = {run for _, run in ends.values()}
    return [row for run, row in rows.items() if run in asked]
