"""What every block must hold to; a block is tested as soon as its package exports it."""

import inspect
from typing import Annotated, NamedTuple

import pytest

from hydroservo import references
from hydroservo.core.block import Field, declared_fields, is_block
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand
from hydroservo.scenario import registry
from hydroservo.scenario.role_checks import declared_roles
from hydroservo.testing import BlockContract
from tests.support.roles import blocks, identifier


class TestContract(BlockContract):
    @pytest.fixture(autouse=True, params=blocks(), ids=identifier)
    def of_block(self, request: pytest.FixtureRequest) -> None:
        self.block = request.param

    def test_declares_the_source_of_every_default(self) -> None:
        for name, value in self.block._field_defaults.items():
            if not is_block(value) and not isinstance(value, bool):
                assert declared_fields(self.block)[name].source

    def test_says_where_it_comes_from_and_where_it_fails(self) -> None:
        text = self.block.__doc__ or ""
        assert "Source:" in text
        assert "Fails" in text

    test_gives_the_same_bits_compiled = pytest.mark.slow(BlockContract.test_gives_the_same_bits_compiled)
    test_gives_the_same_bits_in_c = pytest.mark.slow(BlockContract.test_gives_the_same_bits_in_c)


@role(Reference)
class Late(NamedTuple):
    """A reference that nobody listed.

    Source: this test. Fails nowhere.
    """

    value: Annotated[float, Field("m/s", "value", "this test")] = 0.1

    def at(self, t: float) -> Demand:
        return Demand(self.value, 0.0, 0.0)


def test_a_new_block_is_found_without_being_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(references, "Late", Late, raising=False)
    monkeypatch.setattr(references, "__all__", [*references.__all__, "Late"])
    registry.shipped_classes.cache_clear()
    try:
        assert Late in blocks()
    finally:
        registry.shipped_classes.cache_clear()


def test_each_class_with_methods_says_its_role() -> None:
    for cls in registry.shipped_classes():
        own = [name for name, value in vars(cls).items() if inspect.isfunction(value) and name[0] != "_"]
        assert bool(declared_roles(cls)) == bool(own), cls
