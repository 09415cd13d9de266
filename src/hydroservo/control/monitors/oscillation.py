"""Oscillation that neither dies out nor comes from the demand, the load or noise."""

import math
from typing import Annotated, NamedTuple

from hydroservo.control.monitors.cycles import (
    FEWEST,
    SHRINKING,
    BandState,
    ReversalsState,
    Tone,
    band_at_rest,
    no_reversals,
)
from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, at_samples, role
from hydroservo.core.sources import CHOSEN

END = 0.3  # of the duration, at its end, in which an oscillation must last
FASTEST = 0.125  # corner of the fastest band, a share of the sampling rate
LEAKING = 0.1  # share of a faster band's power that slower ones may hear
SLOWEST = 5.0  # corner below the slowest band, in cycles of the whole run


class OscillationState(NamedTuple):
    """The bands of the command, the cycles of demand and load, and the slow rest."""

    started: float  # 1 after the first sample
    time: float  # of the end that has been seen [s]
    fast: BandState
    middle: BandState
    slow: BandState
    lowest: float  # extremes of what is slower than every band, since demand and load last moved [V]
    highest: float
    rest: float  # how long ago that was, within the end [s]
    last_demand: float
    last_force: float
    demand: ReversalsState
    load: ReversalsState

    def loudest(self, least: float, most: float) -> Tone:
        """The loudest tone of the bands whose growth lies between two numbers."""
        fast, middle = self.own(self.fast, least, most), self.own(self.middle, least, most)
        slow = self.own(self.slow, least, most)
        faster = fast if fast.size >= middle.size else middle
        return faster if faster.size >= slow.size else slow

    def own(self, band: BandState, least: float, most: float) -> Tone:
        """The tone of a band, silent where demand or load explain it, or it grows otherwise."""
        tone = band.tone(self.time)
        explained = self.demand.explains(tone.frequency) or self.load.explains(tone.frequency)
        silent = explained or not least < tone.growth <= most
        return Tone(0.0 if silent else tone.size, tone.command, tone.error, tone.frequency, tone.growth)

    def undecided(self, threshold: float) -> bool:
        """Whether something moves at the end that could be an oscillation too slow for the run."""
        swing = self.highest - self.lowest  # of a sine of amplitude A: 2 A, its mean square A^2/2
        louder = max(LEAKING * max(self.fast.size, self.middle.size), 0.5 * threshold * threshold)
        drifts = swing * swing > 8.0 * max(louder, self.slow.size)
        few = self.slow.regular < 2.0 * FEWEST and self.slow.size > louder
        repeats = self.demand.frequency() > 0.0 or self.load.frequency() > 0.0
        moves = self.rest > 0.0 and swing >= 0.5 * threshold  # what was before may be the answer to a step
        return not self.time > 0.0 or (moves and not repeats and (drifts or few))


class OscillationValues(NamedTuple):
    """The strongest oscillation; 0 where there is none, nan where the run is too short to tell."""

    oscillation_amplitude: Annotated[
        float, Field("y", "amplitude (sqrt(2) rms) of the {y} in a sustained oscillation")
    ]
    oscillation_command: Annotated[
        float, Field("V", "amplitude (sqrt(2) rms) of the command in a sustained oscillation")
    ]
    oscillation_frequency: Annotated[
        float, Field("Hz", "frequency of an oscillation, sustained or dying out")
    ]
    oscillation_growth: Annotated[
        float, Field("", "growth of an oscillation from cycle to cycle at the end of the run")
    ]


@role(Monitor)
@at_samples
class Oscillation(NamedTuple):
    """Sustained oscillation of the command and the controlled signal, over the last 30 % of the run.

    The command is split into three bands. In each, the cycles between its rises through 0 are compared:
    one is regular where its period and its rms are within 22 % and half a sample of the last one's. An
    oscillation is three regular cycles or more that cover half of the time, are of steady power or grow, do
    not shrink by 3 % each, on average or in an average in which later cycles weigh more, and have neither the
    frequency of demand or load nor a low multiple of it. Ringing shrinks, noise is irregular, and what
    answers the demand has its frequency. Amplitudes are sqrt(2) of the rms over these cycles, less a trend.

    All are nan where the run is too short to tell: where demand and load rest at its end and the command
    moves all the same, for fewer than three cycles.

    Source: chosen here, against runs ten times as long.
    Fails for oscillations of fewer than three cycles in the end, which a longer run shows; for those locked
    to a low multiple of the demand's frequency; and for demands without a period that are as fast as the
    oscillation.
    """

    threshold: Annotated[
        float, Field("V", "amplitude of the command from which it counts", CHOSEN, above=0)
    ] = 0.01

    def init(self) -> OscillationState:
        band, reversals = band_at_rest(), no_reversals()
        return OscillationState(0.0, 0.0, band, band, band, 0.0, 0.0, 0.0, 0.0, 0.0, reversals, reversals)

    def step(self, m: OscillationState, loop: Block, s: Block, t: float, dt: float) -> OscillationState:
        duration, u = loop.simulation.duration, s.controller.u
        e = s.reference.value - s.controlled.value
        counts = t >= (1.0 - END) * duration
        late = t >= (1.0 - 0.5 * END) * duration
        begins = m.started == 0.0
        share = ops.minimum(SLOWEST * loop.simulation.period / (FASTEST * duration), 1.0)
        w1 = 2.0 * math.pi * FASTEST
        w2 = ops.sqrt(share) * w1
        w3 = share * w1
        fast = m.fast.step(u, w1 / (1.0 + w1), begins, u, e, dt, counts)
        middle = m.middle.step(fast.passed, w2 / (1.0 + w2), begins, u, e, dt, counts)
        slow = m.slow.step(middle.passed, w3 / (1.0 + w3), begins, u, e, dt, counts)
        demand, force, rest = s.reference.value, s.load.force, slow.passed
        moves = begins or demand != m.last_demand or force != m.last_force or not late
        return OscillationState(
            started=1.0,
            time=m.time + ops.where(counts, dt, 0.0),
            fast=fast,
            middle=middle,
            slow=slow,
            lowest=ops.where(moves, rest, ops.minimum(m.lowest, rest)),
            highest=ops.where(moves, rest, ops.maximum(m.highest, rest)),
            rest=ops.where(moves, 0.0, m.rest + dt),
            last_demand=demand,
            last_force=force,
            demand=m.demand.step(demand, begins, t),
            load=m.load.step(force, begins, t),
        )

    def values(self, m: OscillationState) -> OscillationValues:
        sustained = m.loudest(-SHRINKING, math.inf)
        if sustained.size >= self.threshold:
            return OscillationValues(
                sustained.error, sustained.command, sustained.frequency, sustained.growth
            )
        if m.undecided(self.threshold):
            return OscillationValues(math.nan, math.nan, math.nan, math.nan)
        ringing = m.loudest(-math.inf, -SHRINKING)
        if ringing.size >= self.threshold:
            return OscillationValues(0.0, 0.0, ringing.frequency, ringing.growth)
        return OscillationValues(0.0, 0.0, math.nan, math.nan)
