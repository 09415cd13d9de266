"""Samples beyond those of a closed loop, to reach what that never does."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hydroservo.export.c.vectors import HUGE

Rows = NDArray[np.float64]

BEYOND = (math.nan, math.inf, -math.inf, 1e308, 0.0)  # values of one number for one sample
FACTORS = (-1.0, 1e-9, 10.0, -10.0, 1e3, -1e3, 1e9)  # on a number's largest value, for a stretch
DRAWN = 30  # stretches of random numbers
SHORT, LONG = 50, 1000  # samples


def stretches(inputs: Rows) -> Iterator[Rows]:
    """Samples in stretches, one number or all of them far from what the closed loop gave; the same each time.

    A number is in turn none, infinite, huge and 0 for one sample, then held at multiples of its largest
    value; then all are scaled, drawn evenly, and held for long. There are none where there are no inputs.

    Args:
        inputs: what the closed loop gave, shape (samples, numbers).

    Returns:
        Arrays of shape (10 to 1000, numbers).
    """
    if inputs.shape[1] == 0:
        return
    usual = np.where(np.abs(inputs) < HUGE, inputs, 0.0)
    largest = np.abs(usual).max(axis=0)
    largest[largest == 0.0] = 1.0
    last = usual[-SHORT:]
    for column in range(inputs.shape[1]):
        yield from of_one_number(last, largest, column)
    yield from of_all_numbers(last, largest)


def of_one_number(last: Rows, largest: Rows, column: int) -> Iterator[Rows]:
    for value in BEYOND:
        rows = last[-10:].copy()
        rows[len(rows) // 2, column] = value
        yield rows
    for factor in FACTORS:
        rows = last.copy()
        rows[:, column] = factor * largest[column]
        yield rows


def of_all_numbers(last: Rows, largest: Rows) -> Iterator[Rows]:
    draw = np.random.default_rng(1)
    for factor in FACTORS:
        yield factor * last
    for _ in range(DRAWN):
        yield 10.0 ** draw.uniform(-1.0, 2.0) * largest * draw.uniform(-1.0, 1.0, (SHORT, largest.size))
    for factor in FACTORS:
        yield np.tile(factor * largest, (LONG, 1))
