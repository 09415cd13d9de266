"""Coulomb, viscous and Stribeck friction through points of a friction map."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.identification.maps.result import Interval

__all__ = ["FrictionFit", "fitted_friction"]

SIGNIFICANT = 0.01  # the chance of a fall with speed being seen where there is none

Samples = NDArray[np.float64]


class FrictionFit(NamedTuple):
    """A law of friction through points.

    Attributes:
        numbers: coulomb, viscous, offset where both directions are there, and breakaway and
            stribeck_velocity where the fall with speed is seen.
        gaussian: whether the fall with speed is that of LuGre.
        remarks: what a user should know.
    """

    numbers: dict[str, Interval]
    gaussian: bool
    remarks: list[str]

    def at(self, velocity: Samples) -> Samples:
        """Friction [N], with the offset."""
        values = {name: one.value for name, one in self.numbers.items()}
        fall = values.get("breakaway", values["coulomb"]) - values["coulomb"]
        dry = values["coulomb"] + fall * falling(
            velocity, values.get("stribeck_velocity", 1.0), self.gaussian
        )
        offset = values.get("offset", 0.0)
        found: Samples = np.sign(velocity) * dry + values["viscous"] * velocity + offset
        return found


def fitted_friction(velocity: Samples, friction: Samples, deviation: Samples, gaussian: bool) -> FrictionFit:
    """The law through the points of a map::

        F = sgn(v) (F_c + (F_s - F_c) g(v)) + b v + F_0
        g = 1/(1 + (v/v_s)^2), as Stribeck has it, or e^(-(v/v_s)^2), as LuGre has it

    The fall g is left out where an F test does not see it with a chance of error below 1 %.

    Args:
        velocity: of each point [m/s], shape (n,).
        friction: [N], shape (n,).
        deviation: of each, its standard deviation [N], above 0.
        gaussian: whether the fall is that of LuGre.

    Source: Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994 (the law); an F test of nested
    models, as in Draper and Smith, Applied Regression Analysis, 1998, ch. 6.
    Fails where friction differs between directions by more than a constant, or depends on load or position.
    """
    from scipy.stats import f as f_distribution

    both = (velocity > 0.0).any() and (velocity < 0.0).any()
    remarks = [] if both else ["all moves go one way: a constant force counts as Coulomb friction"]
    columns = [np.sign(velocity), velocity, *([np.ones(velocity.size)] if both else [])]
    design, aim = np.stack(columns, axis=1) / deviation[:, np.newaxis], friction / deviation
    plain: Samples = np.asarray(np.linalg.lstsq(design, aim, rcond=None)[0], dtype=np.float64)
    names = ["coulomb", "viscous", *(["offset"] if both else [])]
    left_plain = float(np.sum((aim - design @ plain) ** 2))
    freedom = velocity.size - len(names) - 2
    if freedom > 0:
        falls = fall_found(velocity, design, aim, deviation, gaussian)
        ratio = (left_plain - falls[1]) / 2.0 / max(falls[1] / freedom, 1e-300)
        if falls[0][-2] > 0.0 and f_distribution.sf(ratio, 2, freedom) < SIGNIFICANT:
            return with_fall(falls, velocity, design, deviation, names, gaussian, remarks)
    remarks.append("no fall of friction with speed is seen: breakaway and Stribeck velocity are not told")
    scaled = max(left_plain / max(velocity.size - len(names), 1), 1.0)
    covariance: Samples = np.asarray(scaled * np.linalg.inv(design.T @ design), dtype=np.float64)
    numbers = intervals(names, plain, covariance, velocity.size - len(names))
    return FrictionFit(numbers, gaussian, remarks)


def falling(velocity: Samples, stribeck_velocity: float, gaussian: bool) -> Samples:
    """g(v), 1 at rest and 0 far above the Stribeck velocity."""
    squares: Samples = (velocity / stribeck_velocity) ** 2
    return np.exp(-squares) if gaussian else 1.0 / (1.0 + squares)


def fall_found(
    velocity: Samples, design: Samples, aim: Samples, deviation: Samples, gaussian: bool
) -> tuple[Samples, float]:
    """The coefficients of all columns with the fall's, its Stribeck velocity last; and the squares left."""
    from scipy.optimize import minimize_scalar

    speeds = np.abs(velocity)

    def solved(logarithm: float) -> tuple[Samples, float]:
        column = np.sign(velocity) * falling(velocity, float(np.exp(logarithm)), gaussian) / deviation
        full = np.column_stack([design, column])
        found = np.linalg.lstsq(full, aim, rcond=None)[0]
        return np.append(found, np.exp(logarithm)), float(np.sum((aim - full @ found) ** 2))

    ends = np.log(0.3 * speeds.min()), np.log(speeds.max())
    grid = np.linspace(*ends, 60)
    best = int(np.argmin([solved(one)[1] for one in grid]))
    around = grid[max(best - 1, 0)], grid[min(best + 1, grid.size - 1)]
    found = minimize_scalar(
        lambda one: solved(one)[1], bounds=around, method="bounded", options={"xatol": 1e-9}
    )
    return solved(float(found.x))


def with_fall(
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
    column = np.sign(velocity) * falling(velocity, v_s, gaussian) / deviation
    higher, lower = (falling(velocity, v_s + one, gaussian) for one in (step, -step))
    slope = fall * np.sign(velocity) * (higher - lower) / (2.0 * step) / deviation
    jacobian = np.column_stack([design, column, slope])
    freedom = velocity.size - jacobian.shape[1]
    covariance = max(falls[1] / freedom, 1.0) * np.linalg.pinv(jacobian.T @ jacobian)
    # F_s is the sum of F_c and the fall
    turn = np.eye(jacobian.shape[1])
    turn[-2, 0] = 1.0
    every = [*names, "breakaway", "stribeck_velocity"]
    found = np.array([*values, values[0] + fall, v_s])
    return FrictionFit(intervals(every, found, turn @ covariance @ turn.T, freedom), gaussian, remarks)


def intervals(names: list[str], values: Samples, covariance: Samples, freedom: int) -> dict[str, Interval]:
    """Numbers with their intervals, of Student's distribution."""
    from scipy.stats import t as student

    about = {
        "coulomb": ("N", "Coulomb friction"),
        "viscous": ("N s/m", "viscous damping coefficient"),
        "offset": ("N", "constant force, as a weight or a sensor's zero"),
        "breakaway": ("N", "friction towards rest, as the fall goes on"),
        "stribeck_velocity": ("m/s", "Stribeck velocity"),
    }
    half = float(student.ppf(0.975, max(freedom, 1))) * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    every = zip(names, values.tolist(), half.tolist(), strict=True)
    return {name: Interval.around(value, width, *about[name]) for name, value, width in every}
