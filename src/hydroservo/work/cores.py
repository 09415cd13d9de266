"""How many workers: threads or processes."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from numbers import Integral
from threading import Lock
from typing import Any

from hydroservo.core.errors import ParameterError

ALGEBRA = Lock()
LIMITS: list[Any] = []  # one for each context now open; the first restores what there was before


def checked_count(count: int | None, name: str) -> int:
    """How many workers to use: as many as asked for, else one for each core that this process may use."""
    if count is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if isinstance(count, bool) or not isinstance(count, Integral) or count < 1:
        raise ParameterError(name, count, "must be a whole number, at least 1, or None for all cores")
    return int(count)


@contextmanager
def single_threaded_algebra() -> Iterator[None]:
    """Inside, linear algebra has one thread: on matrices of a few rows more cost twice what they compute.

    Once all that is inside has ended, in whichever thread of Python, it has as many as before.
    """
    import scipy.linalg  # noqa: F401  whose own library of linear algebra is limited only where it is loaded
    from threadpoolctl import threadpool_limits

    with ALGEBRA:
        LIMITS.append(threadpool_limits(1, "blas"))
    try:
        yield
    finally:
        with ALGEBRA:
            last = LIMITS.pop()
            if not LIMITS:
                last.restore_original_limits()
