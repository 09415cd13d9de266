"""What the FMU of a load holds the rod with before anything moves."""

from hydroservo.cosimulation import ForeignLoad, first_force
from hydroservo.loop import Loop
from hydroservo.runs.steady import check_given
from hydroservo.starts import AsBuilt


def with_first_force(loop: Loop) -> Loop:
    """The loop with the force that its load's FMU answers to the start; any other loop as it is.

    Raises:
        LoopError: the FMU refuses.
        ParameterError: the start gives a number that the loop has not.
    """
    if not isinstance(loop.load, ForeignLoad):
        return loop
    check_given(loop)
    state = AsBuilt(loop.start.given).of(loop.blocks_begin())
    return loop._replace(load=loop.load._replace(held=first_force(loop, state.plant)))
