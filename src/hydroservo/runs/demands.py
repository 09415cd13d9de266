"""Whether a machine can do what is asked of it."""

import math

import numpy as np

from hydroservo.formatting import MINUS, quantity
from hydroservo.hooks import at_rest, is_valveless
from hydroservo.loop import Loop
from hydroservo.signals import Pressures

__all__ = ["demand_caution"]

INSTANTS = 1001  # of a run at which its demand is looked at


def demand_caution(loop: Loop) -> str:
    """That a demand goes where the machine cannot, and where that is; else empty.

    What a machine can do is what the controlled signal's ``reach`` says of it, as the stroke of a position.

    Args:
        loop: the loop.

    Fails to see a demand that is there and back between two of 1001 instants.
    """
    if not hasattr(loop.controls, "reach"):
        return ""
    line = loop.supply.pressures(loop.supply.init())
    if is_valveless(loop.drive):  # which has a pressure of its own, whatever the line's
        line = Pressures(math.inf, line.tank)
    least, most = loop.controls.reach(at_rest(loop.plant, loop.supply, loop.load), line)
    times = np.linspace(0.0, loop.simulation.duration, INSTANTS)
    asked = [loop.reference.at(t).value for t in times.tolist()]
    for value, beyond in ((min(asked), min(asked) < least), (max(asked), max(asked) > most)):
        if beyond and math.isfinite(value):
            signal = loop.controls.declared()
            here, low, high = (quantity(one, signal.unit) for one in (value, least, most))
            said = f"the demand goes to {here}, and the machine's {signal.meaning} to {low} ... {high}"
            return said.replace(MINUS, "-")
    return ""
