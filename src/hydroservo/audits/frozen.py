"""A loop as it is at one instant of its demand and its load, for as long as one looks."""

import math
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from hydroservo.block import Block, is_block
from hydroservo.controlled.velocity import Velocity
from hydroservo.errors import ParameterError
from hydroservo.hooks import smoothed
from hydroservo.loads.constant import Constant
from hydroservo.loop import Loop
from hydroservo.references.ramp import Ramp
from hydroservo.runs.run import ready
from hydroservo.runs.steady import steady_state
from hydroservo.starts import Steady

LOOKS = 2000  # instants of a run at which its demand is looked at
TRIED = (1e-3, 1e-2, 0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0)  # [V], until one is enough


class Frozen(NamedTuple):
    """A loop whose demand and load stay what they are at an instant.

    Attributes:
        loop: with a constant demand and load, and its machine settled there.
        command: under which the machine has settled [V].
        time: the instant [s].
    """

    loop: Loop
    command: float
    time: float


def busiest(loop: Loop) -> float:
    """The first instant at which demand and load, each by its own largest size, are largest together [s]."""
    period, duration = loop.simulation.period, loop.simulation.duration
    samples = np.unique(np.round(np.linspace(0.0, duration / period, LOOKS + 1)))
    times = (samples * period).tolist()
    sizes = np.abs([(loop.reference.at(t).value, loop.load.force(t)) for t in times])
    largest = sizes.max(axis=0)
    shares = (sizes / np.where(largest > 0.0, largest, 1.0)).sum(axis=1)
    return float(times[int(np.argmax(np.round(shares, 6)))])


def frozen(loop: Loop, time: float) -> Frozen:
    """The loop as it is at an instant, with sensors that are exact and have no steps of resolution.

    Its machine moves evenly as a demanded velocity asks, or rests where it cannot and where another signal is
    controlled; and what it then shows is demanded, to the last digit, for a law that switches feels any other
    offset.
    """
    demand, force = loop.reference.at(time).value, loop.load.force(time)
    still = loop._replace(
        load=Constant(force),
        start=Steady(),
        sensors=smoothed(exact(loop.sensors)),
    )
    begun, command = ready(still)._replace(start=Steady()), 0.0
    if isinstance(loop.controls, Velocity):
        with suppress(ParameterError):
            command = command_for(begun, demand)
    demand = begun.controls.of(begun.seen(steady_state(begun, command), force), command)

    return Frozen(still._replace(reference=Ramp(demand, demand, 1.0), start=Steady(command)), command, time)


def command_for(loop: Loop, velocity: float) -> float:
    """The command under which a machine moves evenly at a velocity, or nearly so [V]."""
    from scipy.optimize import brentq

    if velocity == 0.0:
        return 0.0
    side = math.copysign(1.0, velocity)

    def beyond(u: float) -> float:
        """By how much the machine is faster than asked, to that side."""
        return side * (float(steady_state(loop, side * u).plant.velocity) - velocity)

    below, slow = 0.0, beyond(0.0) < 0.0
    for tried in TRIED:
        try:
            fast = beyond(tried) >= 0.0
        except ParameterError:
            break
        if slow and fast:
            return side * float(brentq(beyond, below, tried, xtol=1e-12, rtol=1e-12))
        below, slow = tried, not fast
    problem = f"moves evenly at {velocity:g} m/s under no command that was found"
    raise ParameterError("plant", type(loop.plant).__name__, problem)


def exact(sensors: Block) -> Block:
    """Sensors whose numbers named noise are 0, in them and in blocks in them."""
    changed = {
        name: exact(value) if is_block(value) else 0.0
        for name, value in sensors._asdict().items()
        if is_block(value) or name.endswith("noise")
    }
    return sensors._replace(**changed)
