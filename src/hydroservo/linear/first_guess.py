"""A first guess of a law's gains, from the natural frequency of the axis that it moves."""

import cmath
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np

from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, field_at, values
from hydroservo.core.errors import HydroservoError
from hydroservo.core.field import Field
from hydroservo.core.states import filled
from hydroservo.linear.linearization import Linearization
from hydroservo.linear.linearize import linearization_at
from hydroservo.linear.moving_margins import SHARES, largest_command, without_hysteresis
from hydroservo.linear.operating_point import OperatingPoint, operating_point
from hydroservo.linear.slopes import slopes
from hydroservo.linear.system import System, frequency_response, size_vector
from hydroservo.runs.arguments import checked_loop

LEAST_PART = 0.1  # of the piston's velocity in a pair of poles that is the axis's
FURTHER = 1.01  # times a command, for the slope of the velocity
SLOW = 1e-3  # of the natural frequency, below which nothing lags
FOLLOWED = ("m", "m/s")  # what a loop controls, by its unit
USED = 0.5  # of the largest stable K_v: 6 dB
RESET = 10.0  # 1/K_v in the reset time of a position law: 6 degrees where its gain crosses 1
LEAD = 4.0  # natural frequencies, where the zero of a velocity law stands: 3 % of its gain at one
INNER = 4.0  # how much slower a loop is than the velocity loop in it


class HydraulicAxis(NamedTuple):
    """A machine where it moves: K_q omega^2/(s^2 + 2 zeta omega s + omega^2), and what lags in its loop."""

    natural_frequency: float  # omega [rad/s]
    damping_ratio: float  # zeta
    velocity_gain: float  # K_q, by which a little more command of the law raises the velocity [m/(s V)]
    stable_gain: float  # the largest K_v of an integrator before it [1/s]
    velocity: float  # of the piston [m/s]
    command: float  # of the innermost law [V]


def axis_at(loop: Loop, command: float) -> HydraulicAxis | None:
    """The axis about where a loop stays under a command [V]; None where it does not follow, or not swing.

    Its pair of poles is that of the machine in which the piston's velocity takes part most, by the
    participation factor: about half for a mass on its oil, and none for a valve.

    Source: Perez-Arriaga, Verghese, Schweppe, IEEE Transactions on Power Apparatus and Systems 101(9), 1982.
    Fails with several frequencies close to each other.
    """
    try:
        point, further = operating_point(loop, command), operating_point(loop, FURTHER * command)
        machine = linearization_at(point, "machine")
    except HydroservoError:
        return None
    velocity, asked = piston_velocity(point), law_command(point)
    moved, more = piston_velocity(further) - velocity, law_command(further) - asked
    pole = axis_pole(machine)
    if pole is None or not pole.real < 0.0 or not moved * more > 0.0:
        return None
    way = math.copysign(1.0, moved * command)
    gain = stable_gain(pole, axis_lags(point, machine, pole, way))
    return HydraulicAxis(abs(pole), -pole.real / abs(pole), moved / more, gain, velocity, asked)


def piston_velocity(point: OperatingPoint) -> float:
    """The piston's velocity [m/s]."""
    return float(point.loop.seen(point.machine, point.force).velocity)


def law_command(point: OperatingPoint) -> float:
    """What the innermost law asks for [V]."""
    law: Any = point.digital.controller
    while hasattr(law, "controller"):
        law = law.controller
    return float(law.u)


def axis_pole(machine: Linearization) -> complex | None:
    """The pole of those that swing in which the velocity takes part most; None if it does in none."""
    from scipy.linalg import eig

    outputs = [one.name for one in machine.outputs]
    if "velocity" not in outputs:
        return None
    velocity = machine.C[outputs.index("velocity")]
    poles, left, right = eig(machine.A, left=True, right=True)
    with np.errstate(all="ignore"):
        parts = np.abs((velocity @ right) * (left.conj().T @ velocity) / np.sum(left.conj() * right, axis=0))
    parts = np.where((poles.imag > 0.0) & np.isfinite(parts), parts, 0.0)
    k = int(parts.argmax())
    return complex(poles[k]) if parts[k] > LEAST_PART else None


def stable_gain(pole: complex, lag: Callable[[float], float]) -> float:
    """The largest K_v [1/s] of an integrator before an axis, with and without a lag.

    2 zeta omega, or w/|G(j w)| at the frequency w where axis and lag come to 90 degrees, if that is less.
    """
    from scipy.optimize import brentq

    omega = abs(pole)

    def beyond(w: float) -> float:
        return lag(w) - cmath.phase(axis_response(pole, w)) - 0.5 * math.pi

    w = float(brentq(beyond, SLOW * omega, omega)) if beyond(SLOW * omega) < 0.0 else SLOW * omega
    return min(-2.0 * pole.real, w / abs(axis_response(pole, w)))


def axis_response(pole: complex, w: float) -> complex:
    """G = omega^2/(s^2 + 2 zeta omega s + omega^2) at a frequency [rad/s]."""
    return abs(pole) ** 2 / complex(abs(pole) ** 2 - w**2, -2.0 * pole.real * w)


def axis_lags(
    point: OperatingPoint, machine: Linearization, pole: complex, way: float
) -> Callable[[float], float]:
    """What a loop lags by [rad], beside its axis and its law, at a frequency [rad/s].

    The way is -1 where the velocity falls with the command, else 1.
    """
    sensors, loop = sensor_system(point), point.loop
    signal = np.array([1.0, 0.0] if loop.controls.declared().unit == "m/s" else [0.0, 1.0])
    held = loop.simulation.period * (1.5 - loop.hold.applied(loop.hold.init(), 1.0, loop.simulation.period))

    def lag(w: float) -> float:
        moved = complex(machine.response(w, "velocity", "command")[0])
        motion = np.array([1.0, 1.0 / (1j * w)])  # velocity and position
        measured = complex(frequency_response(sensors, np.array([w]))[0, 0] @ motion / (signal @ motion))
        return phase_lag(way * moved / axis_response(pole, w)) + phase_lag(measured) + w * held

    return lag


def phase_lag(answer: complex) -> float:
    """The lag of an answer [rad], up to 270 degrees; 0 for one that leads."""
    return max((0.5 * math.pi - cmath.phase(answer)) % (2.0 * math.pi) - 0.5 * math.pi, 0.0)


def sensor_system(point: OperatingPoint) -> System:
    """The sensors from velocity and position to what they say of the controlled signal."""
    period, count = point.loop.simulation.period, len(values(point.digital.sensors))
    seen = point.loop.seen(point.machine, point.force)

    def rows(here: OperatingPoint, numbers: Sequence[Any]) -> list[Any]:
        left = iter(numbers)
        before: Any = filled(here.digital.sensors, left)
        there = seen._replace(velocity=next(left), position=next(left))
        after = here.loop.sensors.step(before, there, here.loop.draws(0.0, period), period)
        y = here.loop.sensors.measure(after, there, here.command)
        return [*values(after), here.loop.controls.of(y, here.command)]

    numbers = np.array([*values(point.digital.sensors), seen.velocity, seen.position])
    table = slopes(rows, point, numbers, size_vector(point.digital.sensors, 0.1, 0.1)).mean
    (a, b), (c, d) = ((part[:, :count], part[:, count:]) for part in (table[:count], table[count:]))
    return System(a, b, c, d, period)


class GuessedGain(NamedTuple):
    """A gain, and the rule that it is from."""

    value: float  # SI
    rule: str  # with its source


class FirstGuess(NamedTuple):
    """Gains to begin with, and what they are from."""

    natural_frequency: Annotated[float, Field("rad/s", "omega of the axis")]
    damping_ratio: Annotated[float, Field("", "zeta of the axis")]
    velocity_gain: Annotated[float, Field("m/(s V)", "steady velocity per command of the law, K_q")]
    parameters: Annotated[Mapping[str, float], Field("", "gains by their path in the loop, SI")]
    rules: Annotated[Mapping[str, str], Field("", "the rule of each gain, by its path")]


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
    loop = without_hysteresis(checked_loop(loop))
    laws = list(guessable_laws(loop)) if loop.controls.declared().unit in FOLLOWED else []
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
    values = {path: gain.value for path, gain in gains.items()}
    rules = {path: gain.rule for path, gain in gains.items()}
    return FirstGuess(axis.natural_frequency, axis.damping_ratio, axis.velocity_gain, values, rules)


def feedforward_of(every: Sequence[HydraulicAxis]) -> float:
    """Command per velocity, from the fastest motion one way to that the other way [V s/m]."""
    first, last = (find(every, key=lambda one: one.velocity) for find in (min, max))
    if first is last:
        return 1.0 / first.velocity_gain
    return (last.command - first.command) / (last.velocity - first.velocity)


HALF_OF_LARGEST = "K_v/K_q, K_v at most half of the largest stable (Merritt, 1967, ch. 8)"
STEADY = "1/K_q: command of a steady velocity"


def position_gains(axis: HydraulicAxis, ahead: float, law: Any) -> dict[str, GuessedGain]:
    """Of a law from position to command."""
    loop_gain, reset = USED * axis.stable_gain, f"k_p K_v/{RESET:g} (chosen)"
    damped = law.derivative_gain if "derivative_gain" in law._fields else 0.0
    return {
        "proportional_gain": GuessedGain(loop_gain / axis.velocity_gain, HALF_OF_LARGEST),
        "integral_gain": GuessedGain(loop_gain**2 / (RESET * axis.velocity_gain), reset),
        "rate_feedforward": GuessedGain(ahead + damped, STEADY + (", and k_d" if damped else "")),
    }


def velocity_gains(axis: HydraulicAxis, ahead: float, _: Any) -> dict[str, GuessedGain]:
    """Of a law from velocity to command."""
    gain, lead = USED * axis.stable_gain / axis.velocity_gain, LEAD * axis.natural_frequency
    return {
        "proportional_gain": GuessedGain(gain / lead, f"k_i/({LEAD:g} omega) (chosen)"),
        "integral_gain": GuessedGain(gain, HALF_OF_LARGEST),
        "feedforward": GuessedGain(ahead, STEADY),
    }


def cascade_gains(axis: HydraulicAxis, _: float, __: Any) -> dict[str, GuessedGain]:
    """Of a law from position to velocity."""
    return {
        "proportional_gain": GuessedGain(
            USED * axis.stable_gain / INNER, f"K_v/{INNER:g}: slower than the velocity loop (chosen)"
        ),
        "rate_feedforward": GuessedGain(1.0, "1: the demanded velocity"),
    }


Rule = Callable[[HydraulicAxis, float, Any], dict[str, GuessedGain]]
RULES: Mapping[str, Rule] = {"V/m": position_gains, "V s/m": velocity_gains, "1/s": cascade_gains}


def guessable_laws(loop: Loop) -> Iterator[tuple[str, Block, Rule]]:
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
