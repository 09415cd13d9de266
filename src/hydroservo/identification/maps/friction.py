"""Friction against velocity, from moves at constant speed."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.errors import ScenarioError
from hydroservo.identification.log import EXTERNAL_FORCE
from hydroservo.identification.maps.friction_law import (
    FrictionFit,
    Speeds,
    fitted_friction,
    friction_sum_at,
    speed_ratio,
    speeds_of,
)
from hydroservo.identification.maps.piston import (
    Piston,
    SteadyStretch,
    longest_stretch,
    require_signals,
    steady_stretches,
)
from hydroservo.identification.maps.result import DrawnLine, Interval, MapContents, curve_of
from hydroservo.identification.regression import NORMAL, mean_with_interval, thin_out
from hydroservo.identification.segments import Segment, UnderstoodLog
from hydroservo.machine.mechanics import ElastoPlastic, LuGre

if TYPE_CHECKING:
    import xarray as xr

NARROW = 1.5  # times the least speed, up to which the largest tells no law
LEAST_SHARE = 1e-3  # of the largest friction, that any point's deviation is taken for at least
PER_BLOCK = 2000  # samples of a stretch from which its mean is taken
BLOCKS = 8  # of a stretch, by which friction is seen to change along it

Samples = NDArray[np.float64]


class FrictionPoint(NamedTuple):
    """A stretch of constant speed: columns of the curve."""

    velocity: float
    friction: float
    friction_deviation: float
    friction_half: float
    start: float
    duration: float


def friction_map(logs: Sequence[UnderstoodLog], loop: Loop | None, piston: Piston | None) -> MapContents:
    """The friction of a piston at the speeds at which it moves steadily::

        friction = A_A p_A - A_B p_B - resistance of the mechanism - external force - M dv/dt

    A recorded force at the rod counts in place of resistance and external force; where neither was recorded,
    the scenario's load does. Through the points goes the law that
    :func:`~hydroservo.identification.maps.friction_law.fitted_friction` says.

    Source: the balance of forces; Jelali and Kroll, Hydraulic Servo-systems, 2003, ch. 4 (friction from
    moves of constant speed).
    Fails to tell a constant force from friction that differs between the directions, and below the speeds at
    which the machine sticks and slips.
    """
    points: list[FrictionPoint] = []
    for log in logs:
        check_friction_signals(log, piston)
        for one in log.segments:
            points += [friction_point(one, stretch, loop, piston) for stretch in steady_stretches(one)]
    points = [one for one in points if np.isfinite(one.friction)]
    name = logs[0].log.name
    if not points:
        longest = max(longest_stretch(one) for log in logs for one in log.segments)
        problem = (
            f"moves nowhere at a constant speed, within 5 % for a while: the longest lasts {longest:.3g} s"
        )
        raise ScenarioError(name, "", problem)
    columns = {
        key: np.array(row) for key, row in zip(FrictionPoint._fields, zip(*points, strict=True), strict=True)
    }
    law, numbers, remarks = law_of(columns, loop)
    lines = [] if law is None else list(law_lines(law, columns["velocity"]))
    values, left = ({}, []) if loop is None or not numbers else friction_values(numbers, loop)
    return MapContents(friction_curve(columns), numbers, lines, values, [*remarks, *left])


def check_friction_signals(log: UnderstoodLog, piston: Piston | None) -> None:
    """Refuse a log from which friction does not follow."""
    require_signals(log, ("velocity", "position"), "a friction map")
    if all("hydraulic_force" in one.measured for one in log.segments):
        return
    for name in ("pressure_a", "pressure_b"):
        require_signals(log, (name, "hydraulic_force"), "a friction map")
    if piston is None:
        raise ScenarioError(
            log.log.name, "", "has pressures and no hydraulic_force: give --scenario for the piston's areas"
        )


def friction_point(
    one: Segment, stretch: SteadyStretch, loop: Loop | None, piston: Piston | None
) -> FrictionPoint:
    """The friction of a stretch."""
    part = stretch.part
    time = one.time[part]
    position = float(np.nanmean(one.measured["position"][part])) if "position" in one.measured else None
    mass = piston_mass(piston, position)
    against = resisting_force(one, part, loop, piston, stretch.speed, position)
    driving: Samples = np.subtract(driving_force(one, part, piston), against)
    _, rows = thin_out(one.period, {"friction": driving}, PER_BLOCK)
    known = rows["friction"][np.isfinite(rows["friction"])]
    start, duration = float(time[0]), float(time[-1] - time[0])
    if known.size < 3:
        return FrictionPoint(stretch.speed, np.nan, np.nan, np.nan, start, duration)
    middle, _, half = mean_with_interval([known])
    unsure = drift_of(known, half / NORMAL), mass * stretch.deviation
    half = float(np.linalg.norm([half, *(NORMAL * one for one in unsure)]))
    spread = float(np.nanstd(driving, ddof=1))
    return FrictionPoint(stretch.speed, middle - mass * stretch.acceleration, spread, half, start, duration)


def drift_of(values: Samples, deviation: float) -> float:
    """The standard deviation of a change along a stretch beyond noise, as friction varies with position."""
    if values.size < 2 * BLOCKS:
        return 0.0
    means = np.array([one.mean() for one in np.array_split(values, BLOCKS)])
    return float(np.sqrt(max(means.var(ddof=1) - BLOCKS * deviation**2, 0.0)))


def driving_force(one: Segment, part: slice, piston: Piston | None) -> Samples:
    """A_A p_A - A_B p_B [N]."""
    if "hydraulic_force" in one.measured or piston is None:
        return one.measured["hydraulic_force"][part]
    a, b = (one.measured[name][part] for name in ("pressure_a", "pressure_b"))
    return piston.area_a * a - piston.area_b * b


def resisting_force(
    one: Segment, part: slice, loop: Loop | None, piston: Piston | None, speed: float, position: float | None
) -> Samples:
    """What the rod works against besides friction and inertia [N]."""
    if "force" in one.measured:
        return one.measured["force"][part]
    time = one.time[part]
    if EXTERNAL_FORCE in one.inputs:
        force = one.inputs[EXTERNAL_FORCE][part]
    elif loop is not None:
        force = np.array([loop.load.force(t) for t in time.tolist()])
    else:
        force = np.zeros(time.size)
    if piston is None:
        return force
    return force + piston.resistance(piston_place(piston, position), speed)


def piston_mass(piston: Piston | None, position: float | None) -> float:
    """The moving mass [kg]; 0 where none is known."""
    return 0.0 if piston is None else piston.inertia(piston_place(piston, position))


def piston_place(piston: Piston, position: float | None) -> float:
    """Where the piston is: as measured, or at its start [m]."""
    return float(piston.plant.start_position if position is None else position)


def law_of(
    columns: Mapping[str, Samples], loop: Loop | None
) -> tuple[FrictionFit | None, dict[str, Interval], list[str]]:
    """The law through the points, the numbers that they tell, and what there is to say of them."""
    force, half = columns["friction"], columns["friction_half"]
    deviation = np.maximum(np.where(np.isfinite(half), half, 0.0) / NORMAL, LEAST_SHARE * np.abs(force).max())
    points = Speeds(columns["velocity"], force, deviation)
    speeds = speeds_of(points)
    ways = np.unique(np.sign(speeds.velocity)).size
    if speed_ratio(speeds.velocity) < NARROW:
        each = " each way" if ways > 1 else ""
        why = f"all moves{each} are at one speed, or nearly; add moves at {NARROW} times that speed"
        return friction_sum(points, why)
    if speeds.velocity.size <= ways + 1:
        return None, {}, [f"moves at {speeds.velocity.size} speeds are too few for a law of friction"]
    gaussian = loop is not None and isinstance(friction_of(loop)[1], LuGre)
    law = fitted_friction(*speeds, gaussian)
    if not law.numbers:
        return None, {}, law.remarks
    if max(law.numbers[name].low for name in ("coulomb", "viscous")) > 0.0:
        return law, law.numbers, law.remarks
    return friction_sum(points, "either alone may be the friction of these moves")


def friction_sum(points: Speeds, why: str) -> tuple[None, dict[str, Interval], list[str]]:
    """The sum of Coulomb and viscous friction, where nothing tells them apart."""
    both = friction_sum_at(points)
    if both is None:
        return None, {}, ["the force acts along the motion, so it is not friction; check its sign"]
    problem = "Coulomb and viscous friction cannot be told apart, so only their sum is given"
    return None, {"friction": both}, [f"{problem}: {why}"]


def law_lines(law: FrictionFit, velocity: Samples) -> Iterator[DrawnLine]:
    """The law over the speeds that were moved at."""
    for sign in (-1.0, 1.0):
        speeds = np.abs(velocity[sign * velocity > 0.0])
        if speeds.size:
            v = sign * np.linspace(0.3 * speeds.min(), speeds.max(), 200)
            yield DrawnLine("law" if sign < 0.0 or not (velocity < 0.0).any() else "", v, law.at(v))


def friction_curve(columns: Mapping[str, Samples]) -> "xr.Dataset":
    """The points, in the order of their velocity."""
    order = np.argsort(columns["velocity"], kind="stable")
    about = {
        "velocity": ("m/s", "velocity"),
        "friction": ("N", "friction"),
        "friction_deviation": ("N", "standard deviation of samples"),
        "friction_half": ("N", "half of the 95 % interval"),
        "start": ("s", "start of the stretch"),
        "duration": ("s", "length of the stretch"),
    }
    return curve_of({name: row[order] for name, row in columns.items()}, about)


def friction_of(loop: Loop) -> tuple[str, Any]:
    """The path and the friction whose numbers a map finds: of an ElastoPlastic, the LuGre in it."""
    own: Any = getattr(loop.plant, "friction", None)
    if isinstance(own, ElastoPlastic):
        return "plant.friction.bristles", own.bristles
    return "plant.friction", own


def friction_values(numbers: Mapping[str, Interval], loop: Loop) -> tuple[dict[str, Interval], list[str]]:
    """The numbers of the scenario's friction, and what has no place in it."""
    if "viscous" not in numbers:
        return {}, ["the scenario keeps its own friction"]
    left = ["offset has no place in a scenario"] if "offset" in numbers else []
    path, own = friction_of(loop)
    if own is None:
        return {"plant.damping": numbers["viscous"]}, [*left, "the plant has viscous friction alone"]
    if not hasattr(own, "coulomb"):
        return {"plant.friction.coefficient": numbers["viscous"]}, [*left, "its friction is viscous alone"]
    names = ["coulomb", "breakaway", "stribeck_velocity"]
    found = {f"{path}.{name}": numbers[name] for name in names if name in numbers}
    held = f"{path}.breakaway"
    if held not in found and numbers["coulomb"].value > own.breakaway:
        found[held] = numbers["coulomb"]
    if held in found and found[held].value >= own.coulomb:  # first, as no step may hold less than it brakes
        found = {held: found.pop(held), **found}
    found[f"{path}.viscous"] = numbers["viscous"]
    return found, left
