"""At which gain a loop starts to oscillate for good, found on its nonlinear simulation."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.controllers import DirectionalGain, Saturation
from hydroservo.control.controllers.dither import without_dither
from hydroservo.control.loop import Loop
from hydroservo.control.monitors import Oscillation
from hydroservo.core.group import group
from hydroservo.runs.arguments import checked_loop
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import RunProgress

FREE = 1e6  # [V] a limit that binds no more
MOST = 20.0  # dB
LARGE = 0.1  # V, a hundredth of the usual 10 V: less is hunting, as about a valve's hysteresis
LONGER = 5.0  # s, by which a run goes on
FINE, COARSE = 0.25, 0.5  # dB from factor to factor
MANY = 50_000  # samples of a run from which steps are coarse


def oscillation_gain(loop: Loop, *, threshold: float = LARGE, progress: RunProgress | None = None) -> float:
    """The least factor on a loop's gain from which it oscillates for good, on its simulation.

    The loop runs as it is, noise, steps, limits and all but dither, under its own demand and load and 5 s
    longer, once for each factor on its command from 0 to 20 dB in steps of 0.25 dB (of 0.5 dB in runs of
    50000 samples or more), all side by side. It is the first factor with which the run oscillates, as
    :class:`~hydroservo.control.monitors.Oscillation` has it, or diverges, and with the next one too.

    Args:
        loop: the loop.
        threshold: amplitude of the command from which it counts [V]. Small ones, as of a law that hunts about
            a valve's hysteresis or between two steps of an encoder, do not grow with the gain.
        progress: called now and then with the fraction done.

    Returns:
        The factor; 1 where the loop oscillates as it stands, infinite where it does not up to a factor of 10,
        nan where the runs are too short to tell.

    Source: chosen here.
    Fails to see what another demand or load would set off, as one at rest where the loop's own keeps it in
    motion, which damps it; and an onset between two of the factors.
    """
    loop = with_longer_run(checked_loop(loop))
    factors = gain_factors(loop)
    gains = dict.fromkeys(("controller.extend_gain", "controller.retract_gain"), factors)
    run = quietly(simulate_batch)
    data = run(with_amplified_command(loop), gains, metrics=[Oscillation(threshold)], progress=progress)
    amplitude = data["oscillation_command"].values
    return first_lasting_swing(factors, np.where(data["diverged"].values, math.inf, amplitude))


def with_longer_run(loop: Loop) -> Loop:
    """The loop with a run that goes on, and without dither, an oscillation that is meant."""
    duration, h = loop.simulation.duration + LONGER, loop.simulation.period
    simulation = loop.simulation._replace(duration=h * round(duration / h))
    return loop._replace(simulation=simulation, controller=without_dither(loop.controller))


def gain_factors(loop: Loop) -> NDArray[np.float64]:
    """The factors, from 1 on."""
    step = COARSE if loop.simulation.duration / loop.simulation.period >= MANY else FINE
    found: NDArray[np.float64] = 10.0 ** (np.arange(0.0, MOST + 0.5 * step, step) / 20.0)
    return found


def with_amplified_command(loop: Loop, factor: float = 1.0) -> Loop:
    """The loop with its command multiplied by a factor, of which its law is told nothing, and no limit on it.

    Its gains are the wrapper's, ``controller.extend_gain`` and ``controller.retract_gain``.
    """
    law = DirectionalGain(loop.controller, factor, factor, Saturation(FREE))
    start: Any = loop.start
    if "controller" in start.given._fields:  # its states go into the wrapper's
        inner = start.given.controller
        outer = {"u": factor * inner.u} if "u" in inner._fields else {}
        state = group(outer | {"gain": factor, "controller": inner})
        start = start._replace(given=start.given._replace(controller=state))
    return loop._replace(controller=law, start=start)


def first_lasting_swing(factors: NDArray[np.float64], amplitude: NDArray[np.float64]) -> float:
    """The first factor with which a loop oscillates, and with the next too.

    An amplitude is 0 for none and nan where it cannot be told. The result is infinite for none, and nan where
    one before cannot be told.
    """
    swings = amplitude > 0.0
    lasting = np.flatnonzero(swings & np.append(swings[1:], False))
    first = 0 if swings[0] else int(lasting[0]) if lasting.size else len(factors)
    if np.isnan(amplitude[:first]).any():
        return math.nan
    return float(factors[first]) if first < len(factors) else math.inf
