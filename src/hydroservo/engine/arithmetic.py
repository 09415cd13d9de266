"""Gives compiled code the arithmetic on whole states: importing this module is enough."""

from collections.abc import Callable
from typing import Any

from numba import types
from numba.extending import overload

from hydroservo import block, states
from hydroservo.engine import state_text
from hydroservo.engine.jit import INLINE
from hydroservo.engine.state_text import Shape

__all__ = [
    "compiled_axpy",
    "compiled_estimates_in",
    "compiled_factored",
    "compiled_misses",
    "compiled_model_in",
    "compiled_overlaid",
    "compiled_scaled",
    "compiled_solved",
]


@overload(states.axpy, strict=False, jit_options=INLINE)
def compiled_axpy(x: types.Type, _h: types.Type, _k: types.Type) -> Callable[..., Any]:
    """``states.axpy`` for states of one type."""
    return state_text.axpy(shape_of(x))


@overload(states.scaled, strict=False, jit_options=INLINE)
def compiled_scaled(_h: types.Type, k: types.Type) -> Callable[..., Any]:
    """``states.scaled`` for states of one type."""
    return state_text.scaled(shape_of(k))


@overload(states.misses, strict=False, jit_options=INLINE)
def compiled_misses(error: types.Type, *_: types.Type) -> Callable[..., Any]:
    """``states.misses`` for states of one type."""
    return state_text.misses(shape_of(error))


@overload(states.miss, strict=False, jit_options=INLINE)
def compiled_miss(*_: types.Type) -> Callable[..., Any]:
    return states.miss


@overload(states.nudge, strict=False, jit_options=INLINE)
def compiled_nudge(*_: types.Type) -> Callable[..., Any]:
    return states.nudge


@overload(states.factored, strict=False, jit_options=INLINE)
def compiled_factored(
    _system: types.Type, _t: types.Type, x: types.Type, *_: types.Type
) -> Callable[..., Any]:
    """``states.factored`` for states of one type."""
    return state_text.factored(shape_of(x))


@overload(states.solved, strict=False, jit_options=INLINE)
def compiled_solved(_matrix: types.Type, k: types.Type) -> Callable[..., Any]:
    """``states.solved`` for states of one type."""
    return state_text.solved(shape_of(k))


@overload(states.overlaid, strict=False, jit_options=INLINE)
def compiled_overlaid(x: types.Type, given: types.Type) -> Callable[..., Any]:
    """``states.overlaid`` for states of one type and groups of another."""
    return state_text.overlaid(shape_of(x), shape_of(given))


@overload(block.estimates_in, strict=False, jit_options=INLINE)
def compiled_estimates_in(state: types.Type) -> Callable[..., Any]:
    """``block.estimates_in`` for states of one type."""
    return state_text.estimates_in(shape_of(state))


@overload(block.model_in, strict=False, jit_options=INLINE)
def compiled_model_in(controller: types.Type) -> Callable[..., Any]:
    """``block.model_in`` for laws of one type."""
    return state_text.model_in(shape_of(controller))


def shape_of(kind: types.BaseNamedTuple) -> Shape:
    """The shape of a state's type."""
    parts = zip(kind.fields, kind.types, strict=True)
    return Shape(
        kind.instance_class,
        {name: shape_of(part) if isinstance(part, types.BaseNamedTuple) else None for name, part in parts},
    )
