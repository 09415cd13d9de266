"""A low-pass that laws put a measured signal through."""

from typing import NamedTuple

from hydroservo.core import ops


class LowPass(NamedTuple):
    """A low-pass of first order by backward Euler, which begins at the signal's first sample.

    x_k = x_(k-1) + dt/(tau + dt) (y_k - x_(k-1))
    """

    time_constant: float  # tau [s]

    def after(self, last: float, value: float, dt: float) -> float:
        """What comes out at a sample.

        Args:
            last: what came out at the one before; nan at the first.
            value: of the signal.
            dt: the sample period [s].
        """
        before = ops.where(ops.isnan(last), value, last)
        return before + dt / (self.time_constant + dt) * (value - before)
