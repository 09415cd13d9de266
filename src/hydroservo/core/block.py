"""The one abstraction: a block is a frozen NamedTuple of SI parameters with pure methods.

A block's state is another NamedTuple of floats. Sampled blocks (controllers, observers, filters)
write ``step``; continuous devices write ``deriv``, which integrators turn into a step. The same
function text is interpreted, compiled and (for export) traced, so methods call only each other,
the functions of :mod:`hydroservo.core.ops`, and their own nested blocks.

Every parameter and state field is declared once, as ``Annotated[float, Field(unit, meaning, ...)]``;
scenario files, validation, result attributes and reference pages all read that declaration.

The role that a block plays is one of :mod:`hydroservo.core.roles`; what it may have besides is in
:mod:`hydroservo.core.hooks`.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from hydroservo.core.errors import ParameterError, nearest
from hydroservo.core.field import Field as Field
from hydroservo.core.field import declared_fields as declared_fields
from hydroservo.core.roles import Block as Block


def estimates_in(state: Block) -> Block:
    """The first state in that of a law which holds an observer's estimates d1 and d2; None if none does."""
    if {"d1", "d2"} <= set(state._fields):
        return None if hasattr(type(state), "without_estimates") else state
    inner = (estimates_in(value) for value in state if is_block(value))
    return next((one for one in inner if one is not None), None)


def model_in(controller: Block) -> Block:
    """The model that a law believes in, that of the outermost law in wrappers; None if none has one."""
    if hasattr(controller, "model"):
        return controller.model
    return model_in(controller.controller) if hasattr(controller, "controller") else None


def is_block(value: object) -> bool:
    """True for a NamedTuple instance (a block or a state)."""
    return isinstance(value, tuple) and hasattr(value, "_fields")


def leaves(block: Block, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Each number of a block or state with its dotted path, depth first in declared order."""
    for name in block._fields:
        value = getattr(block, name)
        if is_block(value):
            yield from leaves(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def nested_blocks(block: Block, path: str = "") -> Iterator[tuple[str, Block]]:
    """A block and those nested in it, the outer ones first, with their paths."""
    yield path, block
    for name, value in zip(block._fields, block, strict=True):
        if is_block(value):
            yield from nested_blocks(value, f"{path}.{name}" if path else name)


def is_under(path: str, place: str) -> bool:
    """Whether a dotted path is a place, or leads below it."""
    return path == place or path.startswith(f"{place}.")


def values(block: Block) -> list[Any]:
    """Each number of a block or state, in the order of :func:`leaves`, at a third of its cost."""
    found: list[Any] = []
    for value in block:
        if is_block(value):
            found += values(value)
        else:
            found.append(value)
    return found


def value_at(block: Block, path: str) -> Any:
    """The value at a dotted path, such as ``controller.observer.d1``.

    Raises:
        ParameterError: no such path; the message lists the names that exist there, and the nearest path.
    """
    if not isinstance(path, str):
        raise ParameterError("path", path, "must be a string such as 'plant.mass'")
    value = block
    for name in path.split("."):
        if not is_block(value) or name not in value._fields:
            names = ", ".join(value._fields) if is_block(value) else "none: it is a number"
            names = names or f"none: a {type(value).__name__} has no numbers"
            near = nearest(path, paths(block))
            raise ParameterError("path", path, f"no {name!r} there; the names are {names}{near}")
        value = getattr(value, name)
    return value


def paths(block: Block, prefix: str = "") -> Iterator[str]:
    """The dotted path of each number and of each block in a block."""
    for name, value in block._asdict().items():
        yield prefix + name
        if is_block(value):
            yield from paths(value, f"{prefix}{name}.")


def field_at(block: Block, path: str, outer: Field | None = None) -> Field:
    """The declaration of the number at a dotted path; its name alone where it has none.

    In a loop, and in a block that says what it controls, its unit is that of the controlled signal where it
    depends on that.

    Args:
        block: the block.
        path: of a number in it.
        outer: the controlled signal of what the block is in; None if nothing says so.
    """
    value_at(block, path)
    *parents, name = path.split(".")
    holder, around, signal = block, block, signal_of(block, outer)
    for i, parent in enumerate(parents):
        if parents[i - 1 : i + 1] == ["start", "given"]:  # a state by its path in the loop's
            inner = ".".join([*parents[i + 1 :], name])
            return state_field_at(around, around.init(), inner, signal)
        signal = nested_signal(holder, parent, signal)
        holder, around = getattr(holder, parent), holder
    return in_signal(declared_fields(holder.__class__).get(name, Field("", name)), signal)


def state_field_at(block: Block, state: Block, path: str, outer: Field | None = None) -> Field:
    """The declaration of the number at a dotted path of a block's state, as :func:`field_at`'s of a block.

    Args:
        block: the block, such as a loop.
        state: its state.
        path: of a number in the state.
        outer: the controlled signal of what the block is in; None if nothing says so.
    """
    value_at(state, path)
    *parents, name = path.split(".")
    signal = signal_of(block, outer)
    for parent in parents:
        block, signal = nested_state(block, state, parent, signal)
        state = getattr(state, parent)
    return in_signal(declared_fields(state.__class__).get(name, Field("", name)), signal)


def nested_signal(block: Block, name: str, own: Field | None) -> Field | None:
    """What the numbers of a block in another are of."""
    return signal_of(getattr(block, name), signal_below(block, name, own))


def nested_state(
    block: Block, state: Block, name: str, own: Field | None
) -> tuple[Block | None, Field | None]:
    """The block whose state another's holds under a name, None if it is that of no block; and what it is of.

    The block has that name in the other; but a copy of a nested law's state, which has that law's type and
    any name, is a state of that law.

    Args:
        block: the outer block, or None.
        state: its state.
        name: of the inner state, as a field of the outer one.
        own: what the numbers of the outer block are of.
    """
    if not is_block(block):
        return None, own
    nested = getattr(state, "controller", None)
    copied = hasattr(block, "controller") and type(getattr(state, name)) is type(nested)
    name = "controller" if copied else name
    if name not in block._fields:
        return None, own
    return getattr(block, name), nested_signal(block, name, own)


def signal_of(block: Block, outer: Field | None) -> Field | None:
    """What a block's numbers are of, in units that depend on the controlled signal.

    Args:
        block: the block; one whose field ``controls`` is filled in says it itself.
        outer: what those of the block around it are of; None if nothing says so.
    """
    own: Any = getattr(block, "controls", None)
    if own is None:
        return outer
    declared: Field = own.declared()
    return in_signal(declared, outer)


def signal_below(block: Block, name: str, own: Field | None) -> Field | None:
    """What a block in another is given for a signal: the one rule, for parameters, states and exports.

    Args:
        block: the outer block.
        name: of the inner one, as a field of it.
        own: the signal of the outer one.
    """
    inner = inner_controls(block, name)
    return own if inner is None else in_signal(inner.declared(), own)


def inner_controls(block: Block, name: str) -> Any:
    """The signal that a law has the one inside control, if another than its own; else None."""
    return getattr(block, "inner_controls", None) if name == "controller" else None


def in_signal(field: Field, signal: Field | None) -> Field:
    """A declaration with the unit of the controlled signal; as it is where nothing says which that is."""
    return field if signal is None else field.of(signal)


def replace(block: Block, changes: Mapping[str, Any]) -> Block:
    """A copy of a block with the values at dotted paths exchanged.

    Args:
        block: such as a loop.
        changes: numbers and blocks by path, such as ``{"plant.mass": 7.0}``.

    Raises:
        ParameterError: a path does not exist; the message has the nearest that does.
    """
    if not is_block(block):
        raise ParameterError("block", block, "must be a block, such as the Loop that load_scenario returns")
    if not isinstance(changes, Mapping):
        raise ParameterError("changes", changes, "must map paths to values, such as {'plant.mass': 7.0}")
    for path, value in changes.items():
        value_at(block, path)
        head, _, rest = path.partition(".")
        inner = replace(getattr(block, head), {rest: value}) if rest else value
        block = block._replace(**{head: inner})
    return block
