"""What is exported: a translated unit, what its numbers are, and the arithmetic of one step."""

import math
from enum import StrEnum
from typing import Annotated, NamedTuple

from hydroservo.core.field import Field

TOLERANCE = "0.01"  # of a number's deviation in single precision, relative to its largest value
INTEGRATED = "machine"  # the argument of equations whose numbers an integrator carries on
RATES = "rates."  # of them, in the state of equations


class Operations(NamedTuple):
    """What a step takes of arithmetic with real numbers at most: of ways that part, the dearer one.

    Changes of sign, absolute values, and arithmetic with whole numbers and bits, are not counted. What
    functions of ``ops`` such as a power take is in the other numbers too.
    """

    additions: Annotated[int, Field("", "additions and subtractions")] = 0
    multiplications: Annotated[int, Field("", "multiplications")] = 0
    divisions: Annotated[int, Field("", "divisions")] = 0
    roots: Annotated[int, Field("", "square roots")] = 0
    comparisons: Annotated[int, Field("", "comparisons")] = 0
    functions: Annotated[int, Field("", "calls of powers, exponentials, sines and their like")] = 0

    @property
    def total(self) -> int:
        """All of them; what functions take counts once."""
        return sum(self[:5])

    def plus(self, other: "Operations") -> "Operations":
        """Both, one after the other."""
        return Operations(*(a + b for a, b in zip(self, other, strict=True)))

    def times(self, count: int) -> "Operations":
        """So many times."""
        return Operations(*(count * a for a in self))


class Part(StrEnum):
    """What of a loop is exported."""

    CONTROLLER = "controller"
    MACHINE = "machine"
    EQUATIONS = "equations"
    DEMAND = "demand"
    LOOP = "loop"


class Precision(StrEnum):
    """In which floating-point format the C computes."""

    DOUBLE = "double"
    SINGLE = "single"


class FmiVersion(StrEnum):
    """Which FMI; tools that read 2.0 are many more than those that read 3.0."""

    FMI2 = "2"
    FMI3 = "3"


class Signal(NamedTuple):
    """One number of a parameter, argument or state record.

    Attributes:
        path: where it is in Python, such as "controller.observer.d1"; the name that users see.
        place: where it is in its C record, such as "observer.d1".
        unit: SI unit as declared; "" is dimensionless.
        meaning: as declared.
        value: a parameter's value, a state's number at the start, 0 for an argument.
        fixed: read before the first sample alone, so that changing it later has no effect.
        least: the smallest number that a parameter may be.
        most: the largest.
        integrated: a state of the plant, valve or supply, which does not come back from nan.
        nominal: its usual size, the largest in the scenario; of what an importer integrates.
    """

    path: str
    place: str
    unit: str
    meaning: str
    value: float
    fixed: bool = False
    least: float = -math.inf
    most: float = math.inf
    integrated: bool = False
    nominal: float = 1.0


class Argument(NamedTuple):
    """A record that ``step`` is given, such as the measurement.

    Attributes:
        name: of the argument; its type is PREFIX_name.
        signals: what ``step`` reads of it, each by its ``place`` in the record, and all that is integrated.
    """

    name: str
    signals: tuple[Signal, ...]


class CModule(NamedTuple):
    """A unit in C: two texts, and a description of every number in their records.

    The header declares the records PREFIX_parameters, PREFIX_state and PREFIX_NAME for each argument, each
    of doubles (or floats) only, the constant object PREFIX_defaults, and::

        void PREFIX_init(PREFIX_state *state, const PREFIX_parameters *parameters);
        double PREFIX_step(PREFIX_state *state, const PREFIX_parameters *parameters,
                           const PREFIX_measurement *measurement, const PREFIX_demand *demand);

    ``step`` takes its arguments in their order; a controller's returns its command, others return nothing.
    Where the parameters are ``inlined`` there is no record of them, no object, and no such argument.

    Attributes:
        part: of the loop.
        prefix: of every name with external linkage; the files are PREFIX.h and PREFIX.c.
        title: what it is, such as "TSMC of scenario paper/sine-tsmc"; in one line,
            which may stand in a comment of C.
        scenario: its canonical text, SI units.
        hash: of the scenario.
        version: of hydroservo.
        period: sample period [s].
        real: "double" or "float".
        inlined: the parameters are written into the source.
        header: text of PREFIX.h.
        source: text of PREFIX.c.
        parameters: of PREFIX_parameters.
        arguments: of ``step``.
        states: of PREFIX_state.
        operations: that a ``step`` takes at most; None where there is no most.
    """

    part: Part
    prefix: str
    title: str
    scenario: str
    hash: str
    version: str
    period: float
    real: str
    inlined: bool
    header: str
    source: str
    parameters: tuple[Signal, ...]
    arguments: tuple[Argument, ...]
    states: tuple[Signal, ...]
    operations: Operations | None = None

    def places(self, argument: str) -> tuple[str, ...]:
        """The places of what ``step`` is given in an argument; none where it has no such argument."""
        return tuple(signal.place for one in self.arguments if one.name == argument for signal in one.signals)

    @property
    def inputs(self) -> list[Signal]:
        """What ``step`` reads of its arguments, in their order."""
        return [signal for argument in self.arguments for signal in argument.signals]

    @property
    def command(self) -> bool:
        """True where ``step`` returns the command, which is the state's number ``u``."""
        return self.part is Part.CONTROLLER


class Proof(NamedTuple):
    """What was shown of an export when its vectors were made.

    Attributes:
        samples: of the vectors.
        compiler: with which the C replays the vectors, in double precision bit for bit; empty if none did.
        unproved: why the C did not replay the vectors; empty if it did.
        deviation: of numbers in single precision, as the replay prints it; empty if it was not measured.
    """

    samples: int
    compiler: str = ""
    unproved: str = ""
    deviation: str = ""
