"""Coulomb, viscous and Stribeck friction through points of a friction map."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.formatting import plain_quantity
from hydroservo.identification.maps.result import Interval
from hydroservo.identification.regression import NORMAL

ALIKE = 1.1  # times a speed, up to which another is the same

Samples = NDArray[np.float64]
SIGNIFICANT = 0.01  # the chance of a fall with speed being seen where there is none
POSSIBLE = 0.05  # the chance of points at which a law looks impossible that is not
UNSEEN = "no fall of friction with speed is seen"
UNSURE = "a fall of friction with speed is seen, but at too few slow speeds"
FEWEST = 5  # speeds, from which on a fall, of four numbers with Coulomb and viscous friction, is sought
SLOWEST = 0.3  # of the least speed, from which on a Stribeck velocity is sought
END = 1.02  # times an end of that range, within which one is at the end


class Speeds(NamedTuple):
    """Friction at each speed, moves that are as fast and go the same way taken together."""

    velocity: Samples  # [m/s], shape (n,)
    friction: Samples  # [N], shape (n,)
    deviation: Samples  # of the friction, its standard deviation [N], shape (n,)


def speeds_of(points: Speeds, alike: float = ALIKE) -> Speeds:
    """The means of points that are alike.

    Repetitions share what makes a machine's friction differ along its stroke, so that their mean is no surer
    than one of them; what they scatter counts besides.
    """
    rows = []
    for part in alike_points(points.velocity, alike):
        velocity, force, deviation = (row[part] for row in points)
        scatter = float(force.var(ddof=1)) if force.size > 1 else 0.0
        weights = 1.0 / (deviation**2 + max(scatter - float(np.mean(deviation**2)), 0.0))
        middles = (float(np.average(row, weights=weights)) for row in (velocity, force))
        own = 1.0 / float(np.mean(1.0 / deviation**2))
        rows.append((*middles, float(np.sqrt(own + scatter / force.size))))
    return Speeds(*np.array(rows).T)


def alike_points(velocity: Samples, alike: float) -> Iterator[NDArray[np.intp]]:
    """The numbers of the points that are alike."""
    for sign in (-1.0, 1.0):
        rest = np.flatnonzero(sign * velocity > 0.0)
        rest = rest[np.argsort(np.abs(velocity[rest]), kind="stable")]
        while rest.size:
            near = np.abs(velocity[rest]) <= alike * abs(velocity[rest[0]])
            yield rest[near]
            rest = rest[~near]


def speed_ratio(velocity: Samples) -> float:
    """How many times the least speed the largest is, of the direction in which that is more."""
    ways = (np.abs(velocity[sign * velocity > 0.0]) for sign in (-1.0, 1.0))
    return max(float(way.max() / way.min()) for way in ways if way.size)


def friction_sum_at(points: Speeds) -> Interval | None:
    """Coulomb and viscous friction together, at the mean of the speeds: of a law of both, exactly.

    None where it is below 0, which is no friction. Of moves one way only a constant force is in it.
    """
    way = speeds_of(points, np.inf)
    speed = plain_quantity(float(np.abs(way.velocity).mean()), "m/s")
    middle, half = float((np.sign(way.velocity) * way.friction).mean()), NORMAL * float(way.deviation.mean())
    if way.velocity.size < 2:
        meaning = f"Coulomb and viscous friction and any constant force together at {speed}"
        return Interval.around(middle, half, "N", meaning)
    both = Interval.around(middle, half, "N", f"Coulomb and viscous friction together at {speed}")
    return both.at_least_0() if both.high > 0.0 else None


class FrictionFit(NamedTuple):
    """A law of friction through points."""

    # coulomb, viscous, offset where both directions are there, and breakaway and stribeck_velocity where the
    # fall with speed is seen; none where no such law can be
    numbers: dict[str, Interval]
    gaussian: bool  # whether the fall with speed is that of LuGre
    remarks: list[str]  # what a user should know

    def at(self, velocity: Samples) -> Samples:
        """Friction [N], with the offset."""
        values = {name: one.value for name, one in self.numbers.items()}
        fall = values.get("breakaway", values["coulomb"]) - values["coulomb"]
        dry = values["coulomb"] + fall * stribeck_fall(
            velocity, values.get("stribeck_velocity", 1.0), self.gaussian
        )
        offset = values.get("offset", 0.0)
        found: Samples = np.sign(velocity) * dry + values["viscous"] * velocity + offset
        return found


def fitted_friction(velocity: Samples, friction: Samples, deviation: Samples, gaussian: bool) -> FrictionFit:
    """The law through the points of a map::

        F = sgn(v) (F_c + (F_s - F_c) g(v)) + b v + F_0
        g = 1/(1 + (v/v_s)^2), as Stribeck has it, or e^(-(v/v_s)^2), as LuGre has it

    F_c, F_s - F_c and b are at least 0. The fall g is left out where an F test does not see it with a chance
    of error below 1 %, where v_s may be 0 or lies beyond the speeds of the points, or where these are fewer
    than five, whichever way they go.

    Source: Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994 (the law); an F test of nested
    models, as in Draper and Smith, Applied Regression Analysis, 1998, ch. 6.
    Fails where friction differs between directions by more than a constant, or depends on load or position.
    """
    from scipy.special import fdtrc

    both = (velocity > 0.0).any() and (velocity < 0.0).any()
    remarks = [] if both else ["all moves go one way: a constant force counts as Coulomb friction"]
    columns = [np.sign(velocity), velocity, *([np.ones(velocity.size)] if both else [])]
    design, aim = np.stack(columns, axis=1) / deviation[:, np.newaxis], friction / deviation
    least = np.array([0.0, 0.0, -np.inf])[: len(columns)]
    plain, left_plain = bounded_fit(design, aim, least)
    names = ["coulomb", "viscous", *(["offset"] if both else [])]
    freedom, fall = velocity.size - len(names) - 2, UNSEEN
    if freedom > 0 and len([*alike_points(np.abs(velocity), ALIKE)]) >= FEWEST:  # whichever way they go
        falls = fit_fall(velocity, design, aim, deviation, gaussian, least)
        ratio = (left_plain - falls[1]) / 2.0 / max(falls[1] / freedom, 1e-300)
        if falls[0][-2] > 0.0 and fdtrc(2, freedom, ratio) < SIGNIFICANT:
            law = law_with_fall(falls, velocity, design, deviation, names, gaussian, remarks)
            if law.numbers["stribeck_velocity"].low > 0.0 and is_inside(falls[0][-1], velocity):
                return law
            fall = UNSURE
    freedom = max(velocity.size - len(names), 1)
    if is_forbidden(design, aim, left_plain, freedom):
        way = "rises faster than" if plain[0] <= 0.0 else "falls with"
        remark = f"friction {way} speed, unlike any Coulomb and viscous friction: neither is given"
        return FrictionFit({}, gaussian, [*remarks, remark])
    remarks.append(f"{fall}: breakaway and Stribeck velocity cannot be determined")
    scaled = max(left_plain / freedom, 1.0)
    covariance: Samples = np.asarray(scaled * np.linalg.inv(design.T @ design), dtype=np.float64)
    numbers = intervals(names, plain, covariance, freedom)
    return FrictionFit(numbers, gaussian, [*remarks, *bound_remarks(numbers)])


def bounded_fit(design: Samples, aim: Samples, least: Samples) -> tuple[Samples, float]:
    """The coefficients of columns, at least as large as they must be, and the squares that they leave."""
    from scipy.optimize import lsq_linear

    scale = np.abs(design).max(axis=0)
    best = np.linalg.lstsq(design / scale, aim, rcond=None)[0]
    if (best < least).any():
        best = lsq_linear(design / scale, aim, (least, np.inf), method="bvls").x
    return best / scale, float(np.sum((aim - design / scale @ best) ** 2))


def is_forbidden(design: Samples, aim: Samples, left: float, freedom: int) -> bool:
    """Whether the best coefficients are too small by more than chance: a t test, as F(1, n) = t^2."""
    from scipy.special import fdtrc

    best = float(np.sum((aim - design @ np.linalg.lstsq(design, aim, rcond=None)[0]) ** 2))
    return bool(fdtrc(1, freedom, (left - best) / max(best / freedom, 1.0)) < POSSIBLE)


def bound_remarks(numbers: Mapping[str, Interval]) -> list[str]:
    """Which numbers are held at 0."""
    return [
        f"{name} is held at 0, its least possible value: another law may fit the points better"
        for name in ("coulomb", "viscous")
        if numbers[name].value <= 0.0
    ]


def stribeck_fall(velocity: Samples, stribeck_velocity: float, gaussian: bool) -> Samples:
    """g(v), 1 at rest and 0 far above the Stribeck velocity."""
    squares: Samples = (velocity / stribeck_velocity) ** 2
    return np.exp(-squares) if gaussian else 1.0 / (1.0 + squares)


def fit_fall(
    velocity: Samples, design: Samples, aim: Samples, deviation: Samples, gaussian: bool, least: Samples
) -> tuple[Samples, float]:
    """The coefficients of all columns with the fall's, its Stribeck velocity last; and the squares left."""
    from scipy.optimize import minimize_scalar

    speeds = np.abs(velocity)

    def solved(logarithm: float) -> tuple[Samples, float]:
        column = np.sign(velocity) * stribeck_fall(velocity, float(np.exp(logarithm)), gaussian) / deviation
        best, left = bounded_fit(np.column_stack([design, column]), aim, np.append(least, 0.0))
        return np.append(best, np.exp(logarithm)), left

    ends = np.log(SLOWEST * speeds.min()), np.log(speeds.max())
    grid = np.linspace(*ends, 60)
    best = int(np.argmin([solved(one)[1] for one in grid]))
    around = grid[max(best - 1, 0)], grid[min(best + 1, grid.size - 1)]
    found = minimize_scalar(
        lambda one: solved(one)[1], bounds=around, method="bounded", options={"xatol": 1e-9}
    )
    return solved(float(found.x))


def is_inside(stribeck_velocity: float, velocity: Samples) -> bool:
    """Whether a Stribeck velocity lies inside the range that was searched."""
    speeds = np.abs(velocity)
    return bool(SLOWEST * speeds.min() * END < stribeck_velocity < speeds.max() / END)


def law_with_fall(
    falls: tuple[Samples, float],
    velocity: Samples,
    design: Samples,
    deviation: Samples,
    names: list[str],
    gaussian: bool,
    remarks: list[str],
) -> FrictionFit:
    """The law with its fall, and intervals from the slopes at the optimum."""
    *values, fall, v_s = falls[0].tolist()
    step = 1e-4 * v_s
    column = np.sign(velocity) * stribeck_fall(velocity, v_s, gaussian) / deviation
    higher, lower = (stribeck_fall(velocity, v_s + one, gaussian) for one in (step, -step))
    slope = fall * np.sign(velocity) * (higher - lower) / (2.0 * step) / deviation
    jacobian = np.column_stack([design, column, slope])
    freedom = velocity.size - jacobian.shape[1]
    covariance = max(falls[1] / freedom, 1.0) * np.linalg.pinv(jacobian.T @ jacobian)
    # F_s is the sum of F_c and the fall
    turn = np.eye(jacobian.shape[1])
    turn[-2, 0] = 1.0
    every = [*names, "breakaway", "stribeck_velocity"]
    found = np.array([*values, values[0] + fall, v_s])
    numbers = intervals(every, found, turn @ covariance @ turn.T, freedom)
    return FrictionFit(numbers, gaussian, [*remarks, *bound_remarks(numbers)])


def intervals(names: list[str], values: Samples, covariance: Samples, freedom: int) -> dict[str, Interval]:
    """Numbers with their intervals, of Student's distribution, without what is impossible."""
    from scipy.special import stdtrit

    about = {
        "coulomb": ("N", "Coulomb friction"),
        "viscous": ("N s/m", "viscous damping coefficient"),
        "offset": ("N", "constant force, as a weight or a sensor's zero"),
        "breakaway": ("N", "friction towards rest, as the fall goes on"),
        "stribeck_velocity": ("m/s", "Stribeck velocity"),
    }
    half = float(stdtrit(max(freedom, 1), 0.975)) * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    every = zip(names, values.tolist(), half.tolist(), strict=True)
    numbers = {name: Interval.around(value, width, *about[name]) for name, value, width in every}
    return {name: one if name == "offset" else one.at_least_0() for name, one in numbers.items()}
