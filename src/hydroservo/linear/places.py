"""Where a machine moves, and the margins there of one law after another: fast enough for a search."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import replace, values
from hydroservo.hooks import smoothed
from hydroservo.linear.margins import SLOWEST, UNTOLD, Judged, margins_at
from hydroservo.linear.open_loop import OpenLoop, put_together
from hydroservo.linear.operating_point import OperatingPoint, operating_point
from hydroservo.linear.parts import Parts, digital_rows, digital_slopes, parts_of
from hydroservo.linear.response import grid
from hydroservo.linear.slopes import exact_slopes
from hydroservo.linear.trusted import SHARES, largest_command, sliding
from hydroservo.linear.view import smoothest
from hydroservo.loop import Loop
from hydroservo.runs.run import complete, designed_law

__all__ = ["Place", "Reserve", "places_of"]

POINTS = 400  # of a curve, besides those about its resonances
NEAR = (-0.01, 0.01)  # of the largest command: as good as at rest, but a valve has left its null
FAR = (-0.9, 0.9)  # where a law that has no slope at the others may have one, as beyond a dead band
MILD = (
    0.5  # error of a place whose slopes to either side differ and still say something, as at a valve's null
)

Vector = NDArray[np.float64]
Response = NDArray[np.complex128]


class Reserve(NamedTuple):
    """How far a loop is from being unstable.

    Attributes:
        growth: the largest |eigenvalue| of the closed loop, from sample to sample.
        gain_margin: least factor above 1 on the gain; nan where the loop is unstable, as the others are.
        phase_margin: least phase [rad].
        sensitivity_peak: max |S|.
    """

    growth: float
    gain_margin: float = math.nan
    phase_margin: float = math.nan
    sensitivity_peak: float = math.nan


class Place(NamedTuple):
    """A point at which a machine settles under a command, and its derivatives there.

    Attributes:
        loop: complete, its law not yet designed.
        point: where it stays.
        parts: its derivatives, of the law that it has.
    """

    loop: Loop
    point: OperatingPoint
    parts: Parts

    def reserve(self, parameters: Mapping[str, float]) -> Reserve:
        """The loop's reserve with other numbers of its law and sensors.

        The law is linearised with the states that the loop's own law has at this place.

        Raises:
            ParameterError: the law allows no design.
        """
        loop = replace(self.loop, parameters)
        own = self.point.loop._replace(
            controller=smoothed(designed_law(loop)), sensors=smoothed(loop.sensors)
        )
        point = self.point._replace(loop=own)
        numbers = np.array(
            [*values(point.machine), *values(point.digital), *values(point.demand), point.force]
        )
        exact = exact_slopes(digital_rows, point, numbers)
        digital = digital_slopes(point).mean if exact is None else exact
        return reserve_of(put_together(point, self.parts._replace(digital=digital)))


def places_of(loop: Loop) -> list[Place]:
    """The places of a loop at which its margins are judged, where it has a slope.

    These are its own operating point and those under 1 %, 10 % and 50 % of the largest command of its run,
    both ways, with a hysteresis that passes all of the command; those under 90 % where it has a slope at none
    of them.
    """
    largest = largest_command(loop)
    found: list[Place] = []
    with suppress(*UNTOLD):
        found += with_slopes(smoothest(loop, None, None)[:2], loop)
    if largest:
        slid = sliding(loop)
        found += places_under(slid, [share * largest for share in (*SHARES, *NEAR)])
        found += [] if found else places_under(slid, [share * largest for share in FAR])
    return found


def places_under(loop: Loop, commands: Sequence[float]) -> Iterator[Place]:
    """Those under some commands [V]."""
    for command in commands:
        with suppress(*UNTOLD):
            point = operating_point(loop, command)
            yield from with_slopes((point, margins_at(point)), loop)


def with_slopes(judged: tuple[OperatingPoint, Judged], loop: Loop) -> Iterator[Place]:
    """The place at a point, unless the loop has no slope there."""
    point, found = judged
    if all(error < MILD for error in found.errors.values()):
        yield Place(complete(loop), point, parts_of(point)[0])


def reserve_of(loop: OpenLoop) -> Reserve:
    """The reserve of an opened loop, from its response at some hundred frequencies."""
    with np.errstate(all="ignore"):
        closed = loop.closed()
    growth = (
        float(np.abs(np.linalg.eigvals(closed)).max(initial=0.0)) if np.isfinite(closed).all() else math.inf
    )
    if not growth < 1.0 + SLOWEST:
        return Reserve(growth)
    places = grid(loop, POINTS)
    with np.errstate(all="ignore"):
        response = loop.transfer(places)
        sensitivity = np.abs(1.0 / (1.0 + response))
    if not np.isfinite(sensitivity).any():
        return Reserve(math.inf)
    peak = float(np.nanmax(sensitivity))
    return Reserve(growth, gain_margin(response), phase_margin(response), peak)


def gain_margin(response: Response) -> float:
    """From where a response crosses the negative real axis, between two frequencies on a straight line."""
    before, after = response[:-1], response[1:]
    crossed = np.flatnonzero((before.imag * after.imag < 0.0) & (before.real < 0.0) & (after.real < 0.0))
    share = before.imag[crossed] / (before.imag[crossed] - after.imag[crossed])
    reals = np.append(before.real[crossed] + share * (after - before).real[crossed], response[-1].real)
    return float((-1.0 / reals[(reals > -1.0) & (reals < 0.0)]).min(initial=math.inf))


def phase_margin(response: Response) -> float:
    """From where a response crosses the unit circle."""
    logs = np.log(np.abs(response))
    crossed = np.flatnonzero(logs[:-1] * logs[1:] < 0.0)
    share = logs[crossed] / (logs[crossed] - logs[crossed + 1])
    turn = np.angle(response[crossed + 1] / response[crossed])
    late = np.abs(np.mod(np.angle(response[crossed]) + share * turn, 2.0 * math.pi) - math.pi)
    return float(late.min(initial=math.pi))
