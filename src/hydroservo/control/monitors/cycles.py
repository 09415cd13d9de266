"""Cycles of a signal, counted and compared while it is heard."""

import math
from typing import NamedTuple

from hydroservo.core import ops

ALIKE = 0.22  # largest change of period and of rms between regular cycles
FEWEST = 3.0  # regular cycles that make a tone
COVERED = 0.5  # share of the time that they must cover
STEADY = 1.75  # largest mean of their powers' squares, over the square of the mean; 2 for narrow noise
GROWING = 0.04  # from cycle to cycle, which explains unlike powers
SHRINKING = 0.03  # from cycle to cycle, by which an oscillation dies out
HYSTERESIS = 0.05  # of its range, by which a signal has reversed


class Tone(NamedTuple):
    """The regular cycles of a band, taken together."""

    size: float  # amplitude in the band [V]; 0 where there is none
    command: float  # amplitude of the command [V]
    error: float  # amplitude of the error
    frequency: float  # [Hz]
    growth: float  # change of the amplitude from a cycle to the next, a share of it


class ReversalsState(NamedTuple):
    """How often a signal reverses by more than a share of its range."""

    low: float
    high: float
    turn: float  # the extreme since the last reversal
    direction: float  # 1 upwards, -1 downwards
    turns: float
    first: float  # when the first was [s]
    last: float

    def step(self, value: float, begins: bool, t: float) -> "ReversalsState":
        low = ops.where(begins, value, ops.minimum(self.low, value))
        high = ops.where(begins, value, ops.maximum(self.high, value))
        turn = ops.where(self.direction > 0.0, ops.maximum(self.turn, value), ops.minimum(self.turn, value))
        turn = ops.where(begins, value, turn)
        reversed_ = (turn - value) * self.direction > HYSTERESIS * (high - low)
        first = ops.where(self.turns == 0.0, t, self.first)
        return ReversalsState(
            low=low,
            high=high,
            turn=ops.where(reversed_, value, turn),
            direction=ops.where(reversed_, -self.direction, self.direction),
            turns=self.turns + ops.where(reversed_, 1.0, 0.0),
            first=ops.where(reversed_, first, self.first),
            last=ops.where(reversed_, t, self.last),
        )

    def frequency(self) -> float:
        """Of the signal [Hz]; 0 where it has turned fewer than twice."""
        return 0.5 * (self.turns - 1.0) / (self.last - self.first) if self.turns > 1.5 else 0.0

    def explains(self, frequency: float) -> bool:
        """Whether a frequency is the signal's own, slower, or a low multiple of it."""
        own = self.frequency()
        if own == 0.0:
            return False
        ratio = frequency / own
        return ratio < 1.3 or (ratio < 6.0 and abs(ratio - math.floor(ratio + 0.5)) < 0.05)


class BandState(NamedTuple):
    """A band of the command, its cycle under way, the one before, and the regular ones of the end."""

    smooth: float  # the filter behind which slower bands are
    passed: float  # what goes on to the next band
    value: float  # of the band
    time: float  # the cycle under way: its length [s],
    samples: float
    u: float  # and sums over its samples
    uu: float
    e: float
    ee: float
    squares: float
    period: float  # the cycle before [s]
    size: float  # mean square in the band
    mean_u: float
    mean_e: float
    regular: float  # cycles of the end that resemble their predecessors,
    regular_time: float  # their time [s], and sums over them
    regular_uu: float
    regular_ee: float
    regular_squares: float
    regular_fourths: float
    regular_growth: float
    regular_late: float  # growth, the first cycle once, the second twice, and so on

    def step(
        self, entering: float, pole: float, begins: bool, u: float, e: float, dt: float, counts: bool
    ) -> "BandState":
        """Hear a sample.

        Args:
            entering: what faster bands have passed on [V].
            pole: of the two filters, the share of the way that they go in a sample.
            begins: whether this is the first sample.
            u: the command [V].
            e: the error.
            dt: time from the last sample [s].
            counts: whether cycles that end here lie in the end of the run.
        """
        smooth = ops.where(begins, entering, self.smooth + pole * (entering - self.smooth))
        passed = ops.where(begins, entering, self.passed + pole * (smooth - self.passed))
        value = entering - passed
        ends = value > 0.0 and self.value <= 0.0
        share = 1.0 / ops.maximum(self.samples, 1.0)
        size, mean_u, mean_e = share * self.squares, share * self.u, share * self.e
        longer, larger = ops.maximum(self.time, self.period), ops.maximum(size, self.size)
        unlike = ALIKE + 0.5 * dt / ops.maximum(longer, dt)  # and half a sample more, for it ends at one
        alike = ops.absolute(self.time - self.period) <= unlike * longer
        same = ops.minimum(size, self.size) >= (1.0 - unlike) * (1.0 - unlike) * larger
        regular = ends and alike and same and counts
        trend_u, trend_e = mean_u - self.mean_u, mean_e - self.mean_e
        own_uu = share * self.uu - mean_u * mean_u - trend_u * trend_u / 12.0
        own_ee = share * self.ee - mean_e * mean_e - trend_e * trend_e / 12.0
        growth = (size - self.size) / ops.maximum(size + self.size, 1e-300)
        kept = ops.where(ends, 0.0, 1.0)
        taken = ops.where(regular, 1.0, 0.0)
        return BandState(
            smooth=smooth,
            passed=passed,
            value=value,
            time=kept * self.time + dt,
            samples=kept * self.samples + 1.0,
            u=kept * self.u + u,
            uu=kept * self.uu + u * u,
            e=kept * self.e + e,
            ee=kept * self.ee + e * e,
            squares=kept * self.squares + value * value,
            period=ops.where(ends, self.time, self.period),
            size=ops.where(ends, size, self.size),
            mean_u=ops.where(ends, mean_u, self.mean_u),
            mean_e=ops.where(ends, mean_e, self.mean_e),
            regular=self.regular + taken,
            regular_time=self.regular_time + ops.where(regular, self.time, 0.0),
            regular_uu=self.regular_uu + ops.where(regular, ops.maximum(own_uu, 0.0), 0.0),
            regular_ee=self.regular_ee + ops.where(regular, ops.maximum(own_ee, 0.0), 0.0),
            regular_squares=self.regular_squares + ops.where(regular, size, 0.0),
            regular_fourths=self.regular_fourths + ops.where(regular, size * size, 0.0),
            regular_growth=self.regular_growth + ops.where(regular, growth, 0.0),
            regular_late=self.regular_late + ops.where(regular, (self.regular + 1.0) * growth, 0.0),
        )

    def tone(self, heard: float) -> Tone:
        """The tone of the band.

        Args:
            heard: length of the end that has been heard [s].
        """
        count = self.regular
        if not (count >= FEWEST and self.regular_time >= COVERED * heard):
            return Tone(0.0, 0.0, 0.0, math.nan, math.nan)
        growth, late = self.regular_growth / count, 2.0 * self.regular_late / (count * (count + 1.0))
        if growth < GROWING and self.regular_fourths * count > STEADY * self.regular_squares**2:
            return Tone(0.0, 0.0, 0.0, math.nan, math.nan)
        return Tone(
            size=math.sqrt(2.0 * self.regular_squares / count),
            command=math.sqrt(2.0 * self.regular_uu / count),
            error=math.sqrt(2.0 * self.regular_ee / count),
            frequency=count / self.regular_time,
            growth=late if growth <= -SHRINKING < late else growth,
        )


def band_at_rest() -> BandState:
    """A band that has heard nothing."""
    return BandState(*[0.0] * len(BandState._fields))


def no_reversals() -> ReversalsState:
    """A signal that has not been heard."""
    return ReversalsState(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
