"""What a law remembers of the error: copies of what makes demands and loads, sampled."""

import math
from typing import NamedTuple

import numpy as np

from hydroservo.control.synthesis.matrix import Matrix


class ErrorMemory(NamedTuple):
    """m := F m + b e from one sample to the next, with e = x1 - r."""

    transition: Matrix  # F, shape (n, n)
    driven: Matrix  # b [s], shape (n,)
    rates: Matrix  # the error that a metre of each number counts for [1/s], shape (n,)


NOTHING = ErrorMemory(np.zeros((0, 0)), np.zeros(0), np.zeros(0))


def integrator(rate: float, period: float) -> ErrorMemory:
    """The error summed up: m := m + h e."""
    return ErrorMemory(np.ones((1, 1)), np.array([period]), np.array([rate]))


def oscillator(rate: float, frequency: float, period: float) -> ErrorMemory:
    """The error driving an oscillator: m := R (m + [0, h e]), with R the rotation by 2 pi f h.

    A rotation is the oscillator's exact transition, so that its poles lie on the unit circle and what it
    makes is a sine of just that frequency; Euler's method has them outside.

    Args:
        rate: the error that a metre of it counts for [1/s].
        frequency: f [Hz].
        period: h [s].
    """
    angle = 2.0 * math.pi * frequency * period
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    return ErrorMemory(turn, turn[:, 1] * period, np.array([rate, rate]))


def both(one: ErrorMemory, other: ErrorMemory) -> ErrorMemory:
    """Two memories of the same error side by side."""
    size, more = len(one.transition), len(other.transition)
    transition = np.zeros((size + more, size + more))
    transition[:size, :size], transition[size:, size:] = one.transition, other.transition
    return ErrorMemory(
        transition, np.concatenate([one.driven, other.driven]), np.concatenate([one.rates, other.rates])
    )


def remembering(transition: Matrix, driven: Matrix, memory: ErrorMemory) -> tuple[Matrix, Matrix]:
    """A sampled plant with a memory of its first state, each number of it in units that count as an error.

    Args:
        transition: of the plant, shape (n, n).
        driven: what a held command adds, shape (n,).
        memory: of m numbers.

    Returns:
        Transition and input of [x, m], shapes (n + m, n + m) and (n + m,).
    """
    size, more = len(transition), len(memory.transition)
    joined = np.zeros((size + more, size + more))
    joined[:size, :size] = transition
    joined[size:, 0] = memory.rates * memory.driven
    joined[size:, size:] = memory.transition * memory.rates[:, np.newaxis] / memory.rates
    return joined, np.concatenate([driven, np.zeros(more)])
