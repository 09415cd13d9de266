"""The numbers that are not sought but uncertain, which a fit frees within what a scenario says of them."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from hydroservo.block import field_at, value_at
from hydroservo.errors import ScenarioError
from hydroservo.field import Field
from hydroservo.runs.space import Space
from hydroservo.scenario.load import Assembly
from hydroservo.scenario.sampling import Variation, parameters_of
from hydroservo.scenario.truth import Deviation
from hydroservo.validation import within

FAR = 2.0  # times an uncertainty, up to which a number is sought


class Uncertain(NamedTuple):
    """A number that is not sought but uncertain.

    Attributes:
        variation: between which values it is freed.
        share: the part of that range that its uncertainty is.
    """

    variation: Variation
    share: float


def uncertain_numbers(assembly: Assembly, varied: Sequence[Variation], but: Sequence[str]) -> list[Uncertain]:
    """The numbers of ``[uncertainty]`` that are not sought, each freed to twice as far where that may be.

    A number that follows from one that is sought, or from which one follows, is left out.

    Args:
        assembly: the scenario.
        varied: what is sought.
        but: the beginnings of paths that have no influence, as of a load in whose place a force was recorded.
    """
    freed: list[Uncertain] = []
    sought = {one.path for one in varied}
    for one in deviating(assembly):
        path = one.variation.path
        if path in sought or path.startswith(tuple(but)):
            continue
        if go_together(assembly, [*varied, *(other.variation for other in freed), one.variation]):
            freed.append(one)
    return freed


def deviating(assembly: Assembly) -> Iterator[Uncertain]:
    """The numbers whose ``[uncertainty]`` is not 0, twice as far to either side where that may be."""
    for path, one in {**assembly.truth.arguments, **assembly.truth.numbers}.items():
        if not isinstance(one, Deviation) or not one.relative:
            continue
        nominal, field = nominal_at(assembly, path)
        for times in (FAR, 1.0):
            low, high = sorted(nominal * (1.0 + sign * times * one.relative) for sign in (-1.0, 1.0))
            if (
                nominal not in (0.0, field.auto)
                and low * high > 0.0
                and within(low, field)
                and within(high, field)
            ):
                yield Uncertain(Variation(path, low, high, nominal, one.entry), 1.0 / times)
                break


def nominal_at(assembly: Assembly, path: str) -> tuple[float, Field]:
    """The value of a number before its uncertainty, and its field."""
    argument = assembly.arguments.get(path)
    if argument is not None:
        return argument.value, argument.field
    head, _, inner = path.partition(".")
    return float(value_at(getattr(assembly.nominal, head), inner)), field_at(assembly.loop, path)


def go_together(assembly: Assembly, varied: Sequence[Variation]) -> bool:
    """Whether no number follows from another one."""
    space = Space({one.path: (one.low, one.high) for one in varied})
    try:
        parameters_of(assembly, varied, space.values(np.array([[0.4], [0.6]]).repeat(len(varied), axis=1)))
    except ScenarioError:
        return False
    return True
