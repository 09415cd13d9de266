"""Both branches of a bent curve: how far they lie apart, and the samples of both on one curve."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hydroservo.identification.maps.sweeps import Pass, SweepLine, line_through

STEPS = 100  # of the command's span
ABOUT = 0.003  # of the span, within which both directions are at one command
ROUNDS = 7  # in which the curve and the width of its loop settle

Samples = NDArray[np.float64]


def bent_line(sweeps: Sequence[Pass]) -> SweepLine | None:
    """The loop of a bent curve C, in the volts of its own slope; None where no answer is met both ways::

        y = C(u -+ h/2 -+ T r),   so   y - C(u') + C'(u') u' = C'(u') (u -+ h/2 -+ T r)

    The upper signs are those of a rising command, r the size of its rate, and u' the command less what h and
    T were taken for before. The right side is a line in columns that C' multiplies, whose k is 1.

    Source: Gauss-Newton steps for h and T, with C from all samples at u'.
    Fails where the curve is flat all over, and where the width of the loop changes much along it.
    """
    moved, met = list(sweeps), met_both_ways(sweeps)
    for _ in range(ROUNDS):
        at, curve = rough_curve(moved)
        slope = np.gradient(curve, at)
        parts, slopes = [], []
        for one, other, on in zip(sweeps, moved, met, strict=True):
            u = other.command
            slopes.append(on * np.interp(u, at, slope))  # samples of slope 0 and answer 0 do not count
            parts.append(one._replace(answer=on * (one.answer - np.interp(u, at, curve)) + slopes[-1] * u))
        line = line_through(parts, slopes)
        if line is None:
            return None
        lag = line.lag()[0] if line.tells_lag else 0.0
        moved = shift_commands(sweeps, line.apart()[0], lag, line.rate)
    return line


def met_both_ways(sweeps: Sequence[Pass]) -> list[NDArray[np.bool_]]:
    """The samples of each pass at whose command the other direction was met too.

    Where the command goes one way alone, the curve takes on what a lag or a hysteresis does.
    """
    met = {
        way: np.sort(np.concatenate([one.command for one in sweeps if one.rising == way]))
        for way in (True, False)
    }
    near = ABOUT * (max(one[-1] for one in met.values()) - min(one[0] for one in met.values()))
    others = [(met[not one.rising], one.command) for one in sweeps]
    return [np.searchsorted(other, u + near) > np.searchsorted(other, u - near) for other, u in others]


def rough_curve(sweeps: Sequence[Pass]) -> tuple[Samples, Samples]:
    """Means of the answer over even steps of the command, which never fall."""
    at, means, counts = step_means(sweeps, STEPS)
    return at, rising_values(means, counts)


def rising_values(values: Samples, weights: Samples) -> Samples:
    """The values nearest to some that do not fall, by pooling neighbours.

    Source: Barlow et al., Statistical Inference under Order Restrictions, 1972.
    """
    from scipy.optimize import isotonic_regression

    return np.asarray(isotonic_regression(values, weights=weights).x)


def step_means(sweeps: Sequence[Pass], steps: int) -> tuple[Samples, Samples, Samples]:
    """Means of command and answer over even steps of the command, and how many samples each has."""
    command = np.concatenate([one.command for one in sweeps])
    answer = np.concatenate([one.answer for one in sweeps])
    ends = np.linspace(command.min(), command.max(), steps + 1)
    places = np.clip(np.searchsorted(ends, command, side="right") - 1, 0, steps - 1)
    counts = np.bincount(places, minlength=steps)
    there = counts > 0
    at, means = (np.bincount(places, one, steps)[there] / counts[there] for one in (command, answer))
    return at, means, counts[there].astype(np.float64)


def shift_commands(sweeps: Sequence[Pass], apart: float, lag: float, rate: float) -> list[Pass]:
    """The passes at commands less half of the width of the loop, and what their own rate makes of a lag."""
    return [
        one._replace(
            command=one.command - (1.0 if one.rising else -1.0) * (0.5 * apart + lag * (one.rate - rate))
        )
        for one in sweeps
    ]
