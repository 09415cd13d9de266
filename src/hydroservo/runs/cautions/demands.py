"""Whether a machine can do what is asked of it."""

import math

import numpy as np

from hydroservo.control.loop import Loop
from hydroservo.core.formatting import MINUS, quantity
from hydroservo.core.hooks import at_rest, is_valveless, line_pressures
from hydroservo.core.signals import Pressures
from hydroservo.runs.rows import demands

INSTANTS = 1001  # of a run at which its demand is looked at
ROUNDED = 1e-9  # of an instant, by which it counts as reached
IDLE_SHARE = 0.5  # of a command's range which does nothing, up to which the valve goes with its law


def demand_caution(loop: Loop) -> str:
    """That a demand goes where the machine cannot, and where that is; else empty.

    What a machine can do is what the controlled signal's ``reach`` says of it, as the stroke of a position.

    Args:
        loop: the loop.

    Fails to see a demand that is there and back between two of 1001 instants.
    """
    if not hasattr(loop.controls, "reach"):
        return ""
    line = line_pressures(loop)
    if is_valveless(loop.drive):  # which has a pressure of its own, whatever the line's
        line = Pressures(math.inf, line.tank)
    least, most = loop.controls.reach(at_rest(loop), line)
    times = np.linspace(0.0, loop.simulation.duration, INSTANTS)
    asked = demands(loop.reference, times)
    asked = asked[np.isfinite(asked)]
    if not asked.size:
        return ""
    lowest, highest = float(asked.min()), float(asked.max())
    for value, beyond in ((lowest, lowest < least), (highest, highest > most)):
        if beyond:
            signal = loop.controls.declared()
            here, low, high = (quantity(one, signal.unit) for one in (value, least, most))
            said = f"the demand goes to {here}, and the machine's {signal.meaning} to {low} ... {high}"
            return said.replace(MINUS, "-")
    return ""


def late_caution(loop: Loop) -> str:
    """That a demand begins to change at the run's end or after it; else empty.

    Args:
        loop: the loop.

    Fails to see it of a demand without a ``time``, and of one that has the same value as long after it.
    """
    begins, ends = getattr(loop.reference, "time", 0.0), loop.simulation.duration
    at = loop.reference.at
    if begins < (1.0 - ROUNDED) * ends or at(begins + ends).value == at(0.0).value:
        return ""
    return f"nothing is asked for: reference.time is {begins:g} s, and the run ends at {ends:g} s"


def command_caution(loop: Loop) -> str:
    """That the spool is at its limit over more than half of the range of its law's command; else empty.

    What a law does at its limit, as anti-windup does, comes too late there. The law's limit is that of its
    ``saturation``, or of the law that it wraps.

    Args:
        loop: the loop.

    Fails to know a limit that a law has nowhere but in its text.
    """
    path, law = "controller", loop.controller
    while not hasattr(law, "saturation") and hasattr(law, "controller"):
        path, law = f"{path}.controller", law.controller
    limit = getattr(getattr(law, "saturation", None), "limit", 0.0)
    gain, most = getattr(loop.valve, "gain", 0.0), getattr(loop.valve, "max_opening", math.inf)
    if not gain * limit * (1.0 - IDLE_SHARE) > most:
        return ""
    said, asked = quantity(most / gain, "V"), quantity(limit, "V")
    return (
        f"the valve is wide open at {said} (valve.max_opening/valve.gain), and the command goes to {asked} "
        f"({path}.saturation.limit): what is beyond {said} does nothing"
    )
