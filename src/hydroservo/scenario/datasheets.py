"""Many runs with other numbers of a datasheet: what constructors make of them, for each run."""

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo.core.block import Block, field_at, is_block, leaves
from hydroservo.core.errors import ParameterError, ScenarioError, nearest
from hydroservo.core.validation import checked_number
from hydroservo.runs.columns import Columns, number_per_run
from hydroservo.scenario.build import Draft
from hydroservo.scenario.load import Assembly, MachineBlocks, assemble


def datasheet_columns(
    source: str | Path,
    values: Mapping[str, ArrayLike],
    changes: Mapping[str, object] | None = None,
    plugins: Sequence[str | Path] = (),
) -> Columns:
    """What :func:`~hydroservo.simulate_batch` takes for runs with other arguments of datasheet constructors.

    Where a scenario's ``type`` names a constructor, such as ``Cylinder.from_diameters``, the loop has none of
    its arguments, only what the constructor made of them. This asks it anew for each run::

        columns = datasheet_columns("my.toml", {"plant.bore": 63e-3 + 1e-4 * rng.uniform(-1, 1, 1000)})
        table = simulate_batch(load_scenario("my.toml"), columns)

    In the machine (plant, valve, supply, load) only the truth varies: the controller, and the areas that
    sensors know, go on believing in the scenario's values. What ``[uncertainty]`` and ``[truth]`` say of
    other numbers counts, a deviation in proportion to what the constructor makes.

    Args:
        source: the path of a TOML file, or the name of a built-in scenario.
        values: arrays of shape (runs,) in SI units by the path of an argument, such as ``plant.bore``.
        changes: as of :func:`load_scenario`.
        plugins: as there.

    Returns:
        Arrays of shape (runs,) in SI units by path in the loop, of the numbers that are not the loop's own in
        all runs.

    Raises:
        ScenarioError: the path of no such argument, or a run's arguments that do not go together.
        ParameterError: a value out of its range, or arrays of different lengths.
    """
    return made_columns(assemble(source, changes, plugins), values)


def made_columns(
    assembly: Assembly, values: Mapping[str, ArrayLike], first: int = 0, always: Collection[str] = ()
) -> Columns:
    """As :func:`datasheet_columns`, of a scenario that is loaded already, for the runs from a number on.

    Those of the paths ``always`` are there even if they are the loop's own in all runs.
    """
    given = {path: checked_values(assembly, path, one, first) for path, one in values.items()}
    sizes = {path: one.size for path, one in given.items()}
    if len(set(sizes.values())) > 1:
        raise ParameterError("values", sizes, "must be arrays of one length")
    found: Columns = {}
    for name in assembly.drafts:
        start = f"{name}."
        own = {path.removeprefix(start): one for path, one in given.items() if path.startswith(start)}
        if own:
            found |= block_columns(assembly, name, own, first, always)
    return found


def checked_values(assembly: Assembly, path: str, values: ArrayLike, first: int) -> NDArray[np.float64]:
    """One value of an argument for each run."""
    if path not in assembly.arguments:
        problem = f"is not a number that a constructor takes{nearest(path, assembly.arguments)}"
        raise ScenarioError("values", path, problem)
    found = number_per_run(path, values)
    for run, value in enumerate(found.tolist(), first):
        try:
            checked_number(value, path, assembly.arguments[path].field, float)
        except ParameterError as error:
            raise ParameterError(path, value, f"{error.allowed}, in run {run}") from None
    return found


def block_columns(
    assembly: Assembly, name: str, values: Columns, first: int, always: Collection[str]
) -> Columns:
    """The numbers of one block of the loop that differ between runs, by path in the loop."""
    draft = assembly.drafts[name]
    if name in MachineBlocks._fields:
        draft = draft.replaced(assembly.truth.taken(name, assembly.arguments))
    draft = draft.open_at(values)
    usual = true_block(assembly, name, draft)
    found = {
        path: np.empty(next(iter(values.values())).size)
        for path, value in leaves(usual)
        if isinstance(value, float) and not field_at(usual, path).derived
    }
    for run, numbers in enumerate(zip(*(one.tolist() for one in values.values()), strict=True)):
        try:
            block = true_block(assembly, name, draft.replaced(dict(zip(values, numbers, strict=True))))
        except ScenarioError as error:
            problem = f"{error.problem}, in run {first + run}"
            raise ScenarioError(error.file, error.key, problem) from None
        if not differ_only_in_floats(block, usual):
            where = f"in run {first + run}"
            problem = (
                f"is a different block from the scenario's, not the same one with other numbers, {where}"
            )
            raise ScenarioError("values", name, problem)
        for path, value in leaves(block):
            if path in found:
                found[path][run] = value
    own = dict(leaves(usual))
    return {
        f"{name}.{path}": row
        for path, row in found.items()
        if f"{name}.{path}" in always or (row != own[path]).any()
    }


def true_block(assembly: Assembly, name: str, draft: Draft) -> Block:
    """A block of the loop, as it truly is if it is of the machine."""
    block = draft.made()
    return assembly.truth.true(block, name) if name in MachineBlocks._fields else block


def differ_only_in_floats(one: Any, other: Any) -> bool:
    """Whether two blocks differ in nothing but floats."""
    if type(one) is not type(other):
        return False
    if is_block(one):
        return all(map(differ_only_in_floats, one, other))
    return isinstance(one, float) or np.array_equal(one, other)
