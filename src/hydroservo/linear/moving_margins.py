"""The margins of a loop while its machine moves, and those that hold where it has kinks."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.block import leaves, replace, values
from hydroservo.core.errors import ParameterError
from hydroservo.core.formatting import number
from hydroservo.core.hooks import smoothed
from hydroservo.core.twins import Twins
from hydroservo.linear.margins import (
    NO_SLOPE_ERRORS,
    SLOWEST,
    JudgedMargins,
    Margins,
    in_decibels,
    margins_at,
    onset_phrase,
    response_grid,
)
from hydroservo.linear.onset import MOST
from hydroservo.linear.operating_point import OperatingPoint, operating_point
from hydroservo.linear.slopes import dual_twins, exact_slopes
from hydroservo.linear.system import (
    OpenedLoop,
    PartSlopes,
    assemble_loop,
    digital_rows,
    digital_slopes,
    part_slopes,
)
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import complete_loop, designed_law, simulate

POINTS = 400  # of a curve, besides those about its resonances
SHARES = (-0.5, -0.1, 0.1, 0.5)  # of the largest command of a run, under which a machine moves
NEAR = (-0.01, 0.01)  # and nearly rests

Vector = NDArray[np.float64]
Response = NDArray[np.complex128]
AGREED = 1.5  # dB, by which a gain margin may miss the onset of oscillation
LEAST = 0.1  # of the largest command of the run, from which a point that is asked for has margins of its own


class Reserve(NamedTuple):
    """How far a loop is from being unstable."""

    growth: float  # the largest |eigenvalue| of the closed loop, from sample to sample
    # least factor above 1 on the gain; nan where the loop is unstable, as the others are
    gain_margin: float = math.nan
    phase_margin: float = math.nan  # least phase [rad]
    sensitivity_peak: float = math.nan  # max |S|


class MarginPoint(NamedTuple):
    """A point at which a machine settles under a command, and its derivatives there."""

    loop: Loop  # complete, its law not yet designed
    point: OperatingPoint  # where it stays
    parts: PartSlopes  # its derivatives, of the law that it has
    margins: Margins  # there, with that law
    twins: Twins  # of the classes of its law and sensors, which are the same with other numbers

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
        return stability_reserve(assemble_loop(point, self.parts._replace(digital=digital)))


def margin_points(loop: Loop) -> list[MarginPoint]:
    """The places of a loop at which its margins are judged: its own operating point, and while it moves.

    They are those at which it has a slope.
    """
    points: list[tuple[OperatingPoint, JudgedMargins]] = []
    with suppress(*NO_SLOPE_ERRORS):
        own = operating_point(loop, None)
        judged = margins_at(own)
        points += [(own, judged)] if judged.linear else []
    points += points_in_motion(loop, largest_command(loop))
    whole, twins = complete_loop(loop), dual_twins()
    return [
        MarginPoint(whole, point, part_slopes(point)[0], judged.margins, twins) for point, judged in points
    ]


def is_unstable(loop: Loop) -> bool:
    """Whether small motions of a loop are unstable at one of its places; False where it has none.

    It has none with an FMU, which has no slopes, and with a plug-in's law that raises an exception.
    """
    return any(not place.margins.stable for place in margin_points(loop))


def points_in_motion(loop: Loop, largest: float) -> Iterator[tuple[OperatingPoint, JudgedMargins]]:
    """The points under some commands, both ways, where a loop stays and has a slope, and its margins there.

    The commands are 1 % of the largest one, as good as at rest but beyond the kink of a valve's null, 10 %
    and 50 %. Friction slides there, and hysteresis passes all of the command, as it does of one that goes on
    in one direction.

    Where the largest command [V] is 0 there are none.
    """
    loop = without_hysteresis(loop)
    for command in (share * largest for share in (*SHARES, *NEAR) if largest):
        with suppress(*NO_SLOPE_ERRORS):
            point = operating_point(loop, command)
            judged = margins_at(point)
            if judged.linear:
                yield point, judged


def without_hysteresis(loop: Loop) -> Loop:
    """The loop whose hysteresis passes all of a command, as it does of one that goes on in one direction."""
    slid: Loop = replace(loop, {path: 0.0 for path, _ in nonzero_fields(loop, "hysteresis")})
    return slid


def nonzero_fields(loop: Loop, name: str) -> Iterator[tuple[str, float]]:
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


def stability_reserve(loop: OpenedLoop) -> Reserve:
    """The reserve of an opened loop, from its response at some hundred frequencies."""
    with np.errstate(all="ignore"):
        closed = loop.closed()
    growth = (
        float(np.abs(np.linalg.eigvals(closed)).max(initial=0.0)) if np.isfinite(closed).all() else math.inf
    )
    if not growth < 1.0 + SLOWEST:
        return Reserve(growth)
    places = response_grid(loop, POINTS)
    with np.errstate(all="ignore"):
        response = loop.transfer(places)
        sensitivity = np.abs(1.0 / (1.0 + response))
    if not np.isfinite(sensitivity).any():
        return Reserve(math.inf)
    peak = parabola_peak(sensitivity)
    return Reserve(growth, crossed_gain_margin(response), crossed_phase_margin(response), peak)


def parabola_peak(sensitivity: Vector) -> float:
    """The largest value of a curve, by a parabola through it and its neighbours."""
    i = int(np.nanargmax(sensitivity))
    before, here, after = np.take(sensitivity, (i - 1, i, i + 1), mode="clip")
    bent = before - 2.0 * here + after
    return float(here - 0.125 * (after - before) ** 2 / bent) if bent < 0.0 else float(here)


def crossed_gain_margin(response: Response) -> float:
    """From where a response crosses the negative real axis, between two frequencies on a straight line."""
    before, after = response[:-1], response[1:]
    crossed = np.flatnonzero((before.imag * after.imag < 0.0) & (before.real < 0.0) & (after.real < 0.0))
    share = before.imag[crossed] / (before.imag[crossed] - after.imag[crossed])
    reals = np.append(before.real[crossed] + share * (after - before).real[crossed], response[-1].real)
    return float((-1.0 / reals[(reals > -1.0) & (reals < 0.0)]).min(initial=math.inf))


def crossed_phase_margin(response: Response) -> float:
    """From where a response crosses the unit circle."""
    logs = np.log(np.maximum(np.abs(response), np.finfo(float).tiny))  # some responses are 0
    crossed = np.flatnonzero(logs[:-1] * logs[1:] < 0.0)
    share = logs[crossed] / (logs[crossed] - logs[crossed + 1])
    turn = np.angle(response[crossed + 1] * response[crossed].conj())
    distance = np.abs(np.mod(np.angle(response[crossed]) + share * turn, 2.0 * math.pi) - math.pi)
    return float(distance.min(initial=math.pi))


class TrustedMargins(NamedTuple):
    """Margins that hold, or why there are none."""

    margins: Margins  # nan where none hold
    here: bool  # whether they are those of the point itself
    remark: str  # where they are from, or why there are none; empty for those of a smooth loop at its point


def trusted_margins(point: OperatingPoint, judged: JudgedMargins, loop: Loop, onset: float) -> TrustedMargins:
    """The margins of a loop about a point, or those while it moves where the point has none that hold.

    Those of a smooth loop are its own. Where it has a kink at the point, or rests within an overlap, which
    the onset of oscillation shows, they are the worst of those under which its machine moves, as of
    :func:`~hydroservo.linear.moving_margins.points_in_motion`.

    An onset is nan if unknown and infinite for none. A loop that oscillates as it stands has no margins.

    Source: chosen here.
    Fails for loops whose gain at other commands is higher still.
    """
    here = judged.margins
    if onset == 1.0 and here.stable:
        return TrustedMargins(
            without_margins(here, onset), False, f"no margins: the loop {onset_phrase(onset)}"
        )
    known = not math.isnan(onset)
    holds = here.stable and agrees_with_onset(here.gain_margin, onset) and (judged.linear or onset < math.inf)
    if judged.linear and not here.stable:
        problem = trust_problem({point.command: here}, judged, loop, onset) if onset > 1.0 else ""
        return TrustedMargins(here, True, problem and f"no margins: {problem}")
    if judged.linear and holds and known:
        return TrustedMargins(here, True, "")
    largest = largest_command(loop)
    if judged.linear and abs(point.command) >= LEAST * largest > 0.0:
        return TrustedMargins(here, True, "")
    found = {one.command: at.margins for one, at in points_in_motion(loop, largest)}
    moving = [one.gain_margin for command, one in found.items() if abs(command) >= LEAST * largest]
    if not known and moving:  # rest within an overlap is quieter than any motion
        found = {command: one for command, one in found.items() if one.gain_margin <= max(moving)}
        holds = holds and here.gain_margin <= max(moving)
    if holds and judged.linear:
        found[point.command] = here
    problem = trust_problem(found, judged, loop, onset)
    if problem:
        return TrustedMargins(without_margins(here, onset), False, f"no margins: {problem}")
    worst, span = worst_margins(list(found.values()), here), gain_margin_span(found)
    said = f"margins are the worst under {commands_of(found)}: gain margin {span} dB"
    return TrustedMargins(worst, holds, "" if list(found) == [point.command] else said)


def trust_problem(found: Mapping[float, Margins], judged: JudgedMargins, loop: Loop, onset: float) -> str:
    """Why no margins hold; empty where they do."""
    if not found:
        known = "" if math.isnan(onset) else f"the loop {onset_phrase(onset)}; "
        return f"{slopeless_blocks(judged, loop)}; {known}measure with a larger amplitude"
    unstable = [command for command, one in found.items() if not one.stable]
    if unstable:
        link = "and" if onset == 1.0 else "but"
        known = "" if math.isnan(onset) else f", {link} the loop itself {onset_phrase(onset)}"
        return f"small motions are unstable under {commands_of(unstable)}{known}"
    if not agrees_with_onset(min(one.gain_margin for one in found.values()), onset):
        span = f"{gain_margin_span(found)} dB for small motions under {commands_of(found)}"
        return f"{span}, but the loop {onset_phrase(onset)}"
    return ""


def commands_of(commands: Iterable[float]) -> str:
    return f"{', '.join(number(one) for one in sorted(commands))} V"


def gain_margin_span(found: Mapping[float, Margins]) -> str:
    """The least and the largest gain margin [dB]."""
    every = [one.gain_margin for one in found.values()]
    return " to ".join(dict.fromkeys(number(in_decibels(one)) for one in (min(every), max(every))))


def worst_margins(every: Sequence[Margins], here: Margins) -> Margins:
    """The least of all margins, and the largest sensitivity; crossovers are those of the point itself."""
    return here._replace(
        stable=True,
        gain_margin=min(one.gain_margin for one in every),
        gain_reduction_margin=max(one.gain_reduction_margin for one in every),
        phase_margin=min(one.phase_margin for one in every),
        delay_margin=min(one.delay_margin for one in every),
        disk_margin=min(one.disk_margin for one in every),
        sensitivity_peak=max(one.sensitivity_peak for one in every),
    )


def without_margins(here: Margins, onset: float) -> Margins:
    """No margins; of the point itself only what is no margin is left."""
    none = dict.fromkeys((name for name in Margins._fields if name.endswith(("margin", "peak"))), math.nan)
    return here._replace(stable=here.stable and onset != 1.0)._replace(**none)  # type: ignore[arg-type]


def agrees_with_onset(gain_margin: float, onset: float) -> bool:
    """Whether a gain margin is about where the loop begins to oscillate, or nothing is known of that."""
    if math.isnan(onset) or math.isnan(gain_margin):
        return math.isnan(onset)
    highest = 10.0 ** (MOST / 20.0)
    apart = in_decibels(min(gain_margin, highest)) - in_decibels(min(onset, highest))
    return abs(apart) <= AGREED


def slopeless_blocks(judged: JudgedMargins, loop: Loop) -> str:
    """Which blocks leave a loop without a slope."""
    causes = [f"the {path.partition('.')[0]}'s hysteresis" for path, _ in nonzero_fields(loop, "hysteresis")]
    causes += [f"the {path.partition('.')[0]}'s overlap" for path, _ in nonzero_fields(loop, "lap")]
    friction = getattr(loop.plant, "friction", None)
    if friction is not None and type(friction).__name__ != "Viscous":
        causes.append(f"friction ({type(friction).__name__})")
    path = max(judged.errors, key=lambda name: judged.errors[name])
    causes = list(dict.fromkeys(causes)) or [f"{path} ({type(getattr(loop, path)).__name__})"]
    return f"{', '.join(causes)}: no slope here, nor while moving"
