"""A loop about a point: its responses, its margins, and the frequencies at which one looks."""

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.controlled import Velocity
from hydroservo.control.loop import Loop
from hydroservo.core.block import values
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.field import Field
from hydroservo.core.signals import MachineOutputs
from hydroservo.core.validation import checked_number
from hydroservo.linear.margins import JudgedMargins, Margins, loop_rates, margins_at
from hydroservo.linear.moving_margins import TrustedMargins, trusted_margins, without_hysteresis
from hydroservo.linear.onset import oscillation_gain
from hydroservo.linear.operating_point import OperatingPoint, operating_point
from hydroservo.linear.system import (
    ASKED,
    COMMAND,
    DEMAND,
    FORCE,
    PartSlopes,
    System,
    close_loop,
    force_effect,
    frequency_response,
    opened_system,
    part_slopes,
)
from hydroservo.runs.run import complete_loop

Vector = NDArray[np.float64]
Response = NDArray[np.complex128]
Progress = Callable[[float], None]

POINTS = 400  # of a linear curve, evenly by the logarithm
AROUND = np.array([-8.0, -4.0, -2.0, -1.0, -0.5, -0.2, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0])  # half widths
SHARPEST = 1e-3  # damping of a resonance that a curve shows
BELOW, ABOVE = 40.0, 12.0  # a crossover's share at which a picture begins, and its multiple at which it ends
HIGHEST = 0.9  # of Nyquist's frequency
MOST = 10**6  # samples in a period of the lowest frequency


class Responses(NamedTuple):
    """Frequency responses of a loop, each of shape (frequencies,)."""

    # by name; ``machine``, what is controlled by the command; ``open``, L of the loop opened at its command;
    # ``closed``, what is controlled by the demand; ``sensitivity``, 1/(1 + L); ``compliance`` and
    # ``open_compliance``, how the rod gives way to the load, with the loop closed and with the command held
    curves: Mapping[str, Response]
    # what the law asks for by what a loop is excited with: "command", "reference", "load"
    commanded: Mapping[str, Response]


@np.errstate(all="ignore")  # what is lost is not finite, and not drawn
def responses(point: OperatingPoint, parts: PartSlopes, frequencies: Vector) -> Responses:
    """The responses of a loop about a point at some frequencies [rad/s].

    The demand acts by its value and both derivatives, as a law is told of them. The force acts between
    samples too, where what is sampled holds still.
    """
    w = np.asarray(frequencies, dtype=np.float64)
    whole = opened_system(point, parts)
    shut, moved = close_loop(whole), 1 + MachineOutputs._fields.index(compliance_signal(point.loop))
    signal = len(whole.c) - 1
    driven, ruled = frequency_response(whole, w), frequency_response(shut, w)
    told = np.column_stack([np.ones(len(w)), 1j * w, -(w**2)])
    push: Response = np.broadcast_to(whole.b[:, FORCE].astype(complex), (len(w), len(whole.b))).copy()
    push[:, : len(values(point.machine))] = force_effect(point, parts, w)
    held = force_response(whole, w, push)
    free = force_response(shut, w, push + (shut.b - whole.b)[:, FORCE])
    loop = -driven[:, ASKED, COMMAND]
    sensitivity = 1.0 / (1.0 + loop)
    curves = {
        "machine": driven[:, signal, COMMAND],
        "open": loop,
        "closed": (ruled[:, signal, DEMAND] * told).sum(axis=1),
        "sensitivity": sensitivity,
        "compliance": -free[:, moved],
        "open_compliance": -held[:, moved],
    }
    commanded = {
        "command": sensitivity,
        "reference": (ruled[:, ASKED, DEMAND] * told).sum(axis=1),
        "load": free[:, ASKED],
    }
    return Responses(curves, commanded)


def compliance_signal(loop: Loop) -> str:
    """What of the machine is compared with the load: the velocity if controlled, else the position."""
    return "velocity" if isinstance(loop.controls, Velocity) else "position"


def force_response(system: System, w: Vector, columns: Response) -> Response:
    """All outputs by the force, shape (frequencies, outputs)."""
    part = system.part([FORCE], list(range(len(system.c))))
    return frequency_response(part, w, columns[..., np.newaxis])[..., 0]


class LoopView(NamedTuple):
    """A loop about a point, and the frequencies at which one looks."""

    asked: Loop  # the loop as it was asked for
    point: OperatingPoint  # where it stays
    slid: bool  # whether its hysteresis passes all of the command there
    parts: PartSlopes  # its derivatives there
    judged: JudgedMargins  # its margins
    trusted: TrustedMargins  # those of them that hold, or those while it moves
    onset: float  # the factor on its gain from which it oscillates; infinite for none, nan for unknown
    low: float  # the lowest frequency [Hz]
    high: float  # the highest

    @property
    def grid(self) -> Vector:
        """Frequencies of the picture's curves [Hz]."""
        return self.dense(self.low, self.high)

    @property
    def usual(self) -> Vector:
        """Frequencies from far below the crossover up to Nyquist's [Hz], whatever the picture shows."""
        low, _ = checked_band(None, self.judged.margins, self.point)
        return self.dense(low, HIGHEST * 0.5 / self.point.loop.simulation.period)

    def dense(self, low: float, high: float) -> Vector:
        """Frequencies of a curve [Hz], dense where the loop resonates."""
        rates = loop_rates(self.judged.loop)
        width = np.maximum(np.abs(rates.real), SHARPEST * np.abs(rates.imag))  # else a peak without damping
        sharp = (np.abs(rates.imag)[:, np.newaxis] + width[:, np.newaxis] * AROUND).ravel()
        every = np.concatenate([np.geomspace(low, high, POINTS), sharp / (2.0 * math.pi)])
        return np.unique(every[(every >= low) & (every <= high)])


def loop_view(
    loop: Loop,
    command: float | None,
    force: float | None,
    band: tuple[float, float] | None,
    progress: Progress | None = None,
) -> LoopView:
    """A loop about a point, as :func:`hydroservo.bode` has it."""
    if force is not None:
        checked_number(force, "force", Field("N", ""), float)
    point, judged, slid = smoothest_point(loop, command, force)
    parts, _, _ = part_slopes(point)
    limits = checked_band(band, judged.margins, point)
    onset = known_onset(loop, progress)
    trusted = trusted_margins(point, judged, loop, onset)
    return LoopView(complete_loop(loop), point, slid, parts, judged, trusted, onset, *limits)


def smoothest_point(
    loop: Loop, command: float | None, force: float | None
) -> tuple[OperatingPoint, JudgedMargins, bool]:
    """A point of a loop, and whether its hysteresis slides there, as it does where the loop has no slope."""
    slid = without_hysteresis(loop)
    try:
        point = operating_point(loop, command, force)
        judged = margins_at(point)
    except ParameterError:
        if slid == loop:
            raise
    else:
        if judged.linear or slid == loop:
            return point, judged, False
    point = operating_point(slid, command, force)
    return point, margins_at(point), True


def known_onset(loop: Loop, progress: Progress | None) -> float:
    """From which gain a loop oscillates; nan where it cannot run."""
    try:
        return oscillation_gain(loop, progress=progress)
    except HydroservoError:
        return math.nan


def checked_band(
    band: tuple[float, float] | None, found: Margins, point: OperatingPoint
) -> tuple[float, float]:
    """The lowest and the highest frequency [Hz]."""
    nyquist = 0.5 / point.loop.simulation.period
    if band is None:
        crossed = [w / (2.0 * math.pi) for w in (*found.gain_crossovers, *found.phase_crossovers)]
        inside = [f for f in crossed if 0.0 < f < HIGHEST * nyquist] or [0.05 * nyquist]
        return max(min(inside) / BELOW, nyquist / MOST), min(ABOVE * max(inside), HIGHEST * nyquist)
    low, high = (checked_number(one, "band", Field("Hz", "", above=0), float) for one in band)
    if not low < high:
        raise ParameterError("band", [low, high], "must rise from the lowest to the highest frequency [Hz]")
    if not high < nyquist:
        raise ParameterError("band", high, f"must be below Nyquist's frequency, {nyquist:g} [Hz]")
    return float(low), float(high)
