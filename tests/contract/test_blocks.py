"""What every block must hold to; a block is tested as soon as its package exports it."""

import math
import pickle
from collections.abc import Callable
from functools import cache
from typing import Annotated, Any, NamedTuple

import pint
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bits import bits, numbers
from compiling import compiled
from hydroservo import references
from hydroservo.block import Block, Field, declared_fields, is_block, leaves, value_at
from hydroservo.roles import Reference, role
from hydroservo.signals import Demand
from roles import NOTHING, blocks, identifier, methods, role_of
from strategies import ORDINARY, WIDE, argument, block_of, state

STEPS = 4
UNITS = pint.UnitRegistry()

every_block = pytest.mark.parametrize("cls", blocks(), ids=identifier)


@cache
def compiled_method(cls: type, name: str) -> Callable[..., Any]:
    return compiled(vars(cls)[name])


def interpreted_method(cls: type, name: str) -> Callable[..., Any]:
    method: Callable[..., Any] = vars(cls)[name]
    return method


def arguments(draw: Callable[..., Any], block: Block, name: str, ordinary: bool) -> list[Any]:
    """Random arguments of a method, its state included."""
    role = role_of(type(block))
    stateful = "init" in methods(role)
    return [
        draw(
            state(block.init(), ordinary) if stateful and wanted == "s" else argument(role, wanted, ordinary)
        )
        for wanted in methods(role)[name]
    ]


def run(method: Callable[..., Any], block: Block, name: str, inputs: list[list[Any]]) -> list[Any]:
    """Results for successive inputs; a step goes on from its own last state."""
    results: list[Any] = []
    for row in inputs:
        earlier = [results[-1]] if name == "step" and results else row[:1]
        results.append(method(block, *earlier, *row[1:]))
    return results


def drawn_run(
    draw: Callable[..., Any], cls: type, name: str, ordinary: bool
) -> tuple[Block, list[list[Any]]]:
    block = draw(block_of(cls, ORDINARY if ordinary else WIDE))
    inputs = [arguments(draw, block, name, ordinary) for _ in range(STEPS)]
    if name == "step":
        inputs[0][0] = block.init()
    return block, inputs


@every_block
class TestContract:
    @settings(max_examples=15)
    @given(data=st.data())
    def test_compiled_equals_interpreted(self, cls: type, data: st.DataObject) -> None:
        for name in methods(role_of(cls)):
            block, inputs = drawn_run(data.draw, cls, name, ordinary=False)
            interpreted = run(interpreted_method(cls, name), block, name, inputs)
            assert bits_of(run(compiled_method(cls, name), block, name, inputs)) == bits_of(interpreted)

    @settings(max_examples=6)
    @given(data=st.data())
    def test_same_inputs_give_the_same_bits_and_leave_them_alone(
        self, cls: type, data: st.DataObject
    ) -> None:
        for name in methods(role_of(cls)):
            block, inputs = drawn_run(data.draw, cls, name, ordinary=False)
            before = bits(block), [bits_of(row) for row in inputs]
            for method in (interpreted_method(cls, name), compiled_method(cls, name)):
                first = bits_of(run(method, block, name, inputs))
                assert bits_of(run(method, block, name, inputs)) == first
            assert (bits(block), [bits_of(row) for row in inputs]) == before

    @settings(max_examples=15)
    @given(data=st.data())
    def test_ordinary_inputs_give_finite_outputs(self, cls: type, data: st.DataObject) -> None:
        for name in sorted(methods(role_of(cls)).keys() - {"init", "next_jump"}):  # there may be no jump
            block, inputs = drawn_run(data.draw, cls, name, ordinary=True)
            for result in run(interpreted_method(cls, name), block, name, inputs):
                there = cls.__name__ not in NOTHING
                assert all(math.isfinite(number) == there for number in numbers(result)), result

    @settings(max_examples=6)
    @given(data=st.data())
    def test_a_step_keeps_the_type_of_its_state(self, cls: type, data: st.DataObject) -> None:
        for name in sorted(methods(role_of(cls)).keys() & {"step", "deriv"}):
            block, inputs = drawn_run(data.draw, cls, name, ordinary=True)
            for method in (interpreted_method(cls, name), compiled_method(cls, name)):
                for result in run(method, block, name, inputs):
                    assert kinds(result) == kinds(block.init())

    @given(data=st.data())
    @settings(max_examples=6)
    def test_pickles(self, cls: type, data: st.DataObject) -> None:
        block = data.draw(block_of(cls, WIDE))
        assert bits(pickle.loads(pickle.dumps(block))) == bits(block)  # noqa: S301

    def test_declares_unit_meaning_and_source_of_every_parameter(self, cls: type) -> None:
        for name, value in zip(cls._fields, cls(), strict=True):
            if not is_block(value) and not isinstance(value, bool):
                declared_number(cls, name)
                assert declared_fields(cls)[name].source

    def test_declares_unit_and_meaning_of_every_result(self, cls: type) -> None:
        block = cls()
        if hasattr(block, "init"):
            for path, value in leaves(block.init()):
                assert isinstance(value, float)
                parent, _, name = path.rpartition(".")
                declared_number(type(value_at(block.init(), parent) if parent else block.init()), name)

    def test_says_where_it_comes_from_and_where_it_fails(self, cls: type) -> None:
        text = cls.__doc__ or ""
        assert "Source:" in text
        assert "Fails" in text


def bits_of(results: list[Any]) -> list[Any]:
    return [bits(result) for result in results]


def kinds(state: Block) -> list[tuple[str, type]]:
    return [(path, type(value)) for path, value in leaves(state)]


def declared_number(cls: type, name: str) -> None:
    field = declared_fields(cls)[name]
    UNITS.parse_units(field.unit)
    assert field.meaning


@role(Reference)
class Late(NamedTuple):
    """A reference that nobody listed.

    Source: this test. Fails nowhere.
    """

    value: Annotated[float, Field("m/s", "value", "this test")] = 0.1

    def at(self, t: float) -> Demand:
        return Demand(self.value, 0.0, 0.0)


class Stranger(NamedTuple):
    """A block of no role."""

    def act(self, weather: float) -> float:
        return weather


def test_a_new_block_is_found_without_being_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(references, "Late", Late, raising=False)
    monkeypatch.setattr(references, "__all__", [*references.__all__, "Late"])
    assert Late in blocks()
    assert role_of(Late).__name__ == "Reference"


def test_a_block_that_says_no_role_is_refused() -> None:
    with pytest.raises(LookupError, match="says 0 roles"):
        role_of(Stranger)
