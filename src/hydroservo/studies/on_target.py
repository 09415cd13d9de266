"""What a law takes on its target, counted in what is exported of it."""

from typing import Annotated, NamedTuple

from hydroservo.errors import HydroservoError
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.field import Field
from hydroservo.loop import Loop

DOUBLE = 8  # bytes
ENDLESS = "has a loop that goes on as long as its numbers ask"
UNTRANSLATED = "does what has no equal in C; export says what"


class OnTarget(NamedTuple):
    """The price of a law on its target: what one sample takes at most, and how much memory.

    The numbers are those of :class:`~hydroservo.export.operations.Operations`, and None where there are none.
    """

    operations: Annotated[int | None, Field("", "operations with real numbers, all of the next five")] = None
    additions: Annotated[int | None, Field("", "additions and subtractions among them")] = None
    multiplications: Annotated[int | None, Field("", "multiplications")] = None
    divisions: Annotated[int | None, Field("", "divisions")] = None
    roots: Annotated[int | None, Field("", "square roots")] = None
    comparisons: Annotated[int | None, Field("", "comparisons")] = None
    functions: Annotated[int | None, Field("", "calls of powers, exponentials, sines and their like")] = None
    state: Annotated[int | None, Field("", "bytes of state in double precision; half in single")] = None
    parameters: Annotated[int | None, Field("", "bytes of parameters, likewise")] = None
    uncounted: Annotated[str, Field("", "why there are no numbers; or empty")] = ""


def on_target(loop: Loop) -> OnTarget:
    """What the controller of a loop takes on its target.

    It is counted in the terms of which the C is written, so that no compiler is asked, and no machine.

    Args:
        loop: the loop.

    Fails to know a processor: on one without double precision a division takes many times what an addition
    does. The documentation's page on the target holds the count against instructions.
    """
    try:
        unit = exported_unit(loop, Part.CONTROLLER, prefix="law", title="law")
    except HydroservoError:
        return OnTarget(uncounted=UNTRANSLATED)
    found = OnTarget(state=DOUBLE * len(unit.states), parameters=DOUBLE * len(unit.parameters))
    if unit.operations is None:
        return found._replace(uncounted=ENDLESS)
    return found._replace(operations=unit.operations.total, **unit.operations._asdict())
