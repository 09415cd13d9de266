"""The variables of an FMU: one for each number of an export, flat, with what FMI must know of it."""

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from enum import Enum
from typing import NamedTuple

from hydroservo.errors import ParameterError
from hydroservo.export.unit import INTEGRATED, RATES, Part, Signal, Unit

PLAIN = r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*"
NAME = re.compile(rf"{PLAIN}|der\({PLAIN}\)", re.ASCII)  # FMI's structured names
CLOCK = "sample"  # the name of a clock
PERIOD = "period"  # the place of the sample period, in which steps are counted; it is compiled in


class Kind(Enum):
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


class Variable(NamedTuple):
    """One variable of an FMU.

    Attributes:
        name: that users see.
        reference: its value reference, which counts from 0.
        kind: what may be done with it.
        place: where it is in C's record of an instance, "" for the time.
        unit: as declared.
        meaning: as declared.
        value: before initialization; for what has a start value.
        vital: an integrated state, so that a run is lost with it.
        least: the smallest number that a parameter may be.
        most: the largest.
        continuous: an input or output that may change at any instant.
        nominal: its usual size; of what is integrated.
        rate_of: the reference of the variable whose rate it is, 0 for none.
    """

    name: str
    reference: int
    kind: Kind
    place: str
    unit: str
    meaning: str
    value: float
    vital: bool = False
    least: float = -math.inf
    most: float = math.inf
    continuous: bool = False
    nominal: float = 1.0
    rate_of: int = 0

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
        return self.kind is not Kind.TIME and self.initial != "calculated"


def variables_of(unit: Unit) -> tuple[Variable, ...]:
    """The time, the parameters, the arguments and the states, in this order.

    Raises:
        ParameterError: a name is there twice, or is none in FMI.
    """
    time = Variable("time", 0, Kind.TIME, "", "s", "time", 0.0)
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


def clock_after(variables: Sequence[Variable]) -> Variable:
    """The clock of a controller, to which all that changes at its samples belongs."""
    meaning = "the controller's samples, of which the first is at the start"
    return Variable(CLOCK, len(variables), Kind.INPUT, "", "", meaning, 0.0)


def sampled_variables(unit: Unit) -> Iterator[Variable]:
    """The parameters, arguments and states of what takes samples, without their references.

    A parameter that has the name of a state, as a ramp's rate and that of its demand, is ``parameters.`` and
    that.
    """
    taken = {one.path for one in unit.states}
    for one in unit.parameters:
        path = f"parameters.{one.path}" if one.path in taken else one.path
        yield variable(one._replace(path=path), parameter_kind(one), "parameters")
    for argument in unit.arguments:
        for one in argument.signals:
            yield variable(one, Kind.INPUT, argument.name)
    for one in unit.states:
        yield variable(one, state_kind(unit, one), "state")


def continuous_variables(unit: Unit) -> Iterator[Variable]:
    """Those of equations that an importer sees: not their instant, start, nor when the load jumps next."""
    for one in unit.parameters:
        yield variable(one, parameter_kind(one), "parameters")
    for argument in unit.arguments:
        kind = Kind.INTEGRATED if argument.name == INTEGRATED else Kind.INPUT
        if argument.name != "instant":
            for one in argument.signals:
                yield variable(one, kind, argument.name)._replace(continuous=True)
    for one in unit.states:
        if one.path.startswith(RATES):
            rate = one._replace(path=f"der({one.path.removeprefix(RATES)})")
            yield variable(rate, Kind.RATE, "state")
        elif one.path.startswith(("outputs.", "load.")):
            yield variable(one, Kind.OUTPUT, "state")._replace(continuous=True)


def variable(signal: Signal, kind: Kind, record: str) -> Variable:
    place = f"{record}.{signal.place}"
    described = (signal.unit, signal.meaning, signal.value, signal.integrated, signal.least, signal.most)
    return Variable(signal.path, 0, kind, place, *described, nominal=signal.nominal)


def parameter_kind(signal: Signal) -> Kind:
    if signal.place == PERIOD:
        return Kind.CONSTANT
    return Kind.FIXED if signal.fixed else Kind.TUNABLE


def state_kind(unit: Unit, signal: Signal) -> Kind:
    """A controller's output is its command; of other units each number of the state is one."""
    return Kind.LOCAL if unit.command and signal.place != "u" else Kind.OUTPUT
