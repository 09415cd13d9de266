"""Harmonic balance: the tones that a loop sustains by itself."""

from collections.abc import Iterator
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.audits.describing import Describing

Response = NDArray[np.complex128]
Vector = NDArray[np.float64]

TURN = 2.0  # [rad] by which phases are from 0 at most where one may pass through it between two tones


class LimitCycle(NamedTuple):
    """A tone that a loop sustains, and to which it comes back.

    Attributes:
        amplitude: of the command [V].
        frequency: [rad/s].
        soft: whether the loop comes to it from rest; else only from a swing that is large enough.
    """

    amplitude: float
    frequency: float
    soft: bool


def limit_cycles(found: Describing) -> list[LimitCycle]:
    """Where N(A, w) = 1, those that are stable, the largest first.

    With log N = g + j phi, linear between neighbours in log A and log w, a tone is stable where::

        dg/dA dphi/dw - dg/dw dphi/dA > 0

    At Nyquist's frequency N is real by itself, and a tone stable where |N| falls as A grows.

    Source: Gelb, Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, 1968, sec.
    3.1 and 3.2; the condition of stability is Loeb's.
    Fails where the balance of two tones at once decides, and where N turns much between two tones.
    """
    driven = np.logical_and.accumulate([grows(found.frequencies, gains) for gains in found.gains])
    cycles = [
        LimitCycle(float(np.exp(a)), float(np.exp(w)), soft=bool(driven[i]))
        for i, a, w in (*inside(found), *fastest(found))
    ]
    return sorted(cycles, key=lambda cycle: -cycle.amplitude)


def inside(found: Describing) -> Iterator[tuple[int, float, float]]:
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


def fastest(found: Describing) -> Iterator[tuple[int, float, float]]:
    """Stable roots at Nyquist's frequency: the row below, log A and log w of each."""
    sizes, last = np.log(found.amplitudes), found.gains[:, -1].real
    for i, (here, there) in enumerate(pairwise(last)):
        if here >= 1.0 > there > 0.0:
            share = np.log(here) / np.log(here / there)
            yield i, float(sizes[i] + share * (sizes[i + 1] - sizes[i])), float(np.log(found.frequencies[-1]))


def grows(frequencies: Vector, gains: Response) -> bool:
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
