"""A log as it is understood: evenly sampled stretches, without what is no measurement."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import ScenarioError
from hydroservo.core.formatting import MINUS, counted, quantity
from hydroservo.identification.log import (
    COMMAND,
    EXTERNAL_FORCE,
    FEWEST,
    INPUTS,
    OUTPUTS,
    REFERENCE,
    SIGNALS,
    SignalLog,
)

SIGMAS = 8.0  # of the noise that a spike stands out by
SHARE = 0.02  # and of the signal's range
RETURNED = 0.5  # of its height that the signal may have moved on from before to after it
TO_DEVIATION = 1.4826  # from the median of absolute deviations, for normal noise
RANGE = (1.0, 99.0)  # per cent of the samples, between which a signal's range is taken
FEWEST_SAMPLES = 8  # samples, of fewer of which none stands out
GRID = 1e-3  # of a step of resolution, by which values may lie beside it

Samples = NDArray[np.float64]
JITTER = 0.02  # of a period, by which instants may lie beside an even grid
MISSING = 1.5  # periods: a longer interval lacks samples
NEAR = 0.9  # of a period, within which a sample must lie for one on the grid to follow from it
DRIVING = (*INPUTS, REFERENCE)
NAMED = 5  # columns, of more that are not used
SHORTEST, LONGEST = 1e-6, 10.0  # s between samples, beyond which the unit of time is asked for
FINEST = 10  # parts of the time between two commands, on whose grid other signals are placed
SHARED = 0.9  # of all instants: a command with fewer has instants of its own
LONGEST_BRIDGE = 5  # samples that may lack in a row; beyond that, a new stretch begins


def spikes_in(values: Samples) -> NDArray[np.bool_]:
    """The samples that stand out alone, or two in a row: a jump away, and back.

    A sample is one if it lies farther from the mean of the samples around it (one and three beside) than
    eight deviations of that difference over the whole signal and than 2 % of the signal's range, while the
    signal itself moves by less than half of that from before to after it.

    Source: the difference to a local mean, with a median as measure, as in Hampel's identifier: Pearson,
    IEEE Trans. Control Systems Technology 10, 2002, doi:10.1109/87.974338.
    Fails to see three in a row, and to know a real pulse of one sample from a spike.
    """
    found = np.zeros(values.size, dtype=bool)
    there = np.isfinite(values)
    found[there] = spikes_in_full(values[there])
    return found


def spikes_in_full(values: Samples) -> NDArray[np.bool_]:
    """As :func:`spikes_in`, of samples all of which are there."""
    found = np.zeros(values.size, dtype=bool)
    if values.size < FEWEST_SAMPLES:
        return found
    span = float(np.diff(np.percentile(values, RANGE)).item())
    for before, after in ((1, 1), (1, 2), (2, 1)):
        middle = values[before:-after]
        left, right = values[: -before - after], values[before + after :]
        apart = middle - 0.5 * (left + right)
        deviation = TO_DEVIATION * np.median(np.abs(apart - np.median(apart)))
        out = np.abs(apart) > max(SIGMAS * deviation, SHARE * span)
        found[before:-after] |= out & (np.abs(right - left) < RETURNED * np.abs(apart))
    return found


def noise_of(values: Samples) -> float:
    """The standard deviation of white noise on a smooth signal, in its unit.

    It is taken from third differences, which a smooth signal leaves small, and is at least that of the
    signal's own resolution.
    """
    differences = np.diff(values[np.isfinite(values)], n=3)
    deviation = TO_DEVIATION * float(np.median(np.abs(differences))) / np.sqrt(20.0)
    return float(max(deviation, resolution_of(values) / np.sqrt(12.0)))


def resolution_of(values: Samples) -> float:
    """The step in which a signal is quantised, in its unit; 0 if it is not."""
    levels = np.unique(values[np.isfinite(values)])
    if levels.size < 3 or levels.size > values.size // 2:
        return 0.0
    steps = np.diff(levels)
    step = float(steps[steps > GRID * steps.max()].min())
    return step if np.abs(steps / step - np.round(steps / step)).max() < GRID * levels.size else 0.0


class Segment(NamedTuple):
    """An evenly sampled stretch of a log."""

    log: int  # the number of its log, from 0 on
    start: float  # its first instant, on the log's clock [s]
    period: float  # between samples [s]
    # the command, the external force and the demand, if they were recorded, shape (n,)
    inputs: Mapping[str, Samples]
    # by name, shape (n,); nan where nothing was measured or what was is no measurement
    measured: Mapping[str, Samples]
    interpolated: bool = False  # whether samples were moved onto the grid, so that noise is in two of them

    @property
    def samples(self) -> int:
        """How many."""
        return next(one.size for one in (*self.inputs.values(), *self.measured.values()))

    @property
    def time(self) -> Samples:
        """Instants on the log's clock [s]."""
        return self.start + self.period * np.arange(self.samples, dtype=np.float64)


class UnderstoodLog(NamedTuple):
    """What is taken of a log."""

    log: SignalLog  # the log
    segments: Sequence[Segment]  # at least one
    spikes: Mapping[str, NDArray[np.bool_]]  # which samples of each signal were left out as spikes, by name
    remarks: Sequence[str]  # what was found and how it was handled, in a line each


def understand_log(log: SignalLog, number: int = 0) -> UnderstoodLog:
    """A log as evenly sampled stretches, and a line for everything that is not as it was recorded.

    Columns that never change are left out. Spikes count for nothing; those of an input, which a law may well
    have made, are played as they are. Where a few samples lack, so are the inputs; where more
    do, a new stretch begins. Instants beside an even grid are moved onto it by linear interpolation.
    """
    remarks = [f"columns that are not used: {some_names(log.unused)}"] if log.unused else []
    gridded = on_one_clock(log)
    if gridded is not None:
        remarks.append("its signals have instants of their own: each counts where it was measured")
        log = gridded
    rows = dict(changing_signals(log, remarks))
    spikes = {signal: spikes_in(values) for signal, values in rows.items()}
    clean = {name: np.where(spikes[name] & (name in OUTPUTS), np.nan, one) for name, one in rows.items()}
    remarks += list(sample_remarks(rows, spikes, missing=gridded is None))
    period = float(np.median(np.diff(log.time)))
    if not SHORTEST < period < LONGEST:
        remarks.append(f"has a sample every {quantity(period, 's')}: is the unit of its time right?")
    gaps = np.flatnonzero(np.diff(log.time) > (LONGEST_BRIDGE + MISSING) * period) + 1
    parts = [slice(first, last) for first, last in pairwise([0, *gaps.tolist(), log.time.size])]
    if len(parts) > 1:
        remarks.append(f"gaps longer than {LONGEST_BRIDGE} samples split it into {len(parts)} stretches")
    segments = [even_segment(number, log.time[part], period, part, clean, remarks) for part in parts]
    kept = [one for one in segments if one.samples >= FEWEST]
    if len(kept) < len(segments):
        remarks.append(f"stretches of fewer than {FEWEST} samples are left out: {len(segments) - len(kept)}")
    if not kept:
        raise ScenarioError(log.name, "", f"has no stretch of {FEWEST} samples without a gap")
    return UnderstoodLog(log, kept, spikes, list(dict.fromkeys(remarks)))


def on_one_clock(log: SignalLog) -> SignalLog | None:
    """A log whose signals have instants of their own, on one grid; None where they share theirs.

    The grid divides the time between two samples of the signal that has most of them by the least number, at
    most FINEST, for which all samples lie on it or nearly. A command is held from one to the next, and a
    sample of another signal goes to the nearest instant; where nothing was recorded, there is no grid.
    """
    own = {name: np.flatnonzero(np.isfinite(values)) for name, values in log.signals.items()}
    places = own.get(COMMAND, np.arange(0))
    if not FEWEST <= places.size < SHARED * log.time.size:
        return None
    commanded = log.time[places]
    usual = min(float(np.median(np.diff(log.time[one]))) for one in own.values() if one.size >= FEWEST)
    after = log.time - commanded[0]
    for parts in range(1, FINEST + 1):
        period = usual / parts
        if np.abs(after / period - np.round(after / period)).max() <= JITTER:
            break
    count = round(float(after[-1]) / period) + 1
    time = commanded[0] + period * np.arange(count)
    signals = {name: np.full(count, np.nan) for name in log.signals}
    held = np.searchsorted(commanded, time + JITTER * period, side="right") - 1
    signals[COMMAND] = log.signals[COMMAND][places][held]
    for name in signals.keys() - {COMMAND}:
        nearest = np.round(after[own[name]] / period).astype(int)
        inside = nearest >= 0
        signals[name][nearest[inside]] = log.signals[name][own[name][inside]]
    last = np.searchsorted(log.time, time + JITTER * period, side="right") - 1
    wide = np.append(np.diff(log.time), usual) > (LONGEST_BRIDGE + MISSING) * usual
    there = ~wide[last] | (time - log.time[last] < period)
    return log._replace(time=time[there], signals={name: one[there] for name, one in signals.items()})


def changing_signals(log: SignalLog, remarks: list[str]) -> Iterator[tuple[str, Samples]]:
    """The signals that change, and the command in any case."""
    known = {name: values[np.isfinite(values)] for name, values in log.signals.items()}
    constant = [name for name, values in known.items() if not values.size or not np.ptp(values)]
    if not set(log.signals) & set(OUTPUTS) - set(constant):
        names = ", ".join(name for name in constant if name in OUTPUTS)
        raise ScenarioError(
            log.name, names, "never changes, and nothing else is measured: it says nothing about the machine"
        )
    for name, values in log.signals.items():
        if name in constant and name != EXTERNAL_FORCE:
            found = "never changes" if known[name].size else "has no samples"
            left = "nothing excites the machine" if name in DRIVING else "it says nothing and is left out"
            remarks.append(f"{name} {found}: {left}")
        if name not in constant or name in DRIVING:
            yield name, values


def some_names(names: Sequence[str]) -> str:
    """The first of many names, and how many more there are."""
    more = len(names) - NAMED
    return ", ".join(names) if more <= 1 else f"{', '.join(names[:NAMED])} and {more} more"


def sample_remarks(
    rows: Mapping[str, Samples], spikes: Mapping[str, NDArray[np.bool_]], missing: bool
) -> Iterator[str]:
    """What there is to say of each signal's samples."""
    for name, values in rows.items():
        absent, peaks = int(np.isnan(values).sum()), int(spikes[name].sum())
        driving = name in DRIVING
        if absent and missing:
            handled = "; those around are joined" if driving else ", and count for nothing"
            yield f"{name}: {counted(absent, 'sample')} missing{handled}"
        if peaks:
            handled = "; they are played as recorded" if driving else ", and count for nothing"
            yield f"{name}: {counted(peaks, 'sample')} out of line{handled}"
        step = resolution_of(values)
        if step and name in OUTPUTS:
            yield f"{name} is quantised in {quantity(step, SIGNALS[name].unit)}".replace(MINUS, "-")


def even_segment(
    number: int, time: Samples, usual: float, part: slice, rows: Mapping[str, Samples], remarks: list[str]
) -> Segment:
    """One stretch on an even grid."""
    ticks = np.append(0.0, np.cumsum(np.round(np.diff(time) / usual)))
    count = int(ticks[-1]) + 1
    period = (time[-1] - time[0]) / max(count - 1, 1)
    beside = np.abs(time - time[0] - period * ticks).max() > JITTER * period
    places = (time - time[0]) / period if beside else ticks
    if beside:
        remarks.append(f"its instants are uneven: it is interpolated onto a grid of {period * 1e3:.6g} ms")
    lacking = count - time.size
    if lacking > 0 and not beside:
        remarks.append(f"{lacking} samples lack: inputs are joined over them, and nothing counts there")
    whole = np.arange(count, dtype=np.float64)
    own = {name: values[part] for name, values in rows.items()}
    inputs = {
        name: join_input(whole, places if name == EXTERNAL_FORCE else ticks, own[name])
        for name in DRIVING
        if name in own
    }
    measured = {name: own[name] for name in OUTPUTS if name in own}
    on_grid = {name: place_samples(whole, places, values, beside) for name, values in measured.items()}
    return Segment(number, float(time[0]), period, inputs, on_grid, bool(beside))


def join_input(whole: Samples, places: Samples, values: Samples) -> Samples:
    """An input at each sample: held from the sample before, or between neighbours where one is missing."""
    there = np.isfinite(values)
    if not there.any():
        return np.zeros(whole.size)
    bridged: Samples = np.interp(whole, places[there], values[there])
    return bridged


def place_samples(whole: Samples, places: Samples, values: Samples, beside: bool) -> Samples:
    """What was measured at each sample; nan where nothing was."""
    if beside:
        there = np.isfinite(values)
        return interpolate_samples(whole, places[there], values[there])
    found = np.full(whole.size, np.nan)
    found[places.astype(int)] = values
    return found


def interpolate_samples(whole: Samples, places: Samples, values: Samples) -> Samples:
    """Samples moved onto a grid by linear interpolation; nan where none lies near."""
    if places.size < 2:
        return np.full(whole.size, np.nan)
    after = np.clip(np.searchsorted(places, whole), 1, places.size - 1)
    near = np.minimum(np.abs(whole - places[after - 1]), np.abs(whole - places[after]))
    return np.where(near <= NEAR, np.interp(whole, places, values), np.nan)
