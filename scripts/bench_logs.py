"""Friction and displacement of a machine on a bench from one log, and how far they hold in another.

Read by the page on bench logs, which shows what is computed here. The logs and their licence are in
examples/bench.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from hydroservo.scenario.quantities import unit_factor
from hydroservo.scenario.records.columns import name_and_unit

FOLDER = Path(__file__).resolve().parents[1] / "examples" / "bench"
UNITS = {"s": "s", "inch/s": "m/s", "psi": "Pa", "lbf": "N", "A": "A"}
INCH = 0.0254
AREA = 1.375 * INCH**2  # m^2, of the piston, as published
PUBLISHED_DISPLACEMENT = 0.30  # inch^3/rev
TORQUE_CONSTANT, EFFICIENCY = 0.438, 0.8  # N m/A, as published
MOTOR_FRICTION = (0.1596, 0.12897e-3)  # N m and N m/rpm, as published
SPEEDS = (0.01, 0.05, 0.1, 0.2, 0.4, 0.7)  # m/s
OUTWARDS = ((0.0, 0.01, 0.05, 0.1, 0.4, 5.0), (0.0, 550.0, 750.0, 1000.0, 2900.0, 32033.0))  # as published
INWARDS = (OUTWARDS[0], (0.0, 160.0, 400.0, 700.0, 1200.0, 12750.0))
SLOW = 0.004  # m/s, below which the rod may stick and no friction map says anything

Samples = NDArray[np.float64]
Log = Mapping[str, Samples]


class FrictionMap(NamedTuple):
    """Friction at some speeds, joined by straight lines and held beyond the ends.

    Attributes:
        speeds: |v| at the knots [m/s], increasing.
        forwards: friction with v > 0 there [N].
        backwards: friction with v < 0 there, against motion too [N].
        besides: factors of what else the force consists of.
    """

    speeds: Samples
    forwards: Samples
    backwards: Samples
    besides: Samples

    def at(self, velocity: ArrayLike) -> Samples:
        """Friction against motion, of the sign of the velocity [N].

        Args:
            velocity: [m/s], any shape.
        """
        v = np.asarray(velocity, dtype=np.float64)
        forth, back = (np.interp(np.abs(v), self.speeds, row) for row in (self.forwards, self.backwards))
        return np.where(v > 0.0, forth, -back)


class Fitted(NamedTuple):
    """What one log gives.

    Attributes:
        displacement: of the hydraulic motor [inch^3/rev], that of a piston of the published area.
        friction: of the rod, with the areas of both gas springs and a constant beside it.
        pressure: difference by current [Pa/A], direction [Pa] and speed of the motor [Pa s].
    """

    displacement: float
    friction: FrictionMap
    pressure: Samples


def read(name: str) -> dict[str, Samples]:
    """A log in SI units, but for the motor's speed in revolutions a second."""
    table = pd.read_csv(FOLDER / name)
    found = {}
    for header in table:
        signal, unit = name_and_unit(str(header))
        factor = 1.0 / 60.0 if unit == "rpm" else float(unit_factor(unit, UNITS[unit]))
        found[signal] = factor * table[header].to_numpy()
    return found


def with_signs(log: Log) -> dict[str, Samples]:
    """A log with the sign of the lower chamber's pressure with which that explains the force.

    One of the logs has it inverted.
    """
    both = [{**log, "lower": sign * log["lower"]} for sign in (1.0, -1.0)]
    return min(both, key=lambda one: float(np.std(force_without_friction(one))))


def drop(log: Log) -> Samples:
    """The difference of both chambers' pressures [Pa]."""
    return log["lower"] - log["upper"]


def springs(log: Log) -> Samples:
    """The pressures of both gas springs, and a column of ones."""
    return np.stack([log["lower spring"], -log["upper spring"], np.ones(log["time"].size)], axis=1)


def force_without_friction(log: Log) -> Samples:
    """What of the force pressures and springs do not explain [N]."""
    design = np.hstack([drop(log)[:, np.newaxis], springs(log)])
    return np.asarray(log["force"] - design @ np.linalg.lstsq(design, log["force"], rcond=None)[0])


def of_motor(log: Log) -> Samples:
    """Current, direction and speed of the motor."""
    turning = np.sign(log["speed"]) * (np.abs(log["speed"]) > 1.0)
    return np.stack([log["current"], turning, log["speed"]], axis=1)


def fitted(log: Log) -> Fitted:
    """What a log gives."""
    force = log["force"] - AREA * drop(log)
    friction = evened(friction_map(log["velocity"], force, SPEEDS, springs(log)[:, :2]))
    pressure = np.linalg.lstsq(of_motor(log), drop(log), rcond=None)[0]
    return Fitted(displacement(log), friction, pressure)


def displacement(log: Log) -> float:
    """Of the motor [inch^3/rev], which takes what a piston of the published area sweeps."""
    return float(AREA * abs(log["velocity"] @ log["speed"]) / (log["speed"] @ log["speed"]) / INCH**3)


def evened(friction: FrictionMap) -> FrictionMap:
    """A map with a constant force taken out: that which makes friction at the least speed alike both ways."""
    constant = 0.5 * (friction.forwards[0] - friction.backwards[0])
    besides = np.append(friction.besides, constant)
    return FrictionMap(friction.speeds, friction.forwards - constant, friction.backwards + constant, besides)


def published_friction(velocity: Samples) -> Samples:
    """The published table's friction against motion, of the sign of the velocity [N]."""
    forth, back = (np.interp(np.abs(velocity), *one) for one in (OUTWARDS, INWARDS))
    return np.where(velocity > 0.0, forth, -back)


def published(log: Log) -> Fitted:
    """The published numbers, with springs from a log: their areas are not among these."""
    moving = np.abs(log["velocity"]) > SLOW
    rest = log["force"] - AREA * drop(log) - published_friction(log["velocity"])
    areas = np.linalg.lstsq(springs(log)[moving], rest[moving], rcond=None)[0]
    table = FrictionMap(*map(np.array, (OUTWARDS[0], OUTWARDS[1], INWARDS[1])), areas)
    scale = 2.0 * np.pi / (PUBLISHED_DISPLACEMENT * INCH**3 * EFFICIENCY)
    torques = (TORQUE_CONSTANT, -MOTOR_FRICTION[0], -60.0 * MOTOR_FRICTION[1])
    return Fitted(PUBLISHED_DISPLACEMENT, table, scale * np.array(torques))


def errors(one: Fitted, log: Log) -> dict[str, float]:
    """Root mean squares of what is missed: of the force [N] and of the pressures' difference [Pa]."""
    moving = np.abs(log["velocity"]) > SLOW
    known = springs(log) @ one.friction.besides + one.friction.at(log["velocity"])
    force = log["force"] - AREA * drop(log) - known
    pressure = drop(log) - of_motor(log) @ one.pressure
    return {"force": rms(force[moving]), "pressure": rms(pressure)}


def rms(values: Samples) -> float:
    return float(np.sqrt(np.mean(values**2)))


def logs() -> tuple[dict[str, Samples], dict[str, Samples]]:
    """The log that is fitted, and the other."""
    moves, waves = (with_signs(read(name)) for name in ("friction_moves.csv", "waves.csv"))
    return moves, waves


def error_rows() -> Iterator[tuple[Any, ...]]:
    """Of each log and source of numbers the errors, with the spread of what is met."""
    moves, waves = logs()
    for label, log in (("friction moves, fitted", moves), ("waves, not fitted", waves)):
        here, there = (errors(one, log) for one in (fitted(moves), published(moves)))
        spread = float(np.std(log["force"])), float(np.std(drop(log)))
        yield (
            label,
            *(f"{x:.0f} N" for x in (here["force"], there["force"], spread[0])),
            *(f"{1e-5 * x:.1f} bar" for x in (here["pressure"], there["pressure"], spread[1])),
        )


def friction_rows() -> Iterator[tuple[Any, ...]]:
    """Friction at each speed, found and published."""
    found = fitted(logs()[0]).friction
    for v, forth, back in zip(found.speeds, found.forwards, found.backwards, strict=True):
        theirs = [abs(float(published_friction(np.array([sign * v]))[0])) for sign in (1.0, -1.0)]
        yield f"{1e3 * v:.0f} mm/s", *(f"{x:.0f} N" for x in (forth, theirs[0], back, theirs[1]))


def friction_map(
    velocity: ArrayLike, force: ArrayLike, speeds: ArrayLike, besides: ArrayLike | None = None
) -> FrictionMap:
    """The friction of a machine that moves, at some speeds and in both directions, by least squares::

        F = sum of c_i b_i + friction(v)

    Samples slower than half of the least speed tell of sticking rather than of friction, and are left out.

    Args:
        velocity: v [m/s], shape (n,).
        force: that moves it, along v, without inertia [N], shape (n,).
        speeds: at which friction is asked for, more than 0 and increasing [m/s], shape (m,).
        besides: what else is in the force with a factor that is not known, such as the pressures of springs,
            shape (n, k).

    Raises:
        ValueError: no samples tell the columns apart.

    Source: linear least squares in hat functions; de Boor, A Practical Guide to Splines, 2001, ch. 3.
    Fails to tell a constant force from friction that differs between the directions; where the machine
    accelerates and inertia is not taken off; and at speeds between which no move was.
    """
    v, f, knots = (np.asarray(one, dtype=np.float64) for one in (velocity, force, speeds))
    other = np.zeros((v.size, 0)) if besides is None else np.asarray(besides, dtype=np.float64)
    moving = np.abs(v) > 0.5 * knots[0]
    design = np.hstack([hats(v, knots), -hats(-v, knots), other])[moving]
    scale = np.maximum(np.abs(design).max(axis=0), 1e-300)
    found, _, rank, _ = np.linalg.lstsq(design / scale, f[moving], rcond=1e-9)
    if rank < design.shape[1]:
        raise ValueError("the moves are not at all speeds, or something besides says what friction says too")
    found /= scale
    forwards, backwards, factors = np.split(found, [knots.size, 2 * knots.size])
    return FrictionMap(knots, forwards, backwards, factors)


def hats(v: Samples, knots: Samples) -> Samples:
    """The weight of each knot in friction with v > 0, shape (n, knots)."""
    weights = [np.interp(v, knots, row) for row in np.eye(knots.size)]
    return np.where(v[:, np.newaxis] > 0.0, np.stack(weights, axis=1), 0.0)
