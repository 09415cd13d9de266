"""What laws make of a measured signal's slow part."""

from hydroservo import ops

__all__ = ["low_passed"]


def low_passed(last: float, value: float, time_constant: float, dt: float) -> float:
    """A signal through a low-pass of first order, by backward Euler; it begins at the first sample.

    Args:
        last: what this gave at the sample before; nan at the first.
        value: of the signal at this sample.
        time_constant: of the low-pass [s].
        dt: the sample period [s].
    """
    before = ops.where(ops.isnan(last), value, last)
    return before + dt / (time_constant + dt) * (value - before)
