"""How many workers: threads or processes."""

import os
from numbers import Integral

from hydroservo.core.errors import ParameterError


def checked_count(count: int | None, name: str) -> int:
    """How many workers to use: as many as asked for, else one for each core that this process may use.

    Args:
        count: asked for; None for all cores.
        name: of the argument, for the message.
    """
    if count is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if isinstance(count, bool) or not isinstance(count, Integral) or count < 1:
        raise ParameterError(name, count, "must be a whole number, at least 1, or None for all cores")
    return int(count)
