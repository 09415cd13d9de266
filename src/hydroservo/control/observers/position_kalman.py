"""A steady-state Kalman filter that measures position."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from hydroservo.control.synthesis.kalman import steady_gains
from hydroservo.control.synthesis.linear_model import with_disturbances
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts, model_stable, noise_known
from hydroservo.core.block import Field
from hydroservo.core.roles import Observer, role
from hydroservo.core.signals import Measurement
from hydroservo.machine.plants.design_model import DesignModel

COMPUTED = "a Riccati equation"


class PositionKalmanObserverState(NamedTuple):
    """Estimates at this sample. The surfaces s1 and s2, which a law expects of an observer, are 0."""

    s1: Annotated[float, Field("m/s", "0: no observer surface s1")]
    s2: Annotated[float, Field("N", "0: no observer surface s2")]
    d1: Annotated[float, Field("m/s^2", "estimate of the lumped disturbance d_L1")]
    d2: Annotated[float, Field("N/s", "estimate of the lumped disturbance d_L2")]
    velocity: Annotated[float, Field("m/s", "estimated velocity, which the law takes")]
    hydraulic_force: Annotated[float, Field("N", "estimated hydraulic force, which the law takes")]
    position: Annotated[float, Field("m", "estimated position")]


@role(Observer)
class PositionKalmanObserver(NamedTuple):
    """As KalmanObserver, with the measured position y in place of the velocity.

    With x = [y, x1, x2, d_L1, d_L2], the disturbances random walks of intensity q_i, and white measurement
    noise of rms r_i per sample::

        prediction  dy/dt = x1, dx1/dt = f1 + g1 x2 + d1, dx2/dt = f2 + g2 u + d2 over the period just ended
        correction  x := x + L [y_measured - y, x2_measured - x2]

    So an encoder's counts are filtered once, by what the machine can do, and not differenced before: the
    noise of a difference is neither white nor without delay. An encoder of resolution q has about r_1 =
    q/sqrt(12). Start, restart and gain are as KalmanObserver's.

    Source: as KalmanObserver.
    Fails where the counts stand still for many samples, so that their error is no noise any more, and
    at sample periods that KalmanObserver does not bear either.
    """

    disturbance_1: Annotated[
        float, Field("m/s^(5/2)", "intensity q1 of d_L1's random walk [m/s^2 per root s]", above=0)
    ]
    disturbance_2: Annotated[
        float, Field("N/s^(3/2)", "intensity q2 of d_L2's random walk [N/s per root s]", above=0)
    ]
    position_noise: Annotated[float, Field("m", "rms r1 of the position's noise", above=0)]
    hydraulic_force_noise: Annotated[float, Field("N", "rms r2 of the hydraulic force's noise", above=0)]
    gain_11: Annotated[float, Field("", "gain of y on position", COMPUTED, derived=True)] = 0.0
    gain_12: Annotated[float, Field("m/N", "gain of x2 on position", COMPUTED, derived=True)] = 0.0
    gain_21: Annotated[float, Field("1/s", "gain of y on x1", COMPUTED, derived=True)] = 0.0
    gain_22: Annotated[float, Field("m/(s N)", "gain of x2 on x1", COMPUTED, derived=True)] = 0.0
    gain_31: Annotated[float, Field("N/m", "gain of y on x2", COMPUTED, derived=True)] = 0.0
    gain_32: Annotated[float, Field("", "gain of x2 on x2", COMPUTED, derived=True)] = 0.0
    gain_41: Annotated[float, Field("1/s^2", "gain of y on d_L1", COMPUTED, derived=True)] = 0.0
    gain_42: Annotated[float, Field("m/(s^2 N)", "gain of x2 on d_L1", COMPUTED, derived=True)] = 0.0
    gain_51: Annotated[float, Field("N/(m s)", "gain of y on d_L2", COMPUTED, derived=True)] = 0.0
    gain_52: Annotated[float, Field("1/s", "gain of x2 on d_L2", COMPUTED, derived=True)] = 0.0

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return [noise_known("r_2", self.hydraulic_force_noise, facts, 1), model_stable(facts)]

    def init(self) -> PositionKalmanObserverState:
        return PositionKalmanObserverState(0.0, 0.0, 0.0, 0.0, 0.0, math.nan, math.nan)

    def step(
        self, s: PositionKalmanObserverState, model: DesignModel, y: Measurement, dt: float
    ) -> PositionKalmanObserverState:
        ahead = model.ahead(s.velocity, s.hydraulic_force, y.command, s.d1, s.d2, dt)
        position = s.position + ahead.travel
        lost = ops.isnan(position)  # as is velocity or hydraulic force, on both of which the way depends
        miss1 = ops.where(lost, 0.0, y.position - position)
        miss2 = ops.where(lost, 0.0, y.hydraulic_force - ahead.hydraulic_force)
        return PositionKalmanObserverState(
            s1=0.0,
            s2=0.0,
            d1=ops.where(lost, 0.0, s.d1 + self.gain_41 * miss1 + self.gain_42 * miss2),
            d2=ops.where(lost, 0.0, s.d2 + self.gain_51 * miss1 + self.gain_52 * miss2),
            velocity=ops.where(lost, 0.0, ahead.velocity + self.gain_21 * miss1 + self.gain_22 * miss2),
            hydraulic_force=ops.where(
                lost, y.hydraulic_force, ahead.hydraulic_force + self.gain_31 * miss1 + self.gain_32 * miss2
            ),
            position=ops.where(lost, y.position, position + self.gain_11 * miss1 + self.gain_12 * miss2),
        )

    def designed(self, model: DesignModel, period: float) -> "PositionKalmanObserver":
        """The filter with its steady-state gains for a model and a sample period [s].

        Raises:
            ParameterError: there is no steady state, or it is beyond the range of floating-point numbers.
        """
        rates = np.zeros((5, 5))
        rates[0, 1] = 1.0
        rates[1:, 1:] = with_disturbances(model)
        sizes = (self.position_noise, self.position_noise / period, self.hydraulic_force_noise)
        return self._replace(**steady_gains(self, rates, (0, 2), sizes, period))
