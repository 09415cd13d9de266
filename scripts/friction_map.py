"""Friction against velocity, from moves of a machine."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Samples = NDArray[np.float64]


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
