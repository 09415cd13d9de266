"""On what the unknowns of an FMU depend, so that importers can put units into order."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from hydroservo.export.fmu.variables import Kind, Variable
from hydroservo.export.unit import Part, Unit

PARAMETERS = (Kind.FIXED, Kind.TUNABLE)


class Unknown(NamedTuple):
    """A variable that is computed.

    Attributes:
        variable: it.
        knowns: the variables that it depends on; None says nothing, and so all of them.
    """

    variable: Variable
    knowns: Sequence[Variable] | None

    def dependencies(self, first_index: int) -> dict[str, str]:
        """The attributes of its element, where variables are counted from an index."""
        if self.knowns is None:
            return {}
        return {
            "dependencies": " ".join(str(one.reference + first_index) for one in self.knowns),
            "dependenciesKind": " ".join("dependent" for _ in self.knowns),
        }


class Structure(NamedTuple):
    """The unknowns of an FMU, after the initialization and in it."""

    outputs: Sequence[Unknown]
    rates: Sequence[Unknown]
    initial: Sequence[Unknown]


def structure_of(unit: Unit, variables: Sequence[Variable], clock: Variable | None) -> Structure:
    """What depends on what.

    A controller answers its inputs at once. The outputs of a machine, a demand and a loop change in steps
    alone. Of equations, the rates depend on all there is, and the outputs on the state or the time alone.
    """
    rates = [one for one in variables if one.kind is Kind.RATE]
    outputs = [one for one in variables if one.causality == "output"]
    if clock is not None:  # before its first tick there is nothing to find
        ticking = [Unknown(one, [clock, *direct_knowns(unit, variables, one)]) for one in outputs]
        return Structure(ticking, rates=[], initial=[])
    return Structure(
        outputs=[Unknown(one, list(direct_knowns(unit, variables, one))) for one in outputs],
        rates=[Unknown(one, None) for one in rates],
        initial=[
            Unknown(one, initial_knowns(unit, variables, one))
            for one in variables
            if one.kind is Kind.RATE or one.causality == "output"
        ],
    )


def direct_knowns(unit: Unit, variables: Sequence[Variable], output: Variable) -> Iterator[Variable]:
    """What an output depends on after the initialization, without a step between."""
    if unit.command:
        yield from (one for one in variables if one.kind is Kind.INPUT)
    elif output.kind is Kind.INTEGRATED:
        yield output
    elif unit.part is Part.EQUATIONS and output.name.startswith("load."):
        yield from (one for one in variables if one.kind is Kind.TIME)
    elif unit.part is Part.EQUATIONS:
        yield from (one for one in variables if one.kind is Kind.INTEGRATED)


def initial_knowns(unit: Unit, variables: Sequence[Variable], unknown: Variable) -> Sequence[Variable] | None:
    """What an unknown depends on in the initialization.

    A machine's initial outputs come from parameters alone; a tool that does not know so may see an algebraic
    loop between two units. A unit without arguments is in no such loop, and nothing is said of its unknowns.
    """
    answers = unit.command or unknown.kind is Kind.RATE
    kinds = (*PARAMETERS, Kind.INPUT) if answers else PARAMETERS
    return [one for one in variables if one.kind in kinds] or None if unit.arguments else None
