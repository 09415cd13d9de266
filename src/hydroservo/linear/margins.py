"""How far a loop is from being unstable: what its response crosses, and its margins."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.field import Field
from hydroservo.core.formatting import number, quantity
from hydroservo.linear.onset import MOST
from hydroservo.linear.operating_point import OperatingPoint, operating_point
from hydroservo.linear.system import OpenedLoop, opened_variants
from hydroservo.runs.arguments import checked_loop
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Table
from hydroservo.show.html import html_of

Vector = NDArray[np.float64]
Response = NDArray[np.complex128]

POINTS = 2000  # evenly by the logarithm
LOWEST = 1e-6  # of the Nyquist frequency
AROUND = np.concatenate([-np.geomspace(10.0, 1e-2, 12), [0.0], np.geomspace(1e-2, 10.0, 12)])  # half widths
LEVEL = 1e-2  # by how much a response may change from the lowest frequency to 0
INFINITE = 1e9  # a gain that only an undamped pole has, at which the phase jumps
SLOWEST = 1e-6  # growth per sample that counts as none: a slow drift of what nothing holds
LINEAR = 1e-2  # largest error
NO_SLOPE_ERRORS = (
    HydroservoError,
    ArithmeticError,
    ValueError,
)  # that a loop without slopes raises, a plug-in's too
CAUSES = {
    "plant": "it or its valve, drive or supply switches, sticks, or rises without bound",
    "controller": "it or a sensor switches, sticks, or rises without bound",
}

Frequencies = tuple[float, ...]
MARGIN_LABELS = {
    "gain_margin": ("gain margin", "dB"),
    "phase_margin": ("phase margin", "rad"),
    "delay_margin": ("delay margin", "s"),
    "disk_margin": ("disk margin", ""),
    "sensitivity_peak": ("sensitivity peak", "dB"),
    "oscillation_gain": ("oscillates from", "onset"),
    "bandwidth": ("bandwidth, \N{MINUS SIGN}3 dB", "Hz"),
    "bandwidth_90": ("bandwidth, \N{MINUS SIGN}90\N{DEGREE SIGN}", "Hz"),
}
OSCILLATES, UNSTABLE = Cell("oscillates", mark=Mark.QUIET), Cell("unstable", mark=Mark.QUIET)


class Crossings(NamedTuple):
    """Where a loop's response crosses the unit circle, and where the negative real axis."""

    gain: tuple[float, ...]  # frequencies [rad/s] of |L| = 1
    phase: tuple[float, ...]  # frequencies [rad/s] of L below 0


def response_grid(loop: OpenedLoop, points: int = POINTS) -> Vector:
    """Frequencies [rad/s] up to Nyquist's, the last, dense where the loop, open or closed, resonates."""
    nyquist = math.pi / loop.period
    rates = loop_rates(loop)
    own = (np.abs(rates.imag)[:, np.newaxis] + np.abs(rates.real)[:, np.newaxis] * AROUND).ravel()
    every = np.concatenate([np.geomspace(LOWEST, 1.0, points) * nyquist, own])
    return np.unique(every[(every >= LOWEST * nyquist) & (every <= nyquist)])


def loop_rates(loop: OpenedLoop) -> Response:
    """The poles of a loop, open and closed, as s [1/s]."""
    poles = np.concatenate([np.linalg.eigvals(loop.a), np.linalg.eigvals(loop.closed())])
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(poles[poles != 0.0].astype(complex)) / loop.period)


def crossings(loop: OpenedLoop, frequencies: Vector) -> Crossings:
    """What the response crosses between these frequencies.

    At a pole on the unit circle, as a law has at the frequency of its demand, the phase jumps: no crossing.
    """
    response = loop.transfer(frequencies)

    def one(frequency: float) -> complex:
        return complex(loop.transfer(np.array([frequency]))[0])

    gain = sign_changes(lambda w: abs(one(w)) - 1.0, frequencies, np.abs(response) - 1.0)
    real = sign_changes(lambda w: one(w).imag, frequencies, response.imag)
    ends = [0.0] if is_level_at_rest(loop, response[0]) else []
    phase = sorted(w for w in (*ends, *real, float(frequencies[-1])) if -INFINITE < one(w).real < 0.0)
    return Crossings(tuple(gain), tuple(phase))


def is_level_at_rest(loop: OpenedLoop, slow: complex) -> bool:
    """Whether the response at rest is that to slow motions: nothing integrates."""
    rest = complex(loop.transfer(np.zeros(1))[0])
    return abs(rest - slow) <= LEVEL * abs(slow)


def sign_changes(function: Callable[[float], float], places: Vector, found: Vector) -> list[float]:
    """Where a function is 0, once between each two places at which it has other signs."""
    from scipy.optimize import brentq

    first = np.flatnonzero(np.sign(found[:-1]) * np.sign(found[1:]) < 0.0)
    return [float(brentq(function, places[i], places[i + 1], rtol=1e-14)) for i in first]


def largest_near(function: Callable[[Vector], Vector], places: Vector) -> float:
    """The largest value of a function about some places."""
    from scipy.optimize import minimize_scalar

    found = function(places)
    i = int(found.argmax())
    ends = (float(places[max(i - 1, 0)]), float(places[min(i + 1, len(places) - 1)]))
    peak = minimize_scalar(lambda w: -function(np.array([w]))[0], bounds=ends, method="bounded")
    return max(float(found[i]), -float(peak.fun))


class Margins(NamedTuple):
    """What a loop bears at its machine's command, one change at a time; nan where it is unstable as it is.

    A disk margin of alpha says that the loop bears a gain from (2 - alpha)/(2 + alpha) to
    (2 + alpha)/(2 - alpha), and a phase of 2 atan(alpha/2), and both at once within the disk that these span.
    """

    stable: Annotated[bool, Field("", "whether the closed loop is stable")]
    gain_margin: Annotated[float, Field("", "least factor above 1 by which the gain makes it unstable")]
    gain_reduction_margin: Annotated[
        float, Field("", "largest factor below 1 by which it does; 0 if none does")
    ]
    phase_margin: Annotated[float, Field("rad", "least phase, late or early, that makes it unstable")]
    delay_margin: Annotated[float, Field("s", "least delay that makes it unstable")]
    disk_margin: Annotated[float, Field("", "alpha of the symmetric disk, 2/max |S - T|")]
    sensitivity_peak: Annotated[float, Field("", "max |S|")]
    gain_crossovers: Annotated[Frequencies, Field("rad/s", "frequencies of gain 1")]
    phase_crossovers: Annotated[Frequencies, Field("rad/s", "frequencies of -180 degrees")]
    error: Annotated[
        float, Field("", "largest change of S where slopes are taken otherwise, a share of it above 1")
    ]

    def finding(self) -> Finding:
        """What it says, as commands and notebooks show it."""
        return margins_finding(self)

    def _repr_html_(self) -> str:
        return html_of(self.finding())


def margins(loop: Loop, *, command: float | None = None) -> Margins:
    """The margins of a loop about the operating point where its machine has settled under a command.

    Sensors, law and hold as they step at samples, and the machine between them, are linearised; the loop is
    opened where the command enters the machine, behind what the law is told of it. With L the response of the
    opened loop up to Nyquist's frequency, S = 1/(1 + L) and T = 1 - S, the margins are those of L at the
    samples; a delay counts as e^(-j w T) there. Steps of resolution, of encoders and converters, are left
    out.

    Args:
        loop: the loop; its demand is exchanged for the one that is fulfilled at the operating point, and its
            load for the force at t = 0.
        command: u [V] under which the machine has settled; None for that of a loop with a steady start, and 0
            for another.

    Raises:
        ParameterError: there is no such operating point, or the loop is not linear about it: a law that
            switches or rises without bound, dry friction at rest, a valve's overlap or hysteresis.

    Source: the disk margin: Seiler, Packard, Gahinet, IEEE Control Systems Magazine 40(5), 2020, with
    symmetric disks (skew 0); the others: Astrom, Murray, Feedback Systems, 2008, sec. 9.3.
    Fails to say anything of large motions, of limits, and of what happens between samples.
    """
    point = operating_point(checked_loop(loop), command)
    found = margins_at(point)
    for path, error in found.errors.items():
        if not error < LINEAR:
            block = type(getattr(loop, path)).__name__
            raise ParameterError(path, block, f"is not linear about its operating point: {CAUSES[path]}")
    return found.margins


class JudgedMargins(NamedTuple):
    """The margins of a loop, and how far they can be trusted."""

    loop: OpenedLoop  # opened at its command
    margins: Margins  # of it
    # largest change of S where slopes of the plant, or of the controller, are taken otherwise
    errors: dict[str, float]

    @property
    def linear(self) -> bool:
        """Whether there is a slope at all."""
        return all(error < LINEAR for error in self.errors.values())


def margins_at(point: OperatingPoint) -> JudgedMargins:
    """The margins of a loop about a point, whether it is linear there or not."""
    variants = opened_variants(point)
    others = {"plant": variants.of_machine, "controller": variants.of_digital}
    places = response_grid(variants.loop)
    here = sensitivity_curve(variants.loop, places)
    errors = {
        path: max(sensitivity_change(here, one, places) for one in some) for path, some in others.items()
    }
    if not variants.loop.a.size:
        problem = (
            "closes no loop here: small changes of the command do not come back, as in a valve's overlap or "
            "where friction holds the piston; a command under which it moves is another point"
        )
        raise ParameterError("controller", type(point.loop.controller).__name__, problem)
    worst = max(errors.values(), key=lambda error: math.inf if math.isnan(error) else error)
    return JudgedMargins(variants.loop, opened_loop_margins(variants.loop)._replace(error=worst), errors)


def sensitivity_curve(loop: OpenedLoop, places: NDArray[np.float64]) -> NDArray[np.complex128]:
    """S of a loop at some frequencies [rad/s]."""
    with np.errstate(all="ignore"):
        return np.asarray(1.0 / (1.0 + loop.transfer(places)))


def sensitivity_change(here: NDArray[np.complex128], other: OpenedLoop, places: NDArray[np.float64]) -> float:
    """The largest change of S in another loop, as a share of it where it is above 1."""
    there = sensitivity_curve(other, places)
    with np.errstate(all="ignore"):
        return float((np.abs(there - here) / np.maximum(np.abs(here), 1.0)).max())


def opened_loop_margins(loop: OpenedLoop) -> Margins:
    places = response_grid(loop)
    found = crossings(loop, places)
    if not np.abs(np.linalg.eigvals(loop.closed())).max(initial=0.0) < 1.0 + SLOWEST:
        none = math.nan
        return Margins(False, none, none, none, none, none, none, found.gain, found.phase, 0.0)
    factors = 1.0 / np.abs(loop.transfer(np.array(found.phase)))
    late = np.mod(np.angle(loop.transfer(np.array(found.gain))) + math.pi, 2.0 * math.pi)
    return Margins(
        stable=True,
        gain_margin=float(factors[factors > 1.0].min(initial=math.inf)),
        gain_reduction_margin=float(factors[factors < 1.0].max(initial=0.0)),
        phase_margin=float(np.minimum(late, 2.0 * math.pi - late).min(initial=math.pi)),
        delay_margin=float((late / np.array(found.gain)).min(initial=math.inf)),
        disk_margin=1.0 / largest_near(lambda w: np.abs(1.0 / (1.0 + loop.transfer(w)) - 0.5), places),
        sensitivity_peak=largest_near(lambda w: np.abs(1.0 / (1.0 + loop.transfer(w))), places),
        gain_crossovers=found.gain,
        phase_crossovers=found.phase,
        error=0.0,
    )


def formatted_margin(value: float, unit: str, missing: str) -> str:
    """A number in the unit in which it is read."""
    shown, unit = margin_in(unit, value)
    if isinstance(shown, str):
        return shown
    return missing if math.isnan(shown) else quantity(shown, unit)


def margin_in(unit: str, value: float) -> tuple[float | str, str]:
    """A number and its SI unit, in dB for a ratio; a text for an onset of oscillation that is not a number.

    A value is a ratio where the unit is dB, and a factor on the gain where it is "onset".
    """
    if unit == "onset" and value in (1.0, math.inf):
        return "as it stands" if value == 1.0 else f"none up to {MOST:g} dB", ""
    if unit in ("dB", "onset"):
        return -math.inf if value == 0.0 else 20.0 * math.log10(value), "dB"
    return value, unit


def margins_finding(margins: Margins) -> Finding:
    """What the margins of a loop say."""
    numbers = margins._asdict()
    return Finding(
        "Margins",
        stability_lines([numbers]),
        [],
        [margins_table(["quantity", "value"], [numbers])],
        [],
        numbers,
    )


def stability_lines(points: Sequence[Mapping[str, Any]]) -> list[Line]:
    """That a loop oscillates or is unstable, at its point or at some of many."""
    some = f" at {{}} of {len(points)} values, so it has no margins there." if len(points) > 1 else ""
    for lead, rest, lost in (
        ("The loop oscillates", " as it stands", [one.get("oscillation_gain") == 1.0 for one in points]),
        ("The loop is unstable", " for small motions", [not one["stable"] for one in points]),
    ):
        if any(lost):
            where = some.format(sum(lost)) or ", so it has no margins."
            return [Line(lead, rest + where, Mark.BAD)]
    return []


def margins_table(headings: Sequence[str], points: Sequence[Mapping[str, Any]]) -> Table:
    """Margins and bandwidths, a column for each point."""
    rows = [
        [Cell(label), *(margin_cell(name, one) for one in points), Cell()]
        for name, (label, _) in MARGIN_LABELS.items()
        if name in points[0]
    ]
    values = [Column(heading, digits=3, right=True) for heading in headings[1:]]
    return Table("margins", (Column(headings[0]), *values, UNIT), rows, "Margins and bandwidths.")


def margin_cell(name: str, point: Mapping[str, Any]) -> Cell:
    """A margin, or why there is none."""
    value, unit = margin_in(MARGIN_LABELS[name][1], point[name])
    if isinstance(value, float) and math.isnan(value):
        if point.get("oscillation_gain") == 1.0:
            return OSCILLATES
        if not point["stable"]:
            return UNSTABLE
    return Cell(value, unit)


def in_decibels(factor: float) -> float:
    return 20.0 * math.log10(factor) if factor < math.inf else math.inf


def onset_phrase(onset: float) -> str:
    """What the loop does by itself, behind its name."""
    if onset == 1.0:
        return "oscillates as it stands"
    if onset == math.inf:
        return f"does not oscillate up to {MOST:g} dB"
    return f"oscillates from {number(in_decibels(onset))} dB"
