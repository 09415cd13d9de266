"""The line of a slow sweep, and what of the way between both directions is lag and what hysteresis."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.audits.facts import LoopFacts
from hydroservo.block import replace
from hydroservo.errors import ScenarioError
from hydroservo.formatting import MINUS, quantity
from hydroservo.identification.maps.result import Interval
from hydroservo.identification.maps.sweeps import FEWEST, Pass
from hydroservo.identification.regression import Regression, regression
from hydroservo.loop import Loop

NOTED = 0.1  # of the width, from which on it is said what of it is lag
MOST_LAG = 0.5  # of the width, beyond which lag leaves no hysteresis
UNSURE = 0.5  # of the scenario's lag, by which that of the machine may differ
VARIED = 0.1  # of the mean rate, by which rates deviate where they tell a lag

Samples = NDArray[np.float64]


class Line(NamedTuple):
    """``y = k (u - u_0 -+ h/2 -+ T r)``: the upper signs as the command rises, r the size of its rate.

    Attributes:
        found: the regression on u, a constant for each direction, and the signed rate less its mean where
            rates differ.
        rate: the mean size of the command's rate [V/s].
    """

    found: Regression
    rate: float

    @property
    def tells_lag(self) -> bool:
        """Whether the rates differ enough to tell a lag from a hysteresis."""
        return self.found.values.size > 3

    def slope(self) -> tuple[float, float]:
        """k, and half its interval."""
        return float(self.found.values[0]), self.found.half(self.weights(1.0, 0.0, 0.0))

    def null(self) -> tuple[float, float]:
        """u_0, in the mean of both directions, and half its interval [V]."""
        return self.ratio(self.weights(0.0, -0.5, -0.5))

    def apart(self) -> tuple[float, float]:
        """How far both directions lie apart at the mean rate, h + 2 T r, and half the interval [V]."""
        return self.ratio(self.weights(0.0, -1.0, 1.0))

    def lag(self) -> tuple[float, float]:
        """T, where rates tell it, and half its interval [s]."""
        return self.ratio(self.weights(0.0, 0.0, 0.0, -1.0))

    def hysteresis(self) -> tuple[float, float]:
        """h, where rates tell it, and half its interval [V]."""
        return self.ratio(self.weights(0.0, -1.0, 1.0, 2.0 * self.rate))

    def weights(self, *shares: float) -> Samples:
        """The weights of a sum of coefficients, 0 for those not named."""
        found = np.zeros(self.found.values.size)
        found[: len(shares)] = shares[: found.size]
        return found

    def ratio(self, above: Samples) -> tuple[float, float]:
        """A sum of coefficients over k, and half its interval."""
        return self.found.ratio(above, self.weights(1.0, 0.0, 0.0))


def line_through(sweeps: Sequence[Pass]) -> Line | None:
    """The line of samples of both directions; None where they are too few, or none rises."""
    counts = [sum(one.command.size for one in sweeps if one.rising == way) for way in (True, False)]
    if min(counts) < FEWEST:
        return None
    rates = np.concatenate([one.rate for one in sweeps])
    mean = float(rates.mean())
    varied = bool(rates.std() > VARIED * mean)
    parts = []
    for one in sweeps:
        ways = np.array([one.rising, not one.rising], dtype=np.float64)
        faster = (1.0 if one.rising else -1.0) * (one.rate - mean)
        columns = [one.command, *np.outer(ways, np.ones(one.command.size)), *([faster] if varied else [])]
        parts.append((np.stack(columns, axis=1), one.answer))
    found = regression(parts)
    line = None if found is None else Line(found, mean)
    return line if line is not None and line.slope()[0] > line.slope()[1] else None


class Loops(NamedTuple):
    """The loop between both directions of a sweep, in the mean of its lines.

    Attributes:
        apart: its width, and half the interval [V].
        rate: the mean size of the command's rate [V/s].
        lag: by which the answer is behind the command [s].
        hysteresis: what is left of the width without the lag, and half the interval [V].
        measured: whether the lag is that of the log, and not that of the scenario.
        one_rate: whether the log cannot tell a lag.
    """

    apart: tuple[float, float]
    rate: float
    lag: float
    hysteresis: tuple[float, float]
    measured: bool
    one_rate: bool

    @property
    def made(self) -> float:
        """What the lag makes of the width [V]."""
        return 2.0 * self.lag * self.rate


def loops_of(lines: Sequence[Line], known: float, static: bool = True) -> Loops:
    """The loop, with the lag of the log where its rates tell it better than the scenario does.

    Args:
        lines: of each direction of flow.
        known: lag by the scenario [s].
        static: whether nothing but a lag and a hysteresis lays directions apart.
    """
    apart, rate = mean_of(line.apart() for line in lines), float(np.mean([line.rate for line in lines]))
    varied = all(line.tells_lag for line in lines)
    if varied and static:
        lag, half = mean_of(line.lag() for line in lines)
        if half < UNSURE * known or abs(lag - known) > half:
            return Loops(apart, rate, lag, mean_of(line.hysteresis() for line in lines), True, False)
    made = 2.0 * known * rate
    left = apart[0] - made, float(np.hypot(apart[1], UNSURE * made))
    return Loops(apart, rate, known, left, False, not varied)


def mean_of(numbers: Iterator[tuple[float, float]]) -> tuple[float, float]:
    """The mean of independent numbers with half their intervals."""
    values, halves = np.array([*numbers]).T
    return float(values.mean()), float(np.linalg.norm(halves)) / values.size


def lag_of(loop: Loop | None) -> float:
    """The time by which a scenario's valve is behind its command [s]; 0 where none is known.

    A command that is held from sample to sample comes half a period late on the mean, and by its delay. A
    sweep goes one way, so that the play of a hysteresis adds none.
    """
    if loop is None:
        return 0.0
    if hasattr(loop.valve, "hysteresis"):
        loop = replace(loop, {"valve.hysteresis": 0.0})
    facts = LoopFacts(loop, loop, None, None)
    lag = facts.valve_lag + facts.delay + 0.5 * float(loop.simulation.period)
    return lag if np.isfinite(lag) else 0.0


def hysteresis_of(loops: Loops) -> tuple[dict[str, Interval], dict[str, str]]:
    """The hysteresis, or why there is none."""
    width = Interval.around(*loops.hysteresis, "V", "full width of the hysteresis")
    if width.high < 0.0 or loops.made > MOST_LAG * abs(loops.apart[0]):
        shown, made = shown_in_volts(loops.apart[0], loops.made)
        lag = quantity(loops.lag, "s")
        return {}, {
            "hysteresis": f"of {shown} between both directions a lag of {lag} makes {made}; sweep slower"
        }
    return {"hysteresis": width.at_least_0()}, {}


def too_fast(loops: Loops, widest: float, span: float) -> str:
    """Why a sweep is too fast for what it says of null; empty where it is not."""
    if loops.made <= 0.5 * widest * span:
        return ""
    made, rate = shown_in_volts(loops.made, loops.rate)
    lag = quantity(loops.lag, "s")
    return f"the sweep is too fast: at {rate}/s a lag of {lag} moves both directions {made} apart"


def check_slow(loops: Loops, widest: float, span: float, name: str) -> Iterator[str]:
    """What there is to say of how fast the command was swept."""
    shown, made, rate = shown_in_volts(loops.apart[0], loops.made, loops.rate)
    whose = "the log" if loops.measured else "the scenario's valve and sampling"
    part = f"; the lag of {whose}, {quantity(loops.lag, 's')}, makes {made} of it" if loops.lag else ""
    if abs(loops.apart[0]) > widest * span:
        share = 100.0 * abs(loops.apart[0]) / span
        problem = (
            f"rises and falls {shown} apart, {share:.2g} % of its span: the sweep is too fast at {rate}/s"
            f"{part}; at most {100.0 * widest:.0f} % are a static map"
        )
        raise ScenarioError(name, "command", problem)
    if abs(loops.made) > NOTED * abs(loops.apart[0]):
        yield f"both directions lie {shown} apart{part}, which is taken off; a slower sweep shows it better"
    if loops.one_rate and loops.lag:
        yield (
            "the command has one rate, which cannot tell lag from hysteresis: the lag is the scenario's; "
            "add a log at another rate"
        )


def shown_in_volts(*values: float) -> list[str]:
    """Numbers with their unit."""
    return [quantity(one, "V").replace(MINUS, "-") for one in values]
