"""Whether what a loop plays from records is there while it runs."""

import hashlib
import math
from collections.abc import Iterator

import numpy as np

from hydroservo.control import references
from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, is_block
from hydroservo.core.errors import ParameterError, short
from hydroservo.core.time_series import TimeSeries
from hydroservo.machine import loads

SAMPLED = 30  # samples; a record of fewer is taken as drawn by hand
HOLE = 10.0  # times the step that nine in ten steps of a sampled record do not exceed
FEW = 100  # samples; a run that sees fewer of a much longer record may have another unit of time
SHORT_STEP, LONG_STEP = 1e-4, 0.05  # s; of logs of servo axes, between which the unit of time is not doubted
END = 0.05  # of a run, that may be held without a word where the steps of the record are as long
# By the power of 1000 by which a record is longer than its run:
MISREAD = {-3: "s read as ns", -2: "s read as us", -1: "s read as ms"}
MISREAD |= {1: "ms read as s", 2: "us read as s", 3: "ns read as s"}

record_sources: dict[bytes, str] = {}  # by content: a block holds numbers only


def check_records(loop: Loop) -> list[str]:
    """What a run makes up because its records do not say it, in a line for each.

    Looked at are the ``series`` of recorded demands and loads, wherever they are in the loop, but for those
    that are 0 everywhere. A line says that

    - a record starts after 0 or ends before the run, so that its first or last sample is held; for one median
      step, or a twentieth of the run if that is less, this is not said;
    - it has holes: steps ten times as long as nine in ten of its steps are at most. A record of fewer than 30
      samples is drawn by hand, and has none;
    - its instants may be in another unit. They may if there are 30 samples or more, and either they last less
      than 1/31.6 of the run (the root of 1000) in steps of 0.1 ms or less, or more than 31.6 runs in steps of
      50 ms or more with fewer than 100 samples seen.

    Fails to see records that a block of one's own reads without these two, and a wrong unit of time with
    which a record is about as long as the run.
    """
    return [
        line
        for path, series in played_records(loop)
        for line in record_lines(path, series, loop.simulation.duration)
    ]


def played_records(block: Block, path: str = "") -> Iterator[tuple[str, TimeSeries]]:
    """The recorded demands and loads in a block that are not 0 everywhere, with their paths."""
    if isinstance(block, (references.Recorded, loads.Recorded)) and block.series.coefficients.any():
        yield f"{path}series", block.series
    for name in block._fields:
        value = getattr(block, name)
        if is_block(value):
            yield from played_records(value, f"{path}{name}.")


def record_lines(path: str, series: TimeSeries, duration: float) -> list[str]:
    """What a run makes up for one record, in a line for each."""
    if series.knots[0] >= duration or series.knots[-1] <= 0.0:
        raise ParameterError(path, record_source(series), unseen_text(series, duration))
    found = (held_text(series, duration), misread_unit_text(series, duration), hole_text(series, duration))
    return [f"{path} = {short(record_source(series))}: {text}" for text in found if text]


def unseen_text(series: TimeSeries, duration: float) -> str:
    """Why a run sees nothing of a record, and what to do."""
    first, last = series.knots[0], series.knots[-1]
    parts = (
        f"goes from {seconds(first)} to {seconds(last)}, and the run from 0 s to {seconds(duration)}",
        f"which would see its {'first' if first >= duration else 'last'} sample alone",
        f"subtract its first instant, {seconds(first)}, from each",
    )
    other = misread_unit_text(series, duration)
    return f"{parts[0]}, {parts[1]}; {parts[2]}{other and f'; it {other}'}"


def held_text(series: TimeSeries, duration: float) -> str:
    """Which part of a run sees a held sample; empty if none does."""
    first, last = series.knots[0], series.knots[-1]
    allowed = 1.001 * min(float(np.median(np.diff(series.knots))), END * duration)  # for rounding
    parts = [
        f"starts at {seconds(first)}, and its first sample is held until then" if first > allowed else "",
        f"ends at {seconds(last)} of {seconds(duration)}, and its last sample is held from then on"
        if duration - last > allowed
        else "",
    ]
    return " and ".join(part for part in parts if part)


def misread_unit_text(series: TimeSeries, duration: float) -> str:
    """In which other unit the instants of a sampled record may be; empty if theirs may be right."""
    t = series.knots
    ratio = float(np.clip(t[-1] / duration - t[0] / duration, 1e-300, 1e300))
    power = round(math.log(ratio, 1000.0))
    step = float(np.median(np.diff(t)))
    seen = np.count_nonzero((t >= 0.0) & (t <= duration))
    doubtful = (power < 0 and step <= SHORT_STEP) or (power > 0 and step >= LONG_STEP and seen < FEW)
    if t.size < SAMPLED or power not in MISREAD or not doubtful:
        return ""
    size = "large" if power > 0 else "small"
    return (
        f"lasts {seconds(t[-1] - t[0])}, and a run of {seconds(duration)} sees {seen} of its {t.size} "
        f"samples: are its instants {1000 ** abs(power)} times too {size} ({MISREAD[power]})?"
    )


def hole_text(series: TimeSeries, duration: float) -> str:
    """The holes of a sampled record that a run sees; empty if there are none."""
    t = series.knots
    if t.size < SAMPLED:
        return ""
    steps = np.diff(t)
    usual = float(np.quantile(steps, 0.9, method="higher"))
    holes = np.flatnonzero((steps > HOLE * usual) & (t[:-1] < duration) & (t[1:] > 0.0))
    if not holes.size:
        return ""
    longest = holes[np.argmax(steps[holes])]
    count = "a hole" if holes.size == 1 else f"{holes.size} holes, the longest"
    return (
        f"has {count} of {steps[longest]:.3g} s after {seconds(t[longest])}, bridged by a smooth curve, "
        f"where nine in ten of its steps are {usual:.3g} s or less"
    )


def seconds(t: float) -> str:
    return f"{t:.12g} s"


def remember_source(series: TimeSeries, source: str) -> None:
    """Let messages of :func:`check_records` call a record by where it was read from."""
    record_sources[series_digest(series)] = source


def record_source(series: TimeSeries) -> str:
    """What a message calls a record."""
    return record_sources.get(series_digest(series), f"{series.knots.size} samples")


def series_digest(series: TimeSeries) -> bytes:
    """What the numbers of a record are known by."""
    return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in series)).digest()
