"""Whether a block can be exported as C, and gives the same bits there."""

from hydroservo.control.loop import Loop
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.roles import Controller, Monitor
from hydroservo.export.c.project import proof_of
from hydroservo.export.c.vectors import made_vectors
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part, Unit
from hydroservo.machine.sensors.missing import missing_signals
from hydroservo.runs.run import ready
from hydroservo.scenario.fits import a_role
from hydroservo.testing.case import Case
from hydroservo.testing.places import loop_with


def check_translated(case: Case) -> str:
    """A loop with it is exported as C, which gives the bits of plain Python.

    Returns:
        What was not tried, and why; "" if all was.
    """
    if case.role is Monitor:
        return "not tried: a metric is not part of what is exported"
    loop = loop_with(case.block, case.role)
    if loop is None:
        return f"not tried: no block of hydroservo takes {a_role(case.role)} of your own"
    if "velocity" in missing_signals(loop.sensors):
        return "not tried: the controller beside it needs the velocity"
    try:
        ready(loop)
    except ParameterError as error:  # the block's own numbers are asked about elsewhere
        return f"not tried: the machine of this check does not go with it: {error}"
    if case.role is Controller:
        exported_with(case, loop, Part.CONTROLLER)  # as export does, which refuses what a whole loop may have
    unit = exported_with(case, loop, Part.LOOP)
    try:
        unproved = proof_of(unit, made_vectors(loop, Part.LOOP, unit)).unproved
    except HydroservoError as error:
        raise case.error(str(error)) from error
    return f"bits not compared: {unproved}" if unproved else ""


def exported_with(case: Case, loop: Loop, part: Part) -> Unit:
    try:
        return exported_unit(loop, part, prefix="block", title=case.cls.__name__)
    except HydroservoError as error:
        raise case.error(str(error)) from error
