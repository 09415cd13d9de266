"""Whether a loop will chatter, how fast and how much, before it is run."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from hydroservo.audits.balance import LimitCycle, limit_cycles
from hydroservo.audits.describing import Describing, describing, limit_of
from hydroservo.audits.frozen import busiest, frozen
from hydroservo.audits.tone import SHARE
from hydroservo.field import Field
from hydroservo.loop import Loop
from hydroservo.runs.arguments import checked_loop

ALIKE = 0.5  # of the largest amplitude, from which a tone is taken for as large


class Chatter(NamedTuple):
    """What is foretold of a command's swing at one instant of a run."""

    chatters: Annotated[bool, Field("", "whether the command swings by more than the threshold")]
    amplitude: Annotated[float, Field("V", "half of what it swings by; 0 if it rests")]
    frequency: Annotated[float, Field("Hz", "of the swing; nan if it rests")]
    cause: Annotated[str, Field("", "the loop, the law by itself, or nothing")]
    after_a_jolt: Annotated[float, Field("V", "amplitude that only a large enough jolt leads to; 0: none")]
    threshold: Annotated[float, Field("V", "amplitude from which a swing counts, a share of the limit")]
    time: Annotated[float, Field("s", "the instant whose demand and load are taken")]


def chatter(loop: Loop, *, time: float | None = None) -> Chatter:
    """The chatter of a loop, by harmonic balance with the describing function of the whole of it.

    The loop is opened at its command. Tones of many amplitudes A and frequencies w, up to half the sampling
    rate, are given to its machine, and the fundamental of what the law asks for, over A, is N(A, w): with
    valve, hold, delay, observer, all that switches, and the samples. A tone is sustained where N(A, w) = 1,
    and come back to where |N| falls with A. A law that switches without any tone swings by itself; its loop
    then makes that larger or smaller by 1/(1 - N). The larger of both is foretold.

    Args:
        loop: the loop; its sensors are taken without noise and steps of resolution, its demand and its load
            as they are at one instant.
        time: that instant [s]; None for that at which demand and load are largest together.

    Raises:
        ParameterError: as :func:`~hydroservo.simulate` does, or the machine has no steady state there.

    Source: Gelb, Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, 1968; that a
    sampled loop has its limit cycles at fractions of the sampling rate: Kuo, Digital Control Systems, 1980
    (unverified).
    Fails for a loop that is driven to its limits and stays there, which swings no more; and as
    ``audits.describing`` and ``audits.balance`` do.
    """
    checked_loop(loop)
    at = busiest(loop) if time is None else time
    return chatter_of(describing(frozen(loop, at)), limit_of(loop.controller), at)


def chatter_of(found: Describing, limit: float, time: float) -> Chatter:
    """What is foretold from a describing function.

    Args:
        found: N(A, w).
        limit: the largest command [V].
        time: the instant that it is of [s].
    """
    cycles = limit_cycles(found)
    own = LimitCycle(forced(found, limit), found.frequency, soft=True)
    reached = fastest_of([own, *(one for one in cycles if one.soft)], limit)
    threshold = SHARE * limit
    jolted = max((one.amplitude for one in cycles if not one.soft), default=0.0)
    swings = reached.amplitude > threshold
    return Chatter(
        chatters=swings,
        amplitude=min(reached.amplitude, limit) if swings else 0.0,
        frequency=reached.frequency / (2.0 * math.pi) if swings else math.nan,
        cause="nothing" if not swings else "the law" if reached is own else "the loop",
        after_a_jolt=min(jolted, limit) if jolted > max(reached.amplitude, threshold) else 0.0,
        threshold=threshold,
        time=time,
    )


def fastest_of(cycles: Sequence[LimitCycle], limit: float) -> LimitCycle:
    """The fastest of those that are about as large as the largest, for that has grown before the others."""
    largest = max(min(one.amplitude, limit) for one in cycles)
    return max((one for one in cycles if one.amplitude >= ALIKE * largest), key=lambda one: one.frequency)


def forced(found: Describing, limit: float) -> float:
    """What the loop makes of a law's own swing: the least A with A |1 - N(A, w)| above it [V].

    Args:
        found: N(A, w), with the swing and its frequency w.
        limit: the largest command [V].
    """
    if found.frequency < found.frequencies[0] or found.swing == 0.0:  # slower than every tone: a drift
        return 0.0
    place = int(np.argmin(np.abs(found.frequencies - found.frequency)))
    left = found.amplitudes * np.abs(1.0 - found.gains[:, place])
    enough = np.flatnonzero((left >= found.swing) & (found.amplitudes >= 0.5 * found.swing))
    if not enough.size:
        return limit
    i = int(enough[0])
    if i == 0 or not left[i - 1] < found.swing:
        return float(min(found.amplitudes[i], limit))
    share = math.log(found.swing / left[i - 1]) / math.log(left[i] / left[i - 1])
    return float(
        min(found.amplitudes[i - 1] * (found.amplitudes[i] / found.amplitudes[i - 1]) ** share, limit)
    )
