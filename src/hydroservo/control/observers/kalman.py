"""A steady-state Kalman filter for both states and both lumped disturbances."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.observers.estimates import Estimates
from hydroservo.control.synthesis.kalman import steady_gains
from hydroservo.control.synthesis.linear_model import with_disturbances
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts, model_stable, noise_known
from hydroservo.core.block import Field
from hydroservo.core.roles import Observer, role
from hydroservo.core.signals import Measurement
from hydroservo.machine.plants.design_model import DesignModel

COMPUTED = "a Riccati equation"


@role(Observer)
class KalmanObserver(NamedTuple):
    """Estimates of velocity, hydraulic force and both lumped disturbances from noisy measurements.

    With x = [x1, x2, d_L1, d_L2], the disturbances random walks of intensity q_i, and white measurement noise
    of rms r_i per sample::

        prediction  dx1/dt = f1 + g1 x2 + d1,  dx2/dt = f2 + g2 u + d2 over the period just ended
        correction  x := x + L [y1 - x1, y2 - x2]

    L is the steady-state gain for the nominal model linearised at rest, computed before a run from q_i, r_i,
    the model and the sample period. The prediction is the nonlinear model under the mean command applied, in
    one Runge-Kutta step. The filter starts at the first measurement, and anew after a sample that was not a
    number. The law takes the estimates in place of the measurements.

    Source: Franklin, Powell, Workman, Digital Control of Dynamic Systems, 1998, sec. 9.4 (the gain) and
    sec. 8.5 (disturbances as states).
    Fails where noise is not white, as after quantisation that is coarse against the motion, and lags behind a
    disturbance that jumps by about the filter's own time, which q_i/r_i sets. Its Runge-Kutta step of the
    model is unstable where the sample period is above some 2.5 over the oil's natural frequency [rad/s].
    """

    disturbance_1: Annotated[
        float, Field("m/s^(5/2)", "intensity q1 of d_L1's random walk [m/s^2 per root s]", above=0)
    ]
    disturbance_2: Annotated[
        float, Field("N/s^(3/2)", "intensity q2 of d_L2's random walk [N/s per root s]", above=0)
    ]
    velocity_noise: Annotated[float, Field("m/s", "rms r1 of the velocity's noise", above=0)]
    hydraulic_force_noise: Annotated[float, Field("N", "rms r2 of the hydraulic force's noise", above=0)]
    gain_11: Annotated[float, Field("", "gain of y1 on x1", COMPUTED, derived=True)] = 0.0
    gain_12: Annotated[float, Field("m/(s N)", "gain of y2 on x1", COMPUTED, derived=True)] = 0.0
    gain_21: Annotated[float, Field("N s/m", "gain of y1 on x2", COMPUTED, derived=True)] = 0.0
    gain_22: Annotated[float, Field("", "gain of y2 on x2", COMPUTED, derived=True)] = 0.0
    gain_31: Annotated[float, Field("1/s", "gain of y1 on d_L1", COMPUTED, derived=True)] = 0.0
    gain_32: Annotated[float, Field("m/(s^2 N)", "gain of y2 on d_L1", COMPUTED, derived=True)] = 0.0
    gain_41: Annotated[float, Field("N/m", "gain of y1 on d_L2", COMPUTED, derived=True)] = 0.0
    gain_42: Annotated[float, Field("1/s", "gain of y2 on d_L2", COMPUTED, derived=True)] = 0.0

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return [
            noise_known("r_1", self.velocity_noise, facts, 0),
            noise_known("r_2", self.hydraulic_force_noise, facts, 1),
            model_stable(facts),
        ]

    def init(self) -> Estimates:
        return Estimates(0.0, 0.0, 0.0, 0.0, math.nan, math.nan)

    def step(self, s: Estimates, model: DesignModel, y: Measurement, dt: float) -> Estimates:
        ahead = model.ahead(s.velocity, s.hydraulic_force, y.command, s.d1, s.d2, dt)
        lost = ops.isnan(ahead.velocity)  # as is the hydraulic force, on which it depends
        miss1 = ops.where(lost, 0.0, y.velocity - ahead.velocity)
        miss2 = ops.where(lost, 0.0, y.hydraulic_force - ahead.hydraulic_force)
        return Estimates(
            s1=0.0,
            s2=0.0,
            d1=ops.where(lost, 0.0, s.d1 + self.gain_31 * miss1 + self.gain_32 * miss2),
            d2=ops.where(lost, 0.0, s.d2 + self.gain_41 * miss1 + self.gain_42 * miss2),
            velocity=ops.where(
                lost, y.velocity, ahead.velocity + self.gain_11 * miss1 + self.gain_12 * miss2
            ),
            hydraulic_force=ops.where(
                lost, y.hydraulic_force, ahead.hydraulic_force + self.gain_21 * miss1 + self.gain_22 * miss2
            ),
        )

    def designed(self, model: DesignModel, period: float) -> "KalmanObserver":
        """The filter with its steady-state gains for a model and a sample period [s].

        Raises:
            ParameterError: there is no steady state, or it is beyond the range of floating-point numbers.
        """
        sizes = (self.velocity_noise, self.hydraulic_force_noise)
        return self._replace(**steady_gains(self, with_disturbances(model), (0, 1), sizes, period))
