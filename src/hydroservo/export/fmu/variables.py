"""The variables of an FMU, flat, with their units, and on what each unknown depends."""

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from fractions import Fraction
from typing import NamedTuple

from hydroservo.core.errors import ParameterError
from hydroservo.export.unit import INTEGRATED, RATES, CModule, Part, Signal
from hydroservo.scenario.units import factor_and_dimension

SYMBOLS = {  # and the size of pint's root unit in FMI's base unit
    "gram": ("kg", Fraction(1, 1000)),
    "meter": ("m", Fraction(1)),
    "second": ("s", Fraction(1)),
    "ampere": ("A", Fraction(1)),
    "kelvin": ("K", Fraction(1)),
    "mole": ("mol", Fraction(1)),
    "candela": ("cd", Fraction(1)),
    "radian": ("rad", Fraction(1)),
}
PLAIN = r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*"
NAME = re.compile(rf"{PLAIN}|der\({PLAIN}\)", re.ASCII)  # FMI's structured names
CLOCK = "sample"  # the name of a clock
PERIOD = "period"  # the place of the sample period, in which steps are counted; it is compiled in


def base_unit(text: str) -> Mapping[str, int | float] | None:
    """The attributes of a unit's ``BaseUnit``: exponents, and the factor where it is not 1.

    None where FMI cannot say it, as for m^(2/7), or where the text is no unit.
    """
    try:
        factor, dimension = factor_and_dimension(text)
    except ValueError:
        return None
    attributes: dict[str, int | float] = {}
    for root, power in dimension.items():
        if root not in SYMBOLS or power.denominator != 1:
            return None
        symbol, size = SYMBOLS[root]
        attributes[symbol] = int(power)
        factor *= size ** int(power)
    if factor != 1:
        attributes["factor"] = float(factor)
    return attributes


class VariableKind(Enum):
    """What may be done with a variable: causality, variability and initial value in FMI's words.

    A member's name, in capitals, is also that of the constant in C.
    """

    TIME = ("independent", "continuous", "")
    CONSTANT = ("local", "constant", "exact")
    FIXED = ("parameter", "fixed", "exact")
    TUNABLE = ("parameter", "tunable", "exact")
    INPUT = ("input", "discrete", "")
    OUTPUT = ("output", "discrete", "calculated")
    LOCAL = ("local", "discrete", "calculated")
    INTEGRATED = ("output", "continuous", "calculated")
    RATE = ("local", "continuous", "calculated")


class FmiVariable(NamedTuple):
    """One variable of an FMU."""

    name: str  # that users see
    reference: int  # its value reference, which counts from 0
    kind: VariableKind  # what may be done with it
    place: str  # where it is in C's record of an instance, "" for the time
    unit: str  # as declared
    meaning: str  # as declared
    value: float  # before initialization; for what has a start value
    vital: bool = False  # an integrated state, so that a run is lost with it
    least: float = -math.inf  # the smallest number that a parameter may be
    most: float = math.inf  # the largest
    continuous: bool = False  # an input or output that may change at any instant
    nominal: float = 1.0  # its usual size; of what is integrated
    rate_of: int = 0  # the reference of the variable whose rate it is, 0 for none

    @property
    def causality(self) -> str:
        return str(self.kind.value[0])

    @property
    def variability(self) -> str:
        """As the kind says, but that what is integrated is continuous."""
        return "continuous" if self.vital or self.continuous else str(self.kind.value[1])

    @property
    def initial(self) -> str:
        return str(self.kind.value[2])

    @property
    def has_start(self) -> bool:
        """True for what is not computed, nor the time."""
        return self.kind is not VariableKind.TIME and self.initial != "calculated"


def variables_of(unit: CModule) -> tuple[FmiVariable, ...]:
    """The time, the parameters, the arguments and the states, in this order.

    Raises:
        ParameterError: a name is there twice, or is none in FMI.
    """
    time = FmiVariable("time", 0, VariableKind.TIME, "", "s", "time", 0.0)
    others = continuous_variables(unit) if unit.part is Part.EQUATIONS else sampled_variables(unit)
    variables = (time, *(one._replace(reference=i) for i, one in enumerate(others, 1)))
    references = {f"der({one.name})": one.reference for one in variables}
    variables = tuple(one._replace(rate_of=references.get(one.name, 0)) for one in variables)
    counts = Counter(one.name for one in variables)
    for name, count in counts.items():
        if count > 1:
            raise ParameterError("variable", name, f"is the name of {count} variables of the FMU")
        if not NAME.fullmatch(name):
            raise ParameterError("variable", name, "cannot be the name of a variable of an FMU")
    return variables


def clock_after(variables: Sequence[FmiVariable]) -> FmiVariable:
    """The clock of a controller, to which all that changes at its samples belongs."""
    meaning = "the controller's samples, of which the first is at the start"
    return FmiVariable(CLOCK, len(variables), VariableKind.INPUT, "", "", meaning, 0.0)


def sampled_variables(unit: CModule) -> Iterator[FmiVariable]:
    """The parameters, arguments and states of what takes samples, without their references.

    A parameter that has the name of a state, as a ramp's rate and that of its demand, is ``parameters.`` and
    that.
    """
    taken = {one.path for one in unit.states}
    for one in unit.parameters:
        path = f"parameters.{one.path}" if one.path in taken else one.path
        yield fmu_variable(one._replace(path=path), parameter_kind(one), "parameters")
    for argument in unit.arguments:
        for one in argument.signals:
            yield fmu_variable(one, VariableKind.INPUT, argument.name)
    for one in unit.states:
        yield fmu_variable(
            one, VariableKind.LOCAL if unit.command and one.place != "u" else VariableKind.OUTPUT, "state"
        )


def continuous_variables(unit: CModule) -> Iterator[FmiVariable]:
    """Those of equations that an importer sees: not their instant, start, nor when the load jumps next."""
    for one in unit.parameters:
        yield fmu_variable(one, parameter_kind(one), "parameters")
    for argument in unit.arguments:
        kind = VariableKind.INTEGRATED if argument.name == INTEGRATED else VariableKind.INPUT
        if argument.name != "instant":
            for one in argument.signals:
                yield fmu_variable(one, kind, argument.name)._replace(continuous=True)
    for one in unit.states:
        if one.path.startswith(RATES):
            rate = one._replace(path=f"der({one.path.removeprefix(RATES)})")
            yield fmu_variable(rate, VariableKind.RATE, "state")
        elif one.path.startswith(("outputs.", "load.")):
            yield fmu_variable(one, VariableKind.OUTPUT, "state")._replace(continuous=True)


def fmu_variable(signal: Signal, kind: VariableKind, record: str) -> FmiVariable:
    place = f"{record}.{signal.place}"
    described = (signal.unit, signal.meaning, signal.value, signal.integrated, signal.least, signal.most)
    return FmiVariable(signal.path, 0, kind, place, *described, nominal=signal.nominal)


def parameter_kind(signal: Signal) -> VariableKind:
    if signal.place == PERIOD:
        return VariableKind.CONSTANT
    return VariableKind.FIXED if signal.fixed else VariableKind.TUNABLE


PARAMETERS = (VariableKind.FIXED, VariableKind.TUNABLE)


class FmuUnknown(NamedTuple):
    """A variable that is computed.

    Attributes:
        variable: it.
        knowns: the variables that it depends on; None says nothing, and so all of them.
    """

    variable: FmiVariable
    knowns: Sequence[FmiVariable] | None

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

    outputs: Sequence[FmuUnknown]
    rates: Sequence[FmuUnknown]
    initial: Sequence[FmuUnknown]


def structure_of(unit: CModule, variables: Sequence[FmiVariable], clock: FmiVariable | None) -> Structure:
    """What depends on what.

    A controller answers its inputs at once. The outputs of a machine, a demand and a loop change in steps
    alone. Of equations, the rates depend on all there is, and the outputs on the state or the time alone.
    """
    rates = [one for one in variables if one.kind is VariableKind.RATE]
    outputs = [one for one in variables if one.causality == "output"]
    if clock is not None:  # before its first tick there is nothing to find
        ticking = [FmuUnknown(one, [clock, *direct_knowns(unit, variables, one)]) for one in outputs]
        return Structure(ticking, rates=[], initial=[])
    return Structure(
        outputs=[FmuUnknown(one, list(direct_knowns(unit, variables, one))) for one in outputs],
        rates=[FmuUnknown(one, None) for one in rates],
        initial=[
            FmuUnknown(one, initial_knowns(unit, variables, one))
            for one in variables
            if one.kind is VariableKind.RATE or one.causality == "output"
        ],
    )


def direct_knowns(
    unit: CModule, variables: Sequence[FmiVariable], output: FmiVariable
) -> Iterator[FmiVariable]:
    """What an output depends on after the initialization, without a step between."""
    if unit.command:
        yield from (one for one in variables if one.kind is VariableKind.INPUT)
    elif output.kind is VariableKind.INTEGRATED:
        yield output
    elif unit.part is Part.EQUATIONS and output.name.startswith("load."):
        yield from (one for one in variables if one.kind is VariableKind.TIME)
    elif unit.part is Part.EQUATIONS:
        yield from (one for one in variables if one.kind is VariableKind.INTEGRATED)


def initial_knowns(
    unit: CModule, variables: Sequence[FmiVariable], unknown: FmiVariable
) -> Sequence[FmiVariable] | None:
    """What an unknown depends on in the initialization.

    A machine's initial outputs come from parameters alone; a tool that does not know so may see an algebraic
    loop between two units. A unit without arguments is in no such loop, and nothing is said of its unknowns.
    """
    answers = unit.command or unknown.kind is VariableKind.RATE
    kinds = (*PARAMETERS, VariableKind.INPUT) if answers else PARAMETERS
    return [one for one in variables if one.kind in kinds] or None if unit.arguments else None
