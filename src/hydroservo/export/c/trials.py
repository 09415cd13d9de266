"""Samples beyond those of a closed loop, to reach what that never does."""

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from hydroservo.export.c.vectors import HUGE, Records

__all__ = ["stretches"]

BEYOND = (math.nan, math.inf, -math.inf, 1e308, 0.0)  # values of one number for one sample
FACTORS = (-1.0, 1e-9, 10.0, -10.0, 1e3, -1e3, 1e9)  # on a number's largest value, for a stretch
DRAWN = 30  # stretches of random numbers
SHORT, LONG = 50, 1000  # samples


def stretches(inputs: Sequence[Records]) -> Iterator[list[Records]]:
    """Samples in stretches, one number or all of them far from what the closed loop gave; the same each time.

    A number is in turn none, infinite, huge and 0 for one sample, then scaled for a whole stretch; then all
    are scaled, drawn evenly, and held for long.

    Args:
        inputs: what the closed loop gave.
    """
    if not any(record for record in inputs[-1].values()):
        return
    seen = np.array([[x for record in records.values() for x in record] for records in inputs])
    seen = seen[(np.abs(seen) < HUGE).all(axis=1)]
    largest = np.abs(seen).max(axis=0)
    largest[largest == 0.0] = 1.0
    last = seen[-SHORT:]
    for rows in (*one_number(last, largest), *all_numbers(last, largest)):
        yield [records_of(inputs[-1], row) for row in rows]


def one_number(last: NDArray[np.float64], largest: NDArray[np.float64]) -> Iterator[NDArray[np.float64]]:
    for column in range(last.shape[1]):
        for value in BEYOND:
            rows = last[-10:].copy()
            rows[1, column] = value
            yield rows
        for factor in FACTORS:
            rows = last.copy()
            rows[:, column] = factor * largest[column]
            yield rows


def all_numbers(last: NDArray[np.float64], largest: NDArray[np.float64]) -> Iterator[NDArray[np.float64]]:
    draw = np.random.default_rng(1)
    for factor in FACTORS:
        yield factor * last
    for _ in range(DRAWN):
        yield 10.0 ** draw.uniform(-1.0, 2.0) * largest * draw.uniform(-1.0, 1.0, (SHORT, largest.size))
    for factor in FACTORS:
        yield np.tile(factor * largest, (LONG, 1))


def records_of(like: Records, row: NDArray[np.float64]) -> Records:
    """The arguments of one step, with these numbers."""
    numbers = iter(row.tolist())
    return {name: type(record)(*(next(numbers) for _ in record)) for name, record in like.items()}
