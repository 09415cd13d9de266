"""Frequency responses of recorded logs, beside those of a loop."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.command_scale import commands_in
from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.core.field import Field
from hydroservo.core.signals import MachineOutputs
from hydroservo.identification.log import COMMAND, OUTPUTS, REFERENCE, SIGNALS, TIME, read_log
from hydroservo.identification.segments import LONGEST_BRIDGE, Segment, understand_log
from hydroservo.runs.arguments import checked_loop
from hydroservo.runs.cautions import with_warning

if TYPE_CHECKING:
    import xarray as xr

WINDOWS = 16  # that are averaged, at least: without a relation the coherence is 1/16 then
SHORTEST = 64  # samples of a window
FIRST = 2  # of its lines that is told: the ones before it hold what a signal drifts by
LAST = 0.9  # of Nyquist's frequency
EXCITED = 1e-6  # of the largest power density of what drives, below which nothing does

Samples = NDArray[np.float64]
DRIVES = {"machine": COMMAND, "closed": REFERENCE}  # what the response of this name is by
APART = 1e-2  # of a sample period, by which that of a log may differ


class ResponseEstimate(NamedTuple):
    """A response over frequency."""

    frequency: Samples  # [Hz], where something excites
    response: NDArray[np.complex128]  # output by input, in their units
    coherence: Samples  # from 0 to 1


def welch(parts: Sequence[tuple[Samples, Samples]], period: float, name: str) -> ResponseEstimate:
    """The response of an output to an input, and their coherence, of at least sixteen windows.

    With the spectra of Hann windows that overlap by half, a straight line taken out of each::

        G = S_yu/S_uu,   gamma^2 = |S_yu|^2/(S_uu S_yy)

    The variance of G is near |G|^2 (1 - gamma^2)/(2 n gamma^2) for n windows.

    Source: Welch, IEEE Trans. Audio and Electroacoustics 15(2), 1967; Bendat, Piersol, Random Data, 2010,
    sec. 6.1 and 9.2 (the variance).
    Fails at resonances narrower than two lines of a window, which look flatter than they are; and where the
    output comes later than a tenth of a window, by that share.
    """
    size = window_for([one.size for one, _ in parts], name)
    long = [part for part in parts if part[0].size >= size]
    u, y = (
        np.concatenate([window_spectra(one, size) for one in signal]) for signal in zip(*long, strict=True)
    )
    driving, moved = np.mean(np.abs(u) ** 2, axis=0), np.mean(np.abs(y) ** 2, axis=0)
    cross = np.mean(np.conj(u) * y, axis=0)
    frequency = np.fft.rfftfreq(size, period)
    told = (driving > EXCITED * driving.max()) & (frequency <= LAST * frequency[-1]) & (moved > 0.0)
    told[:FIRST] = False
    if not told.any():
        raise ScenarioError(name, "", "nothing excites it, or what is controlled does not move")
    coherence = np.abs(cross[told]) ** 2 / (driving[told] * moved[told])
    return ResponseEstimate(frequency[told], cross[told] / driving[told], coherence)


def window_spectra(signal: Samples, size: int) -> NDArray[np.complex128]:
    """The spectra of a signal's windows, a row each: a straight line taken out, then under Hann's bell."""
    windows = np.lib.stride_tricks.sliding_window_view(signal, size)[:: size // 2]
    time = np.arange(size) - (size - 1) / 2.0
    line = windows.mean(axis=1, keepdims=True) + np.outer(windows @ time, time / (time @ time))
    return np.fft.rfft((windows - line) * np.sin(np.pi * np.arange(size) / size) ** 2)


def window_for(lengths: Sequence[int], name: str) -> int:
    """The longest even number of samples of which sixteen windows lie within the parts."""
    total = sum(lengths)
    for size in range(2 * total // (WINDOWS + 1) // 2 * 2, SHORTEST - 1, -2):
        step = size - size // 2  # from window to window, each half over the next
        if sum(max((one - size // 2) // step, 0) for one in lengths) >= WINDOWS:
            return size
    needed = SHORTEST * (WINDOWS + 1) // 2
    problem = f"has {total} samples without a gap, too few for a frequency response; {needed} are needed"
    raise ScenarioError(name, "", problem)


class LogResponses(NamedTuple):
    """The responses that a log tells, by name, and what there is to say of it."""

    log: str
    responses: Mapping[str, ResponseEstimate]
    remarks: Sequence[str]


def with_logs(
    data: "xr.Dataset", loop: Loop, logs: Sequence[str | Path], columns: Mapping[str, str] | None = None
) -> "xr.Dataset":
    """Frequency responses of a loop with those of recorded logs beside them.

    A log holds what the loop controls, and what drove it: ``command`` tells the response ``machine``,
    ``reference`` the response ``closed``. Welch's method gives both, with their coherence. In the Dataset
    they are ``machine_recorded`` and ``closed_recorded``, with ``_coherence`` behind that, over ``recorded``
    [Hz], on which ``log`` says of which log each is.

    Args:
        data: what :func:`~hydroservo.linear.bode` returned.
        loop: of which they are.
        logs: files, as :func:`~hydroservo.identification.log.read_log` reads them.
        columns: which column of a log holds which signal, such as ``{"reference": "w_soll [mm/s]"}``.

    Source: Welch, IEEE Trans. Audio and Electroacoustics 15(2), 1967 (the method); Ljung, System
    Identification, 1999, sec. 6.4 and 13.5 (spectral estimates, also in a closed loop).
    Fails to tell the machine's response from the inverse of its law's where, in a closed loop, noise moves
    the command as much as the excitation does: the coherence of ``closed`` shows how much that is.
    """
    loop = checked_loop(loop)
    if not logs:
        raise ParameterError("logs", "[]", "must be at least one")
    every = [responses_in_log(loop, path, columns or {}) for path in logs]
    parts = [part for one in every for part in response_variables(one)]
    whole = {
        name: ("recorded", np.concatenate([part[name] for part in parts]), variable_attributes(data, name))
        for name in parts[0]
        if name not in ("recorded", "log")
    }
    frequency = np.concatenate([part["recorded"] for part in parts])
    coordinates = {
        "recorded": ("recorded", frequency, {"units": "Hz", "long_name": "frequency"}),
        "log": ("recorded", np.concatenate([part["log"] for part in parts])),
    }
    said = [f"{one.log}: {line}" for one in every for line in one.remarks]
    return with_warning(data.assign(whole).assign_coords(coordinates), said)


def responses_in_log(loop: Loop, path: str | Path, columns: Mapping[str, str]) -> LogResponses:
    demand = Field(loop.controls.declared().unit, "demand")
    with commands_in(loop.command):
        log = understand_log(read_log(path, columns, (TIME,), {**SIGNALS, REFERENCE: demand}))
    name, segments = (
        log.log.name,
        [whole for one in log.segments for whole in unbroken_stretches(loop, one, log.log.name)],
    )
    remarks = [*log.remarks]
    driven = {
        response: drive
        for response, drive in DRIVES.items()
        if drive in log.log.signals
        and np.ptp(log.log.signals[drive][np.isfinite(log.log.signals[drive])]) > 0.0
    }
    if not driven:
        raise ScenarioError(name, "", "neither command nor reference changes: nothing excites the machine")
    period, own = log.segments[0].period, loop.simulation.period
    if abs(period - own) > APART * own:
        remarks.append(
            f"is sampled every {1e3 * period:.4g} ms, the law every {1e3 * own:.4g} ms: the linear model is "
            "of signals at the law's samples"
        )
    found = {
        response: welch([(part[drive], part["controlled"]) for part in segments], period, name)
        for response, drive in driven.items()
    }
    return LogResponses(name, found, remarks)


def unbroken_stretches(loop: Loop, segment: Segment, name: str) -> Iterator[dict[str, Samples]]:
    """The stretches of a segment in which what is controlled was measured, with what drove it.

    Up to five samples that lack in a row are joined by a straight line.
    """
    nothing = np.full(segment.samples, np.nan)
    seen: Any = [segment.measured.get(signal, nothing) for signal in OUTPUTS]
    given: Any = segment.inputs.get(COMMAND, nothing)
    controlled = np.asarray(loop.controls.of(MachineOutputs(*seen), given))
    there = np.flatnonzero(np.isfinite(controlled))
    every = np.median(np.diff(there)) if there.size > 1 else 1  # sample, where it was measured more rarely
    if not there.size:
        signal = loop.controls.declared().meaning
        problem = f"does not hold what the loop controls, its {signal}; it has {', '.join(segment.measured)}"
        raise ScenarioError(name, "", problem)
    for places in np.split(there, np.flatnonzero(np.diff(there) > (LONGEST_BRIDGE + 1) * every) + 1):
        part = slice(places[0], places[-1] + 1)
        joined = np.interp(np.arange(part.start, part.stop), places, controlled[places])
        yield {"controlled": joined, **{drive: one[part] for drive, one in segment.inputs.items()}}


def response_variables(one: LogResponses) -> Iterator[dict[str, NDArray[np.generic]]]:
    """The variables of each response of a log; those of the other are nan."""
    for found, (frequency, response, coherence) in one.responses.items():
        part: dict[str, NDArray[np.generic]] = {
            "recorded": frequency,
            "log": np.full(frequency.size, one.log, dtype=object),
        }
        for name in DRIVES:
            none = np.full(frequency.size, np.nan)
            part[f"{name}_recorded"] = response if name == found else none.astype(complex)
            part[f"{name}_recorded_coherence"] = coherence if name == found else none
        yield part


def variable_attributes(data: "xr.Dataset", name: str) -> dict[str, str]:
    """Unit and meaning of a variable."""
    if name.endswith("coherence"):
        return {"units": "", "long_name": "coherence"}
    return dict(data[name.removesuffix("_recorded")].attrs)
