"""Slow sweeps of a command, up and down, their line, and what between directions is lag or hysteresis."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.audits.facts import LoopFacts
from hydroservo.control.loop import Loop
from hydroservo.core.block import replace
from hydroservo.core.errors import ScenarioError
from hydroservo.core.formatting import plain_quantity, quantity
from hydroservo.identification.maps.result import Interval, curve_of
from hydroservo.identification.regression import Regression, mean_with_interval, regression

if TYPE_CHECKING:
    import xarray as xr

DENSE = 50_000  # samples of a stretch that count
BINS = 60  # over the span of the command
FEWEST = 8  # samples of a pass
LEAST = 0.05  # of the span, that a pass goes
PLAY = 0.1  # of the span, after which a valve has taken up its play
RESTS = 1e-3  # of the largest rate, below which the command rests
WHOLE = 0.8  # of a range, through which a pass goes
NEIGHBOURS = 25  # samples of a mean by which others are chosen
WINDOWS = 50  # of a pass, over each of which a rate is taken

Samples = NDArray[np.float64]
NOTED = 0.1  # of the width, from which on it is said what of it is lag
MOST_LAG = 0.5  # of the width, beyond which lag leaves no hysteresis
UNSURE = 0.5  # of the scenario's lag, by which that of the machine may differ
VARIED = 0.1  # of the mean rate, by which rates deviate where they tell a lag


class Pass(NamedTuple):
    """A stretch in which the command goes one way."""

    rising: bool  # whether it rises
    rate: Samples  # the size of the command's rate [V/s], shape (n,)
    command: Samples  # [V], shape (n,)
    answer: Samples  # what was measured, shape (n,)


def passes(period: float, command: Samples, answer: Samples) -> Iterator[Pass]:
    """The passes of a stretch, without samples at which nothing was measured or the command rests.

    Until the command has gone a tenth of its span from a turn, or from its first sample, a valve with play
    may not follow yet: these samples are left out.

    The command [V] may be noisy, or rise in steps; the answer is nan where nothing was measured.
    """
    span = float(np.ptp(command))
    least = LEAST * span
    parts = [slice(first, last + 1) for first, last in pairwise(turns(command, least))]
    rates = [pass_rate(command[part], period) for part in parts]
    slowest = RESTS * max((float(rate.max()) for rate in rates), default=0.0)
    for part, rate in zip(parts, rates, strict=True):
        follows = np.abs(command[part] - command[part][0]) > PLAY * span
        there = np.isfinite(answer[part]) & (rate > slowest) & follows
        u, y = command[part][there], answer[part][there]
        if u.size >= FEWEST and np.ptp(u) > least:
            yield Pass(bool(command[part][-1] > command[part][0]), rate[there], u, y)


def turns(command: Samples, least: float) -> list[int]:
    """Where a command turns by more than so much, with its first and last sample."""
    found, extreme, way = [0], 0, 0.0
    values = command.tolist()
    for i, u in enumerate(values):
        if way == 0.0:
            way = float(np.sign(u - values[0])) if abs(u - values[0]) > least else 0.0
            extreme = i
        elif way * (u - values[extreme]) >= 0.0:
            extreme = i
        elif way * (values[extreme] - u) > least:
            found.append(extreme)
            extreme, way = i, -way
    return [*found, len(values) - 1] if values else []


def pass_rate(command: Samples, period: float) -> Samples:
    """The size of a pass's rate [V/s], of means over a fiftieth of it; 0 where it goes the other way."""
    width = max(command.size // WINDOWS, 1)
    if command.size < 2 * width + 2:
        return np.zeros(command.size)
    edges = np.pad(command, width, mode="reflect", reflect_type="odd")
    smooth = np.convolve(edges, np.full(width, 1.0 / width), mode="same")[width:-width]
    way = np.sign(command[-1] - command[0])
    return np.asarray(np.maximum(way * np.gradient(smooth, period), 0.0))


def command_span(sweeps: Sequence[Pass], name: str) -> float:
    """How far the command goes [V]."""
    ways = {one.rising for one in sweeps}
    if ways != {True, False}:
        missing = "no slow sweep" if not ways else "a sweep one way only"
        problem = f"has {missing}: the command must rise and fall over the same range"
        raise ScenarioError(name, "command", problem)
    every = np.concatenate([one.command for one in sweeps])
    return float(np.ptp(every))


def choose_samples(sweeps: Sequence[Pass], low: float, high: float) -> list[Pass]:
    """The samples at commands between which the mean answer rises from one value to another.

    Samples chosen by their own answer would be those whose noise suits the choice, and bias a line. A pass
    that goes through a part of the range alone would weigh that part more.
    """
    found = []
    for rising in {one.rising for one in sweeps}:
        command, mean = mean_answer(sweeps, rising)
        first, last = np.interp([low, high], np.maximum.accumulate(mean), command)
        for one in sweeps:
            on = (one.command >= first) & (one.command <= last)
            if one.rising == rising and on.any() and np.ptp(one.command[on]) >= WHOLE * (last - first):
                found.append(Pass(rising, one.rate[on], one.command[on], one.answer[on]))
    return found


def mean_answer(sweeps: Sequence[Pass], rising: bool) -> tuple[Samples, Samples]:
    """Means of neighbours in the command, of one direction: the command and the answer."""
    ways = [one for one in sweeps if one.rising == rising]
    command, answer = (np.concatenate(rows) for rows in zip(*(one[2:] for one in ways), strict=True))
    order = np.argsort(command, kind="stable")
    parts = np.array_split(order, max(order.size // NEIGHBOURS, 1))
    return np.array([command[one].mean() for one in parts]), np.array([answer[one].mean() for one in parts])


def swept_curve(sweeps: Sequence[Pass], name: str, unit: str, meaning: str) -> "xr.Dataset":
    """The mean answer at each command, rising and falling, with its scatter and 95 % interval.

    The command is the middle of a step, or of stairs the mean of the levels in it.

    The scatter is what is left of a straight line through the samples around a point.
    """
    every = np.concatenate([one.command for one in sweeps])
    edges = np.linspace(every.min(), every.max(), BINS + 1)
    rows: list[tuple[float, ...]] = []
    for rising in (True, False):
        for low, high in pairwise(edges.tolist()):
            inside = [
                (one.command[here], one.answer[here])
                for one in sweeps
                if one.rising == rising
                for here in [(one.command >= low) & (one.command <= high)]
                if here.sum() > 1
            ]
            if inside:
                every = np.concatenate([command for command, _ in inside])
                middle = 0.5 * (low + high) if np.unique(every).size > len(inside) else float(every.mean())
                rows.append((middle, *at_middle(inside, middle), float(rising)))
    columns = np.array(rows).T
    about = {
        "command": ("V", "command"),
        name: (unit, meaning),
        f"{name}_deviation": (unit, "standard deviation of samples"),
        f"{name}_half": (unit, "half of the 95 % interval of the mean"),
        "rising": ("", "1: the command rises, 0: it falls"),
    }
    return curve_of(dict(zip(about, columns, strict=True)), about)


def at_middle(inside: Sequence[tuple[Samples, Samples]], middle: float) -> tuple[float, float, float]:
    """The mean answer at a command, with its scatter and half its interval."""
    u, y = (np.concatenate(rows) for rows in zip(*inside, strict=True))
    slope = float(np.polyfit(u - middle, y, 1)[0]) if np.ptp(u) > 0.0 else 0.0
    return mean_with_interval([answer - slope * (command - middle) for command, answer in inside])


class SweepLine(NamedTuple):
    """``y = k (u - u_0 -+ h/2 -+ T r)``: the upper signs as the command rises, r the size of its rate."""

    # the regression on u, a constant for each direction, and the signed rate less its mean where rates differ
    found: Regression
    rate: float  # the mean size of the command's rate [V/s]

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


def line_through(sweeps: Sequence[Pass], slopes: Sequence[Samples] | None = None) -> SweepLine | None:
    """The line of samples of both directions; None where they are too few, or none rises.

    Of a bent curve, its slope at each sample multiplies the columns.
    """
    counts = [sum(one.command.size for one in sweeps if one.rising == way) for way in (True, False)]
    if min(counts) < FEWEST:
        return None
    rates = np.concatenate([one.rate for one in sweeps])
    mean = float(rates.mean())
    varied = bool(rates.std() > VARIED * mean)
    parts = []
    for one, slope in zip(sweeps, slopes or [np.ones(one.rate.size) for one in sweeps], strict=True):
        ways = np.array([one.rising, not one.rising], dtype=np.float64)
        faster = (1.0 if one.rising else -1.0) * (one.rate - mean)
        columns = [one.command, *np.outer(ways, np.ones(one.rate.size)), *([faster] if varied else [])]
        parts.append((slope[:, np.newaxis] * np.stack(columns, axis=1), one.answer))
    found = regression(parts)
    line = None if found is None else SweepLine(found, mean)
    return line if line is not None and line.slope()[0] > line.slope()[1] else None


class Loops(NamedTuple):
    """The loop between both directions of a sweep, in the mean of its lines."""

    apart: tuple[float, float]  # its width, and half the interval [V]
    rate: float  # the mean size of the command's rate [V/s]
    lag: float  # by which the answer is behind the command [s]
    hysteresis: tuple[float, float]  # what is left of the width without the lag, and half the interval [V]
    measured: bool  # whether the lag is that of the log, and not that of the scenario
    one_rate: bool  # whether the log cannot tell a lag

    @property
    def made(self) -> float:
        """What the lag makes of the width [V]."""
        return 2.0 * self.lag * self.rate


def loops_of(lines: Sequence[SweepLine], known: float, static: bool = True) -> Loops:
    """The loop, with the lag of the log where its rates tell one, and better than the scenario does.

    It is static where nothing but a lag and a hysteresis lays directions apart.
    """
    apart, rate = mean_interval(line.apart() for line in lines), float(np.mean([line.rate for line in lines]))
    varied = all(line.tells_lag for line in lines)
    if varied and static:
        lag, half = mean_interval(line.lag() for line in lines)
        if not known or (lag > 0.0 and (half < UNSURE * known or abs(lag - known) > half)):
            return Loops(
                apart, rate, max(lag, 0.0), mean_interval(line.hysteresis() for line in lines), True, False
            )
    made = 2.0 * known * rate
    left = apart[0] - made, float(np.hypot(apart[1], UNSURE * made))
    return Loops(apart, rate, known, left, False, rate > 0.0 and not varied)


def mean_interval(numbers: Iterator[tuple[float, float]]) -> tuple[float, float]:
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
    """What there is to say of how fast the command was swept; ``widest`` is a share of its span [V]."""
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
    return [plain_quantity(one, "V") for one in values]
