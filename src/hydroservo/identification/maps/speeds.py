"""The speeds at which a machine moved, and what friction at them alone tells."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.formatting import MINUS, quantity
from hydroservo.identification.maps.result import Interval
from hydroservo.identification.uncertainty import NORMAL

ALIKE = 1.1  # times a speed, up to which another is the same

Samples = NDArray[np.float64]


class Speeds(NamedTuple):
    """Friction at each speed, moves that are as fast and go the same way taken together.

    Attributes:
        velocity: [m/s], shape (n,).
        friction: [N], shape (n,).
        deviation: of the friction, its standard deviation [N], shape (n,).
    """

    velocity: Samples
    friction: Samples
    deviation: Samples


def speeds_of(points: Speeds, alike: float = ALIKE) -> Speeds:
    """The means of points that are alike.

    Repetitions share what makes a machine's friction differ along its stroke, so that their mean is no surer
    than one of them; what they scatter counts besides.

    Args:
        points: of a move each.
        alike: times a speed, up to which another is the same.
    """
    rows = []
    for part in parts_of(points.velocity, alike):
        velocity, force, deviation = (row[part] for row in points)
        scatter = float(force.var(ddof=1)) if force.size > 1 else 0.0
        weights = 1.0 / (deviation**2 + max(scatter - float(np.mean(deviation**2)), 0.0))
        middles = (float(np.average(row, weights=weights)) for row in (velocity, force))
        own = 1.0 / float(np.mean(1.0 / deviation**2))
        rows.append((*middles, float(np.sqrt(own + scatter / force.size))))
    return Speeds(*np.array(rows).T)


def parts_of(velocity: Samples, alike: float) -> Iterator[NDArray[np.intp]]:
    """The numbers of the points that are alike."""
    for sign in (-1.0, 1.0):
        rest = np.flatnonzero(sign * velocity > 0.0)
        rest = rest[np.argsort(np.abs(velocity[rest]), kind="stable")]
        while rest.size:
            near = np.abs(velocity[rest]) <= alike * abs(velocity[rest[0]])
            yield rest[near]
            rest = rest[~near]


def count_of(velocity: Samples) -> int:
    """How many speeds there are, whichever way they go."""
    return len([*parts_of(np.abs(velocity), ALIKE)])


def range_of(velocity: Samples) -> float:
    """How many times the least speed the largest is, of the direction in which that is more."""
    ways = (np.abs(velocity[sign * velocity > 0.0]) for sign in (-1.0, 1.0))
    return max(float(way.max() / way.min()) for way in ways if way.size)


def sum_at(points: Speeds) -> Interval | None:
    """Coulomb and viscous friction together, at the mean of the speeds: of a law of both, exactly.

    None where it is below 0, which is no friction. Of moves one way only a constant force is in it.

    Args:
        points: of a move each.
    """
    way = speeds_of(points, np.inf)
    speed = quantity(float(np.abs(way.velocity).mean()), "m/s").replace(MINUS, "-")
    middle, half = float((np.sign(way.velocity) * way.friction).mean()), NORMAL * float(way.deviation.mean())
    if way.velocity.size < 2:
        meaning = f"Coulomb and viscous friction and any constant force together at {speed}"
        return Interval.around(middle, half, "N", meaning)
    both = Interval.around(middle, half, "N", f"Coulomb and viscous friction together at {speed}")
    return both.at_least_0() if both.high > 0.0 else None
