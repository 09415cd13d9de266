"""What every block must hold to; a block is tested as soon as its package exports it."""

import inspect
from collections.abc import Iterable, Iterator
from typing import Annotated, NamedTuple

import pytest

from hydroservo import references
from hydroservo.core.block import Field, declared_fields
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand
from hydroservo.scenario import registry
from hydroservo.scenario.role_checks import declared_roles
from hydroservo.testing import ContractError
from hydroservo.testing.case import Case, case_of
from hydroservo.testing.contract import QUESTIONS, TRANSLATED, Question, ask
from tests.support.roles import blocks, identifier
from tests.support.tiers import mostly

STATIC = [question for question in QUESTIONS if not question.behaviour]
COMPILED, IN_C = (one for one in QUESTIONS if one.name in TRANSLATED)
BEHAVIOUR = [one for one in QUESTIONS if one.behaviour and one.name not in TRANSLATED]


class TestContract:
    """What :class:`hydroservo.testing.BlockContract` asks, in fewer tests, for there are many blocks."""

    @pytest.fixture(params=blocks(), ids=identifier)
    def case(self, request: pytest.FixtureRequest) -> Case:
        return case_of(request.param)

    def test_is_declared_and_documented(self, case: Case) -> None:
        assert [*faults(case, STATIC), *missing_sources(case.cls), *missing_parts(case.cls)] == []

    def test_behaves(self, case: Case) -> None:
        assert list(faults(case, BEHAVIOUR)) == []

    @pytest.mark.slow
    def test_gives_the_same_bits_compiled(self, case: Case) -> None:
        assert list(faults(case, [COMPILED])) == []

    @pytest.mark.slow
    @pytest.mark.parametrize("block", mostly(pytest.mark.nightly, blocks(), blocks()[::12]), ids=identifier)
    def test_gives_the_same_bits_in_c(self, block: type) -> None:
        assert list(faults(case_of(block), [IN_C])) == []


def faults(case: Case, questions: Iterable[Question]) -> Iterator[str]:
    """What the contract finds wrong with a block, question by question."""
    for question in questions:
        try:
            ask(question, case)
        except ContractError as error:
            yield f"{question.name}? {error}"
            if question is QUESTIONS[0]:  # what it is, nobody knows
                return


def missing_sources(cls: type) -> Iterator[str]:
    """The defaults that do not say where they come from."""
    for name, field in declared_fields(cls).items():
        if not field.source and not isinstance(cls._field_defaults.get(name, True), bool):
            yield f"{name} has a default without a source"


def missing_parts(cls: type) -> Iterator[str]:
    """The parts that the docstring lacks."""
    return (f"no {part} in the docstring" for part in ("Source:", "Fails") if part not in (cls.__doc__ or ""))


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
