"""Both branches of a bent curve: how far they lie apart, and the samples of both on one curve."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hydroservo.identification.maps.sweeps import VARIED, Loops, Pass, SweepLine
from hydroservo.identification.regression import regression

STEPS = 100  # of the command's span
ABOUT = 0.03  # of the span, within which a command counts as met from the other side too
NONE = 5e-3  # of the answer's range, below which one has no sign
ROUNDS = 6  # in which the curve and the width of its loop settle
BOTH_WAYS = 0.1  # of what one direction of the command tells, that the other must tell too

Samples = NDArray[np.float64]


def bent_line(sweeps: Sequence[Pass]) -> SweepLine | None:
    """The loop of a bent curve C, in the volts of its own slope; None where no answer is met both ways::

        y = C(u -+ h/2 -+ T r),   so   y - C(u') + C'(u') u' = C'(u') (u -+ h/2 -+ T r)

    The upper signs are those of a rising command, r the size of its rate, and u' the command less what h and
    T were taken for before. The right side is a line in columns that C' multiplies, whose k is 1.

    Source: Gauss-Newton steps for h and T, with C from all samples at u'.
    Fails where the curve is flat all over, and where the width of the loop changes much along it.
    """
    line = bent_step(sweeps, sweeps)
    for _ in range(ROUNDS):
        if line is None:
            return None
        lag = line.lag()[0] if line.tells_lag else 0.0
        line = bent_step(sweeps, shifted(sweeps, line.apart()[0], lag, line.rate))
    return line


def bent_step(sweeps: Sequence[Pass], moved: Sequence[Pass]) -> SweepLine | None:
    """The line, from the same samples at their commands and at those that were shifted before."""
    at, curve = rough_curve(moved)
    slope = np.gradient(curve, at)
    rates = np.concatenate([one.rate for one in sweeps])
    mean = float(rates.mean())
    varied = bool(rates.std() > VARIED * mean)
    parts = []
    for one, other, on in zip(sweeps, moved, met_both_ways(moved, at, curve, slope), strict=True):
        u, g = other.command, np.interp(other.command, at, slope)
        ways = np.array([one.rising, not one.rising], dtype=np.float64)
        faster = (1.0 if one.rising else -1.0) * (one.rate - mean)
        columns = [g * one.command, *np.outer(ways, g), *([g * faster] if varied else [])]
        parts.append((np.stack(columns, axis=1)[on], (one.answer - np.interp(u, at, curve) + g * u)[on]))
    found = regression(parts)
    line = None if found is None else SweepLine(found, mean)
    return line if line is not None and line.slope()[0] > line.slope()[1] else None


def met_both_ways(
    moved: Sequence[Pass], at: Samples, curve: Samples, slope: Samples
) -> list[NDArray[np.bool_]]:
    """The samples of each pass about whose command the other direction was met too.

    Where the command goes one way alone, the curve takes on what a lag or a hysteresis does. A sign of the
    answer of which one direction tells next to nothing does not count.
    """
    near = ABOUT * (at[-1] - at[0])
    met = {
        way: np.sort(np.concatenate([one.command for one in moved if one.rising == way]))
        for way in (True, False)
    }
    found, signs = [], []
    known = {(sign, way): 0.0 for sign in (-1.0, 0.0, 1.0) for way in met}
    for one in moved:
        other = met[not one.rising]
        there = np.searchsorted(other, one.command + near) > np.searchsorted(other, one.command - near)
        value = np.interp(one.command, at, curve)
        sign = np.sign(value) * (np.abs(value) > NONE * np.ptp(curve))
        for side in (-1.0, 1.0):
            g = np.interp(one.command[there & (sign == side)], at, slope)
            known[side, one.rising] += float(g @ g)
        found.append(there)
        signs.append(sign)
    told = [
        sign
        for sign in (-1.0, 1.0)
        if min(known[sign, way] for way in met) > BOTH_WAYS * max(known[sign, way] for way in met)
    ]
    return [there & np.isin(sign, told) for there, sign in zip(found, signs, strict=True)]


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


def shifted(sweeps: Sequence[Pass], apart: float, lag: float, rate: float) -> list[Pass]:
    """The passes at commands less half of the width of the loop, and what their own rate makes of a lag."""
    return [
        one._replace(
            command=one.command - (1.0 if one.rising else -1.0) * (0.5 * apart + lag * (one.rate - rate))
        )
        for one in sweeps
    ]


def on_one_curve(sweeps: Sequence[Pass], loops: Loops) -> list[Pass]:
    """The passes at the commands at which one curve has the answers of both branches.

    A width below 0 is none: what did not settle lies there as if it were.
    """
    return shifted(sweeps, max(loops.apart[0], 0.0), loops.lag, loops.rate)
