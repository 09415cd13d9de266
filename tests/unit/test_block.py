"""Walking, reading and exchanging the numbers of nested blocks, and their declarations."""

from typing import Annotated, NamedTuple

import pytest

from hydroservo import ParameterError
from hydroservo.core.block import Block, Field, declared_fields, is_block, leaves, replace, value_at


class Inner(NamedTuple):
    gain: Annotated[float, Field("V/m", "gain", "this test", above=0)] = 2.0
    flag: bool = False


class Outer(NamedTuple):
    mass: Annotated[float, Field("kg", "mass", "this test")] = 1.0
    inner: Block = Inner()
    last: float = 3.0


def test_leaves_are_in_declared_order_depth_first() -> None:
    assert list(leaves(Outer())) == [
        ("mass", 1.0),
        ("inner.gain", 2.0),
        ("inner.flag", False),
        ("last", 3.0),
    ]


def test_a_block_is_a_named_tuple_and_nothing_else() -> None:
    assert is_block(Inner())
    assert not is_block((1.0, 2.0))
    assert not is_block(1.0)
    assert not is_block(Inner)


@pytest.mark.parametrize(("path", "value"), [("mass", 1.0), ("inner", Inner()), ("inner.gain", 2.0)])
def test_value_at_a_path(path: str, value: object) -> None:
    assert value_at(Outer(), path) == value


@pytest.mark.parametrize(
    ("path", "says"),
    [
        ("mas", "no 'mas' there; the names are mass, inner, last; did you mean mass?"),
        ("inner.gian", "no 'gian' there; the names are gain, flag; did you mean inner.gain?"),
        ("mass.unit", "no 'unit' there; the names are none: it is a number; did you mean mass?"),
    ],
)
def test_an_unknown_path_lists_the_names_there(path: str, says: str) -> None:
    with pytest.raises(ParameterError) as error:
        value_at(Outer(), path)
    assert str(error.value) == f"path = {path!r}: {says}"
    with pytest.raises(ParameterError, match="there; the names are"):
        replace(Outer(), {path: 1.0})


def test_replace_makes_a_copy() -> None:
    block = Outer()
    changed = replace(block, {"inner.gain": 5.0, "mass": 7.0})
    assert changed == Outer(7.0, Inner(5.0))
    assert block == Outer()


def test_replace_exchanges_a_whole_block() -> None:
    assert replace(Outer(), {"inner": Inner(9.0)}).inner.gain == 9.0


def test_replace_takes_changes_in_order() -> None:
    assert replace(Outer(), {"inner": Inner(9.0, True), "inner.gain": 4.0}).inner == Inner(4.0, True)


def test_declared_fields_are_the_annotated_ones() -> None:
    assert dict(declared_fields(Outer)) == {"mass": Field("kg", "mass", "this test")}
    assert declared_fields(Inner)["gain"].above == 0


def test_a_declaration_shows_what_is_said_in_it_alone() -> None:
    assert repr(Field("V s/m", "gain", above=0)) == "Field('V s/m', 'gain', above=0)"
    every = Field("m", "stroke", "datasheet", at_least=0, auto=-1.0, derived=True)
    assert repr(every) == "Field('m', 'stroke', source='datasheet', at_least=0, derived=True, auto=-1.0)"
    assert eval(repr(every)) == every  # noqa: S307 - what was shown here
