"""Where a machine moves, and the margins there of one law after another: fast enough for a search."""

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.block import leaves, replace, values
from hydroservo.core.errors import ParameterError
from hydroservo.core.hooks import smoothed
from hydroservo.core.twins import Twins
from hydroservo.linear.duals import dual_twins
from hydroservo.linear.margins import SLOWEST, UNTOLD, Judged, Margins, margins_at
from hydroservo.linear.open_loop import OpenLoop, put_together
from hydroservo.linear.operating_point import OperatingPoint, operating_point
from hydroservo.linear.parts import Parts, digital_rows, digital_slopes, parts_of
from hydroservo.linear.response import grid
from hydroservo.linear.slopes import exact_slopes
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import complete, designed_law, simulate

POINTS = 400  # of a curve, besides those about its resonances
SHARES = (-0.5, -0.1, 0.1, 0.5)  # of the largest command of a run, under which a machine moves
NEAR = (-0.01, 0.01)  # and nearly rests

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
        margins: there, with that law.
        twins: of the classes of its law and sensors, which are the same with other numbers.
    """

    loop: Loop
    point: OperatingPoint
    parts: Parts
    margins: Margins
    twins: Twins

    def reserve(self, parameters: Mapping[str, float]) -> Reserve:
        """The loop's reserve with other numbers of its law and sensors.

        The law is linearised with the states that the loop's own law has at this place.
        """
        loop = replace(self.loop, parameters)
        own = self.point.loop._replace(
            controller=smoothed(designed_law(loop)), sensors=smoothed(loop.sensors)
        )
        point = self.point._replace(loop=own)
        numbers = np.array(
            [*values(point.machine), *values(point.digital), *values(point.demand), point.force]
        )
        exact = exact_slopes(digital_rows, self.twins, point, numbers)
        digital = digital_slopes(point).mean if exact is None else exact
        return reserve_of(put_together(point, self.parts._replace(digital=digital)))


def places_of(loop: Loop) -> list[Place]:
    """The places of a loop at which its margins are judged: its own operating point, and while it moves.

    They are those at which it has a slope.
    """
    points: list[tuple[OperatingPoint, Judged]] = []
    with suppress(*UNTOLD):
        own = operating_point(loop, None)
        judged = margins_at(own)
        points += [(own, judged)] if judged.linear else []
    points += while_moving(loop, largest_command(loop))
    whole, twins = complete(loop), dual_twins()
    return [Place(whole, point, parts_of(point)[0], judged.margins, twins) for point, judged in points]


def is_unstable(loop: Loop) -> bool:
    """Whether small motions of a loop are unstable at one of its places; False where it has none.

    It has none with an FMU, which has no slopes, and with a plug-in's law that raises an exception.
    """
    return any(not place.margins.stable for place in places_of(loop))


def while_moving(loop: Loop, largest: float) -> Iterator[tuple[OperatingPoint, Judged]]:
    """The points under some commands, both ways, where a loop stays and has a slope, and its margins there.

    The commands are 1 % of the largest one, as good as at rest but beyond the kink of a valve's null, 10 %
    and 50 %. Friction slides there, and hysteresis passes all of the command, as it does of one that goes on
    in one direction.

    Args:
        loop: the loop.
        largest: command of its run [V]; where that is 0 there are no points.
    """
    loop = sliding(loop)
    for command in (share * largest for share in (*SHARES, *NEAR) if largest):
        with suppress(*UNTOLD):
            point = operating_point(loop, command)
            judged = margins_at(point)
            if judged.linear:
                yield point, judged


def sliding(loop: Loop) -> Loop:
    """The loop whose hysteresis passes all of a command, as it does of one that goes on in one direction."""
    slid: Loop = replace(loop, {path: 0.0 for path, _ in kinked(loop, "hysteresis")})
    return slid


def kinked(loop: Loop, name: str) -> Iterator[tuple[str, float]]:
    """Numbers of this name in a loop that are not 0, by their path."""
    for path, value in leaves(loop):
        if path.rpartition(".")[2] == name and value:
            yield path, value


def largest_command(loop: Loop) -> float:
    """The largest command of a run of the loop [V]; 0 where it cannot run."""
    try:
        data = quietly(simulate)(loop, record=["controller.u"], metrics=[])
    except ParameterError:
        return 0.0
    return float(np.nanmax(np.abs(data["controller.u"].values), initial=0.0))


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
    peak = peak_of(sensitivity)
    return Reserve(growth, gain_margin(response), phase_margin(response), peak)


def peak_of(sensitivity: Vector) -> float:
    """The largest value of a curve, by a parabola through it and its neighbours."""
    i = int(np.nanargmax(sensitivity))
    before, here, after = np.take(sensitivity, (i - 1, i, i + 1), mode="clip")
    bent = before - 2.0 * here + after
    return float(here - 0.125 * (after - before) ** 2 / bent) if bent < 0.0 else float(here)


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
    distance = np.abs(np.mod(np.angle(response[crossed]) + share * turn, 2.0 * math.pi) - math.pi)
    return float(distance.min(initial=math.pi))
