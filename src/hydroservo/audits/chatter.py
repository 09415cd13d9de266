"""Whether a loop will chatter, how fast and how much, before it is run: by harmonic balance."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise, product
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.audits.describing import (
    DescribingFunction,
    busiest_instant,
    command_limit,
    describing_function,
    freeze_loop,
)
from hydroservo.audits.monitors import SHARE
from hydroservo.control.loop import Loop
from hydroservo.core.field import Field
from hydroservo.runs.arguments import checked_loop

Response = NDArray[np.complex128]
Vector = NDArray[np.float64]

TURN = 2.0  # [rad] by which phases are from 0 at most where one may pass through it between two tones
ALIKE = 0.5  # of the largest amplitude, from which a tone is taken for as large


class LimitCycle(NamedTuple):
    """A tone that a loop sustains, and to which it comes back."""

    amplitude: float  # of the command [V]
    frequency: float  # [rad/s]
    soft: bool  # whether the loop comes to it from rest; else only from a swing that is large enough


def limit_cycles(found: DescribingFunction) -> list[LimitCycle]:
    """Where N(A, w) = 1, those that are stable, the largest first.

    With log N = g + j phi, linear between neighbours in log A and log w, a tone is stable where::

        dg/dA dphi/dw - dg/dw dphi/dA > 0

    At Nyquist's frequency N is real by itself, and a tone stable where |N| falls as A grows.

    Source: Gelb, Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, 1968, sec.
    3.1 and 3.2; the condition of stability is Loeb's.
    Fails where the balance of two tones at once decides, and where N turns much between two tones.
    """
    driven = np.logical_and.accumulate([tone_grows(found.frequencies, gains) for gains in found.gains])
    cycles = [
        LimitCycle(float(np.exp(a)), float(np.exp(w)), soft=bool(driven[i]))
        for i, a, w in (*inner_roots(found), *nyquist_roots(found))
    ]
    return sorted(cycles, key=lambda cycle: -cycle.amplitude)


def inner_roots(found: DescribingFunction) -> Iterator[tuple[int, float, float]]:
    """Stable roots of log N, in triangles of neighbours: the row below, log A and log w of each."""
    sizes, tones = np.log(found.amplitudes), np.log(found.frequencies)
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(found.gains)
    usable = np.isfinite(logs) & (np.abs(logs.imag) < TURN)
    for i, j in product(range(len(sizes) - 1), range(len(tones) - 1)):
        if not usable[i : i + 2, j : j + 2].all():
            continue
        for corners in (((0, 0), (1, 0), (0, 1)), ((1, 1), (0, 1), (1, 0))):
            places = [(i + di, j + dj) for di, dj in corners]
            root = stable_root(np.array([logs[place] for place in places]))
            if root is None:
                continue
            w = float(sum(share * tones[q] for share, (_, q) in zip(root, places, strict=True)))
            if w < tones[-1] - 1e-9:
                yield i, float(sum(share * sizes[p] for share, (p, _) in zip(root, places, strict=True))), w


def stable_root(logs: Response) -> Vector | None:
    """Where log N is 0 in a triangle whose corners follow each other as A does w, as shares of these."""
    first, along, across = logs[0], logs[1] - logs[0], logs[2] - logs[0]
    turn = along.real * across.imag - across.real * along.imag
    if not turn > 0.0:
        return None
    a = (-first.real * across.imag + across.real * first.imag) / turn
    w = (-along.real * first.imag + first.real * along.imag) / turn
    shares = np.array([1.0 - a - w, a, w])
    return shares if (shares >= -1e-12).all() else None


def nyquist_roots(found: DescribingFunction) -> Iterator[tuple[int, float, float]]:
    """Stable roots at Nyquist's frequency: the row below, log A and log w of each."""
    sizes, last = np.log(found.amplitudes), found.gains[:, -1].real
    for i, (here, there) in enumerate(pairwise(last)):
        if here >= 1.0 > there > 0.0:
            share = np.log(here) / np.log(here / there)
            yield i, float(sizes[i] + share * (sizes[i + 1] - sizes[i])), float(np.log(found.frequencies[-1]))


def tone_grows(frequencies: Vector, gains: Response) -> bool:
    """Whether a tone of some frequency grows: where the phase passes 0 the gain is 1 or more."""
    phases, known = np.angle(gains), np.isfinite(gains) & (np.abs(gains) > 0.0)
    for i in range(len(frequencies) - 2):
        before, after = phases[i : i + 2]
        if not known[i : i + 2].all() or before * after > 0.0 or abs(after - before) > TURN:
            continue
        share = before / (before - after) if before != after else 0.0
        if abs(gains[i]) * (abs(gains[i + 1]) / abs(gains[i])) ** share >= 1.0:
            return True
    return bool(known[-1] and gains[-1].real >= 1.0)


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
    its describing function and its limit cycles do.
    """
    checked_loop(loop)
    at = busiest_instant(loop) if time is None else time
    return chatter_of(describing_function(freeze_loop(loop, at)), command_limit(loop.controller), at)


def chatter_of(found: DescribingFunction, limit: float, time: float) -> Chatter:
    """What is foretold from a describing function, under the largest command [V], of an instant [s]."""
    cycles = limit_cycles(found)
    own = LimitCycle(forced_amplitude(found, limit), found.frequency, soft=True)
    reached = fastest_large_cycle([own, *(one for one in cycles if one.soft)], limit)
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


def fastest_large_cycle(cycles: Sequence[LimitCycle], limit: float) -> LimitCycle:
    """The fastest of those that are about as large as the largest, for that has grown before the others."""
    largest = max(min(one.amplitude, limit) for one in cycles)
    return max((one for one in cycles if one.amplitude >= ALIKE * largest), key=lambda one: one.frequency)


def forced_amplitude(found: DescribingFunction, limit: float) -> float:
    """What the loop makes of a law's own swing: the least A with A |1 - N(A, w)| above it [V]."""
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
