"""What a peer is: it is there or not, and prepares a job so that only the work itself is timed."""

from collections.abc import Callable, Iterable
from importlib.util import find_spec
from operator import itemgetter
from time import perf_counter
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from benchmarks.jobs import ACCURACY, Job, Result

__all__ = [
    "STEPS",
    "TOLERANCE",
    "TOLERANCES",
    "Peer",
    "Prepared",
    "at_tolerance",
    "cheapest",
    "difference",
    "fastest",
    "missing",
]

Choice = TypeVar("Choice")

TOLERANCE = 1e-6  # relative; contenders that differ by more do not run the same algorithm
STEPS = tuple(round(n * 10**e) for e in (1, 2, 3, 4) for n in (10, 15, 20, 30, 40, 50, 60, 80))
TOLERANCES = tuple(a * 10.0**-e for e in range(3, 13) for a in (1.0, 0.3))


class Prepared(NamedTuple):
    """A job ready to run: all that is compiled once is compiled, at the latest by the first call."""

    run: Callable[[], Result]
    how: str = ""  # what was chosen for this job, such as the solver and its tolerance


class Peer(Protocol):
    """Another way to do the jobs."""

    @property
    def name(self) -> str:
        """What tables call it."""

    def available(self) -> str | None:
        """Why it cannot run here; None if it can."""

    def fitted(self, job: Job) -> Job | None:
        """The job, or the first part of it if the whole takes too long; None if it is none for this peer."""

    def prepare(self, job: Job) -> Prepared:
        """Does what a user does once; chooses the method that is fastest at the accuracy asked for."""


def difference(result: Result, other: Result) -> float:
    """The largest relative difference between the numbers that two results share, over all runs.

    A metric that neither has, nan in both, is no difference.
    """
    worst = []
    for name in result.keys() & other.keys():
        mine, theirs = result[name], other[name]
        apart = np.abs(mine - theirs) / np.maximum(np.abs(theirs), np.finfo(float).tiny)
        worst.append(np.max(np.where(np.isnan(mine) & np.isnan(theirs), 0.0, apart)))
    return float(max(worst)) if worst else float("nan")


def cheapest(exact: Result | None, choices: Iterable[Choice], run: Callable[[Choice], Result]) -> Choice:
    """The first choice, from cheap to accurate, that is accurate enough, as the one after it must be too.

    Raises:
        ValueError: none is, or nothing is known to hold them against.
    """
    found = None
    for choice in choices if exact else ():
        good = difference(run(choice), exact or {}) <= ACCURACY
        if good and found is not None:
            return found
        found = choice if good else None
    raise ValueError(f"no choice reaches a relative accuracy of {ACCURACY:g}")


def at_tolerance(job: Job, method: str, end: Callable[[float], Result]) -> Prepared:
    """An adaptive method at the loosest relative tolerance that is accurate enough."""
    tolerance = cheapest(job.exact, TOLERANCES, end)
    return Prepared(lambda: end(tolerance), f"{method}, rtol {tolerance:g}")


def fastest(candidates: Iterable[Callable[[], Prepared]]) -> Prepared:
    """Of several ways to do a job the one that takes least time; those that cannot do it are left out.

    Raises:
        ValueError: none can.
    """
    timed = []
    for candidate in candidates:
        try:
            prepared = candidate()
        except ValueError:
            continue
        prepared.run()
        began = perf_counter()
        prepared.run()
        timed.append((perf_counter() - began, prepared))
    return min(timed, key=itemgetter(0))[1]


def missing(package: str) -> str | None:
    """Why a package cannot be used; None if it can."""
    return None if find_spec(package) else f"{package} is not installed"
