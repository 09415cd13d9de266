"""What a block must say of itself, and have."""

import pickle
from collections.abc import Iterator
from typing import Any, get_type_hints

from hydroservo.core.block import Block, is_block, leaves, value_at
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import declared_fields
from hydroservo.core.roles import Controller, Monitor
from hydroservo.core.validation import TEXT, checked
from hydroservo.runs.fitting import STATES
from hydroservo.scenario.role_checks import ROLES, a_role, check_declared_roles, class_line, role_problem
from hydroservo.scenario.units import check_si
from hydroservo.testing.case import Case, ContractError, bits


def check_fits_role(case: Case) -> None:
    """It has the methods of its role, what others read of it and of its state, and blocks in it that fit."""
    problem = role_problem(case.cls, case.role)
    if problem is not None:
        raise case.error(f"cannot be {a_role(case.role)}: {problem}")
    try:
        check_declared_roles(case.cls)
    except ValueError as error:
        raise case.error(str(error)) from None
    check_fields(case)
    check_state(case)
    check_metric_values(case)
    check_parts(case)


def check_fields(case: Case) -> None:
    """What others read of it are fields: compiled code knows no property."""
    for name, member in vars(case.role).items():
        if not isinstance(member, property) or name in case.block._fields:
            continue
        kind = get_type_hints(member.fget)["return"]
        way = f"{name}: {'Annotated[float, Field(unit, meaning, ...)]' if kind is float else kind.__name__}"
        if hasattr(case.block, name):
            what = "property" if isinstance(vars(case.cls).get(name), property) else "class attribute"
            raise case.error(
                f"{name} is a {what}, which compiled code cannot read; write a field, {way}", name
            )
        raise case.error(f"has no {name}, which {a_role(case.role)} must have; write a field, {way}")


def check_state(case: Case) -> None:
    if not case.has_state:
        return
    state = case.block.init()
    if not is_block(state):
        raise case.error(f"init returns {state!r}: must be a NamedTuple", "init")
    for name in STATES.get(case.role, ()):
        if name not in state._fields:
            wanted = f"which that of {a_role(case.role)} must have"
            raise case.error(f"its state has no {name}, {wanted}", "init")


def check_metric_values(case: Case) -> None:
    if case.role is not Monitor:
        return
    values = case.block.values(case.block.init())
    if not is_block(values):
        raise case.error(f"values returns {values!r}: must be a NamedTuple", "values")
    for name, value in values._asdict().items():
        if type(value) not in (float, bool):
            raise case.error(f"{name} of values is {value!r}: must be a float or a flag", "values")


def check_parts(case: Case) -> None:
    hints = get_type_hints(case.cls)
    for name, part in case.block._asdict().items():
        problem = role_problem(type(part), hints[name]) if hints.get(name) in ROLES else None
        if problem is not None:
            raise case.error(f"{name} cannot be {a_role(hints[name])}: {problem}", name)


def check_documented(case: Case) -> None:
    """It has a docstring."""
    text = vars(case.cls).get("__doc__") or ""
    if not text.strip() or text.startswith(f"{case.cls.__name__}("):  # what NamedTuple writes
        raise case.error("has no docstring: what it is, its equation, where that is from and where it fails")


def check_declared(case: Case) -> None:
    """Each number of it and of its state is declared, with an SI unit, and what it means.

    Of a monitor, whose state may be its own affair, each of its metrics.
    """
    others = metric_numbers(case) if case.role is Monitor else state_numbers(case)
    for owner, name in [*block_parameters(case.block), *others]:
        cls: Any = type(owner)
        field, line = declared_fields(cls).get(name), class_line(cls, name)
        if isinstance(getattr(owner, name), str) and get_type_hints(cls).get(name) is str:
            raise ContractError(str(ParameterError(name, getattr(owner, name), TEXT)), line)
        if field is None:
            way = f"{name}: Annotated[float, Field(unit, meaning, ...)]"
            raise ContractError(f"{name} has no unit; write {way}", line)
        try:
            check_si(field.unit)
        except ValueError as error:
            raise ContractError(f"the unit {field.unit!r} of {name} {error}", line) from None
        if not field.meaning:
            raise ContractError(f"{name} has no meaning: Field({field.unit!r}, meaning, ...)", line)


def block_parameters(block: Block) -> Iterator[tuple[Block, str]]:
    """The numbers of a block itself, but for flags."""
    for name, value in block._asdict().items():
        if not is_block(value) and not isinstance(value, bool):
            yield block, name


def metric_numbers(case: Case) -> Iterator[tuple[Block, str]]:
    values = case.block.values(case.block.init())
    for name in values._fields:
        yield values, name


def state_numbers(case: Case) -> Iterator[tuple[Block, str]]:
    if not case.has_state:
        return
    state = case.block.init()
    for path, _ in leaves(state):
        parent, _, name = path.rpartition(".")
        yield (value_at(state, parent) if parent else state), name


def check_own_ranges(case: Case) -> None:
    """Its numbers are in the ranges that it declares, and go together."""
    try:
        checked(case.block)
    except ParameterError as error:
        if error.__cause__ is not None:  # what stopped its own method check, with its line
            raise error.__cause__ from None
        raise case.error(str(error), error.path.partition(".")[0]) from None


def check_floats(case: Case) -> None:
    """The numbers of its first state are floats, and a controller's first command is 0 V."""
    if not case.has_state:
        return
    state: Any = case.block.init()
    for path, value in leaves(state):
        if type(value) is not float:
            raise case.error(f"{path} of init is {value!r}: must be a float", "init")
    if case.role is Controller and state.u != 0.0:
        raise case.error(f"its first command, u of init, is {state.u:g} V: must be 0 V", "init")


def check_pickles(case: Case) -> None:
    """It can be pickled, to be run in other processes."""
    again = pickle.loads(pickle.dumps(case.block))  # noqa: S301 - what was pickled here
    if bits(again) != bits(case.block):
        raise case.error(f"comes back from a pickle as {again!r}")
