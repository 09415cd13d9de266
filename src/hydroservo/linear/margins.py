"""How far a loop is from being unstable."""

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.field import Field
from hydroservo.linear.open_loop import OpenLoop, opened
from hydroservo.linear.operating_point import OperatingPoint, operating_point
from hydroservo.linear.reading import margins_finding
from hydroservo.linear.response import crossings, grid, largest
from hydroservo.runs.arguments import checked_loop
from hydroservo.show import Finding
from hydroservo.show.html import html_of

SLOWEST = 1e-6  # growth per sample that counts as none: a slow drift of what nothing holds
LINEAR = 1e-2  # largest error
UNTOLD = (HydroservoError, ArithmeticError, ValueError)  # that a loop without slopes raises, a plug-in's too
CAUSES = {
    "plant": "it or its valve, drive or supply switches, sticks, or rises without bound",
    "controller": "it or a sensor switches, sticks, or rises without bound",
}

Frequencies = tuple[float, ...]


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


class Judged(NamedTuple):
    """The margins of a loop, and how far they can be trusted.

    Attributes:
        loop: opened at its command.
        margins: of it.
        errors: largest change of S where slopes of the plant, or of the controller, are taken otherwise.
    """

    loop: OpenLoop
    margins: Margins
    errors: dict[str, float]

    @property
    def linear(self) -> bool:
        """Whether there is a slope at all."""
        return all(error < LINEAR for error in self.errors.values())


def margins_at(point: OperatingPoint) -> Judged:
    """The margins of a loop about a point, whether it is linear there or not."""
    variants = opened(point)
    others = {"plant": variants.of_machine, "controller": variants.of_digital}
    places = grid(variants.loop)
    here = sensitivity(variants.loop, places)
    errors = {path: max(change(here, one, places) for one in some) for path, some in others.items()}
    if not variants.loop.a.size:
        problem = (
            "closes no loop here: small changes of the command do not come back, as in a valve's overlap or "
            "where friction holds the piston; a command under which it moves is another point"
        )
        raise ParameterError("controller", type(point.loop.controller).__name__, problem)
    worst = max(errors.values(), key=lambda error: math.inf if math.isnan(error) else error)
    return Judged(variants.loop, margins_of(variants.loop)._replace(error=worst), errors)


def sensitivity(loop: OpenLoop, places: NDArray[np.float64]) -> NDArray[np.complex128]:
    """S of a loop at some frequencies [rad/s]."""
    with np.errstate(all="ignore"):
        return np.asarray(1.0 / (1.0 + loop.transfer(places)))


def change(here: NDArray[np.complex128], other: OpenLoop, places: NDArray[np.float64]) -> float:
    """The largest change of S in another loop, as a share of it where it is above 1."""
    there = sensitivity(other, places)
    with np.errstate(all="ignore"):
        return float((np.abs(there - here) / np.maximum(np.abs(here), 1.0)).max())


def margins_of(loop: OpenLoop) -> Margins:
    """The margins of an opened loop."""
    places = grid(loop)
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
        disk_margin=1.0 / largest(lambda w: np.abs(1.0 / (1.0 + loop.transfer(w)) - 0.5), places),
        sensitivity_peak=largest(lambda w: np.abs(1.0 / (1.0 + loop.transfer(w))), places),
        gain_crossovers=found.gain,
        phase_crossovers=found.phase,
        error=0.0,
    )
