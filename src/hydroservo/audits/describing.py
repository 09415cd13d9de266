"""A loop as it is at one instant, and its describing function, opened at its command."""

import math
from contextlib import suppress
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.audits.monitors import ToneAnswer
from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.dither import without_dither
from hydroservo.control.loop import Loop
from hydroservo.control.references.ramp import Ramp
from hydroservo.core import ops
from hydroservo.core.block import Block, Field, is_block
from hydroservo.core.errors import ParameterError
from hydroservo.core.hooks import smoothed
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.linear.excitation import ExcitedState
from hydroservo.machine.loads.constant import Constant
from hydroservo.machine.starts import Steady
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import runnable_loop
from hydroservo.runs.steady import steady_state

LOOKS = 2000  # instants of a run at which its demand is looked at
TRIED = (1e-3, 1e-2, 0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0)  # [V], until one is enough
Vector = NDArray[np.float64]

LONGEST = 0.5  # [s] of the window over which a tone is heard
MOST = 10_000  # samples of it
SETTLING = 0.8  # of the window, before it
PERIODS = 4.0  # of the slowest tone in it
SLOW = 40  # tones evenly by the logarithm
FAST = 11  # from some share of Nyquist's frequency up to it
CORNER = 0.6  # that share
SIZES = 16  # amplitudes
LEAST = 1e-5  # of the command's limit
BEYOND = 1.4  # of the limit, above which no limited command has a describing function of 1
FREE = 1e6  # times a limit, to bind no more
LIMIT = 10.0  # [V] where a law has no limiter


class FrozenLoop(NamedTuple):
    """A loop whose demand and load stay what they are at an instant."""

    loop: Loop  # with a constant demand and load, and its machine settled there
    command: float  # under which the machine has settled [V]


def busiest_instant(loop: Loop) -> float:
    """The first instant at which demand and load, each by its own largest size, are largest together [s]."""
    period, duration = loop.simulation.period, loop.simulation.duration
    samples = np.unique(np.round(np.linspace(0.0, duration / period, LOOKS + 1)))
    times = (samples * period).tolist()
    sizes = np.abs([(loop.reference.at(t).value, loop.load.force(t)) for t in times])
    largest = sizes.max(axis=0)
    shares = (sizes / np.where(largest > 0.0, largest, 1.0)).sum(axis=1)
    return float(times[int(np.argmax(np.round(shares, 6)))])


def freeze_loop(loop: Loop, time: float) -> FrozenLoop:
    """The loop at an instant [s], without dither, and with sensors that are exact and have no steps.

    Its machine moves evenly as a demanded velocity asks, or rests where it cannot and where another signal is
    controlled; and what it then shows is demanded, to the last digit, for a law that switches feels any other
    offset.
    """
    demand, force = loop.reference.at(time).value, loop.load.force(time)
    still = loop._replace(
        controller=without_dither(loop.controller),
        load=Constant(force),
        start=Steady(),
        sensors=smoothed(exact_sensors(loop.sensors)),
    )
    begun, command = runnable_loop(still)._replace(start=Steady()), 0.0
    if isinstance(loop.controls, Velocity):
        with suppress(ParameterError):
            command = command_for(begun, demand)
    demand = begun.controls.of(begun.seen(steady_state(begun, command), force), command)

    return FrozenLoop(still._replace(reference=Ramp(demand, demand, 1.0), start=Steady(command)), command)


def command_for(loop: Loop, velocity: float) -> float:
    """The command [V] under which a machine moves evenly at a velocity [m/s], or nearly so."""
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


def exact_sensors(sensors: Block) -> Block:
    """Sensors whose numbers named noise are 0, in them and in blocks in them."""
    changed = {
        name: exact_sensors(value) if is_block(value) else 0.0
        for name, value in sensors._asdict().items()
        if is_block(value) or name.endswith("noise")
    }
    return sensors._replace(**changed)


class DescribingFunction(NamedTuple):
    """What a law answers to tones at its machine's command."""

    amplitudes: Vector  # A of the tones [V], rising, shape (sizes,)
    frequencies: Vector  # w of the tones [rad/s], rising, the last that of Nyquist, shape (tones,)
    gains: NDArray[np.complex128]  # N(A, w) = U/A, shape (sizes, tones); nan where the machine was lost
    swing: float  # half the range of the law's command without a tone [V]
    frequency: float  # at which that then crosses its mean [rad/s]


def describing_function(still: FrozenLoop) -> DescribingFunction:
    """N(A, w): the fundamental of what the law asks for, by the tone that its machine is given.

    The machine is as it is, with its valve, hold and delay, and so is the law with its observer; nothing is
    linearised and no switching element is named. What is asked for beyond the command's limit is cut off
    afterwards. Tones of all amplitudes and frequencies run side by side.

    Source: Gelb, Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, 1968,
    ch. 2 and 3.
    Fails where what the law asks for is far from a tone and the machine passes its harmonics.
    """
    loop = still.loop
    h, limit = loop.simulation.period, command_limit(loop.controller)
    window = h * round(min(LONGEST / h, MOST))
    begin = h * round(SETTLING * window / h)
    nyquist = math.pi / h
    slow = np.geomspace(2.0 * math.pi * PERIODS / window, CORNER * nyquist, SLOW)
    frequencies = np.concatenate([slow, np.linspace(CORNER, 1.0, FAST)[1:] * nyquist])
    amplitudes = np.geomspace(LEAST * limit, BEYOND * limit, SIZES)
    size, w = (one.ravel() for one in np.meshgrid(amplitudes, frequencies, indexing="ij"))
    simulation = loop.simulation._replace(duration=h * round((begin + window) / h), record_period=h)
    opened = OpenedLaw(without_limits(loop.controller), still.command, rise=0.5 * begin)
    data = quietly(simulate_batch)(
        loop._replace(simulation=simulation, controller=opened),
        {"controller.amplitude": np.append(size, 0.0), "controller.frequency": np.append(w, nyquist)},
        metrics=[ToneAnswer(begin, window)],
    )
    answers = data["real"].to_numpy() + 1j * data["imaginary"].to_numpy()
    answers[data["diverged"].to_numpy()] = complex(math.nan, math.nan)
    gains = (limited_fundamental(answers[:-1], limit, w < nyquist) / size).reshape(SIZES, len(frequencies))
    swing, crossings = float(data["swing"][-1]), float(data["crossings"][-1])
    return DescribingFunction(amplitudes, frequencies, gains, min(swing, limit), math.pi * crossings / window)


def limited_fundamental(
    answers: NDArray[np.complex128], limit: float, round_tones: NDArray[np.bool_]
) -> NDArray[np.complex128]:
    """The fundamental of tones that are cut off at a limit.

    A tone that is not round has two samples a period, which are cut off as they are.
    """
    share = np.minimum(limit / np.maximum(np.abs(answers), 1e-300), 1.0)
    cut = 2.0 / math.pi * (np.arcsin(share) + share * np.sqrt(1.0 - share**2))
    return np.asarray(answers * np.where(round_tones, cut, share))


def without_limits(law: Block) -> Block:
    """A law whose limiters bind no more, nor those of blocks in it.

    An integrator, which no loop keeps from drifting here, would else end at a limit and hide the tone.
    """
    changed = {name: without_limits(value) for name, value in law._asdict().items() if is_block(value)}
    law = law._replace(**changed)
    own: Block = getattr(law, "saturation", None)
    if not isinstance(getattr(own, "limit", None), float):
        return law
    return law._replace(saturation=own._replace(limit=FREE * own.limit))


def command_limit(law: Block) -> float:
    """The largest command that a law gives [V]: the least limit of its limiter and of those it wraps."""
    own = getattr(getattr(law, "saturation", None), "limit", math.inf)
    inner = getattr(law, "controller", None)
    found = min(own, command_limit(inner)) if is_block(inner) else own
    return found if math.isfinite(found) else LIMIT


@role(Controller)
class OpenedLaw(NamedTuple):
    """A loop opened at its command: the machine is given a tone, and what the law asks for goes nowhere.

    u = bias + A min(t/rise, 1) cos(w t)

    The law measures the machine so driven and is told this u as the command applied.

    Source: the definition of a describing function.
    Fails to keep the machine anywhere: what the tone leaves of an offset adds up in a law's integrator.
    """

    controller: Controller
    bias: Annotated[float, Field("V", "mean command")] = 0.0
    amplitude: Annotated[float, Field("V", "amplitude A of the tone", at_least=0)] = 0.0
    frequency: Annotated[float, Field("rad/s", "frequency w of the tone", at_least=0)] = 0.0
    rise: Annotated[float, Field("s", "time in which the tone grows to its amplitude", above=0)] = 0.1

    def init(self) -> ExcitedState:
        return ExcitedState(0.0, 0.0, self.controller.init())

    def step(self, s: ExcitedState, y: Measurement, r: Demand, dt: float) -> ExcitedState:
        tone = self.amplitude * ops.minimum(s.time / self.rise, 1.0) * ops.cos(self.frequency * s.time)
        return ExcitedState(self.bias + tone, s.time + dt, self.controller.step(s.controller, y, r, dt))
