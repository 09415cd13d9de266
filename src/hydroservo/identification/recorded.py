"""Frequency responses of recorded logs, beside those of a loop."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.command_scale import commands_in
from hydroservo.errors import ParameterError, ScenarioError
from hydroservo.field import Field
from hydroservo.identification.log import read_log
from hydroservo.identification.segments import LONGEST_BRIDGE, Segment, understood
from hydroservo.identification.signals import COMMAND, OUTPUTS, REFERENCE, SIGNALS, TIME
from hydroservo.identification.welch import Estimate, welch
from hydroservo.loop import Loop
from hydroservo.runs.arguments import checked_loop
from hydroservo.runs.cautions import with_warning
from hydroservo.signals import MachineOutputs

if TYPE_CHECKING:
    import xarray as xr

Samples = NDArray[np.float64]

DRIVES = {"machine": COMMAND, "closed": REFERENCE}  # what the response of this name is by
APART = 1e-2  # of a sample period, by which that of a log may differ


class Recorded(NamedTuple):
    """The responses that a log tells, by name, and what there is to say of it."""

    log: str
    responses: Mapping[str, Estimate]
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
    every = [recorded(loop, path, columns or {}) for path in logs]
    parts = [part for one in every for part in parts_of(one)]
    whole = {
        name: ("recorded", np.concatenate([part[name] for part in parts]), about(data, name))
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


def recorded(loop: Loop, path: str | Path, columns: Mapping[str, str]) -> Recorded:
    """The responses that one log tells.

    Raises:
        ScenarioError: it tells none.
    """
    demand = Field(loop.controls.declared().unit, "demand")
    with commands_in(loop.command):
        log = understood(read_log(path, columns, (TIME,), {**SIGNALS, REFERENCE: demand}))
    name, segments = (
        log.log.name,
        [whole for one in log.segments for whole in unbroken(loop, one, log.log.name)],
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
    return Recorded(name, found, remarks)


def unbroken(loop: Loop, segment: Segment, name: str) -> Iterator[dict[str, Samples]]:
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


def parts_of(one: Recorded) -> Iterator[dict[str, NDArray[np.generic]]]:
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


def about(data: "xr.Dataset", name: str) -> dict[str, str]:
    """Unit and meaning of a variable."""
    if name.endswith("coherence"):
        return {"units": "", "long_name": "coherence"}
    return dict(data[name.removesuffix("_recorded")].attrs)
