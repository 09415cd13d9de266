"""A first guess of a law's gains, from the natural frequency of the axis that it moves."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Annotated, Any, NamedTuple

from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, field_at
from hydroservo.core.field import Field
from hydroservo.linear.axis import Axis, axis_at
from hydroservo.linear.places import SHARES, largest_command, sliding
from hydroservo.runs.arguments import checked_loop

FOLLOWED = ("m", "m/s")  # what a loop controls, by its unit
USED = 0.5  # of the largest stable K_v: 6 dB
RESET = 10.0  # 1/K_v in the reset time of a position law: 6 degrees where its gain crosses 1
LEAD = 4.0  # natural frequencies, where the zero of a velocity law stands: 3 % of its gain at one
INNER = 4.0  # how much slower a loop is than the velocity loop in it


class FirstGuess(NamedTuple):
    """Gains to begin with, and what they are from."""

    natural_frequency: Annotated[float, Field("rad/s", "omega of the axis")]
    damping_ratio: Annotated[float, Field("", "zeta of the axis")]
    velocity_gain: Annotated[float, Field("m/(s V)", "steady velocity per command of the law, K_q")]
    parameters: Annotated[Mapping[str, float], Field("", "gains by their path in the loop, SI")]


def first_guess(loop: Loop) -> FirstGuess | None:
    """Gains of a position or velocity law by the rule of textbooks; None where it says nothing.

    A hydraulic axis behind an integrator, L = K_v G/s with G = omega^2/(s^2 + 2 zeta omega s + omega^2), is
    stable for K_v < 2 zeta omega, so that K_v = zeta omega leaves 6 dB. With the phase by which valve, hold
    and sensors lag, L comes to -180 degrees at a lower frequency w; K_v is at most half of w/|G(j w)| there.
    With K_q the steady velocity per command of the law, what wraps it counted in::

        position law:   k_p = K_v/K_q,   k_i = k_p K_v/10,       k_1 = 1/K_q + k_d
        velocity law:   k_i = K_v/K_q,   k_p = k_i/(4 omega),    k_0 = 1/K_q
        Cascade:        k_p = K_v/4,     k_v = 1,                and its velocity law as above

    as far as the law has these fields; its others stay. The integral of a position law is slow: it takes 6
    degrees where its gain crosses 1. The proportional part of a velocity law adds 3 % to its gain at omega.

    Omega and zeta are those of a pair of poles of the machine, linearised while it moves: under commands of
    10 % and 50 % of the run's largest, both ways, where friction slides and an overlap is left. It is the
    pair in which the piston's velocity takes part most, not the valve's. Of the four commands the one with
    the least K_v/K_q decides; but 1/K_q in a feedforward is the command per velocity from the fastest motion
    one way to that the other way, so that it has what an overlap takes.

    Args:
        loop: the loop, with any gains with which its law moves the machine and settles.

    Returns:
        None for a loop of force or pressure, and a law without these fields; where no such pair of poles
        swings and dies away, or the machine does not follow the command.

    Raises:
        ParameterError: it is not a loop.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 8. Reset time, zero and the share of a cascade are
    chosen here.
    Fails by far to the safe side where the valve is as slow as a lightly damped axis: the gain at omega stays
    below 1, although with that phase it need not. A valve far slower than the axis leaves 6 dB, but less
    phase than usual. Delays in the law, and what PressureFeedback and AccelerationFeedback damp, do not
    count.
    """
    loop = sliding(checked_loop(loop))
    laws = list(laws_of(loop)) if loop.controls.declared().unit in FOLLOWED else []
    largest = largest_command(loop) if laws else 0.0
    found = [axis_at(loop, share * largest) for share in SHARES if largest]
    every = [axis for axis in found if axis is not None]
    if not every:
        return None
    axis = min(every, key=lambda one: one.stable_gain / one.velocity_gain)
    ahead = feedforward_of(every)
    gains = {
        f"{path}.{name}": gain
        for path, law, rule in laws
        for name, gain in rule(axis, ahead, law).items()
        if name in law._fields
    }
    return FirstGuess(axis.natural_frequency, axis.damping_ratio, axis.velocity_gain, gains)


def feedforward_of(every: Sequence[Axis]) -> float:
    """Command per velocity, from the fastest motion one way to that the other way [V s/m]."""
    first, last = (find(every, key=lambda one: one.velocity) for find in (min, max))
    if first is last:
        return 1.0 / first.velocity_gain
    return (last.command - first.command) / (last.velocity - first.velocity)


def position_gains(axis: Axis, ahead: float, law: Any) -> dict[str, float]:
    """Of a law from position to command."""
    loop_gain = USED * axis.stable_gain
    return {
        "proportional_gain": loop_gain / axis.velocity_gain,
        "integral_gain": loop_gain**2 / (RESET * axis.velocity_gain),
        "rate_feedforward": ahead + (law.derivative_gain if "derivative_gain" in law._fields else 0.0),
    }


def velocity_gains(axis: Axis, ahead: float, _: Any) -> dict[str, float]:
    """Of a law from velocity to command."""
    gain = USED * axis.stable_gain / axis.velocity_gain
    return {
        "proportional_gain": gain / (LEAD * axis.natural_frequency),
        "integral_gain": gain,
        "feedforward": ahead,
    }


def cascade_gains(axis: Axis, _: float, __: Any) -> dict[str, float]:
    """Of a law from position to velocity."""
    return {"proportional_gain": USED * axis.stable_gain / INNER, "rate_feedforward": 1.0}


Rule = Callable[[Axis, float, Any], dict[str, float]]
RULES: Mapping[str, Rule] = {"V/m": position_gains, "V s/m": velocity_gains, "1/s": cascade_gains}


def laws_of(loop: Loop) -> Iterator[tuple[str, Block, Rule]]:
    """The law of a loop and those in it of which there is a rule, told by the unit of the proportional gain.

    Each with its path, the outermost first.
    """
    path: str = "controller"
    law: Any = loop.controller
    while True:
        if "proportional_gain" in law._fields:
            rule = RULES.get(field_at(loop, f"{path}.proportional_gain").unit)
            if rule is not None:
                yield path, law, rule
        if not hasattr(law, "controller"):
            return
        path, law = f"{path}.controller", law.controller
