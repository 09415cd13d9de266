"""An observer that knows of the valve's lag."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.observers.spool_lag import SpoolLag
from hydroservo.core.assumptions import Assumption, Facts, valve_known
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Observer, role
from hydroservo.core.signals import Measurement
from hydroservo.machine.plants.design_model import DesignModel


class ValveLagState(NamedTuple):
    """What the nested observer hands on, the modelled spool, and that observer's state."""

    s1: Annotated[float, Field("m/s", "surface s1 of the nested observer")]
    s2: Annotated[float, Field("N", "surface s2 of the nested observer")]
    d1: Annotated[float, Field("m/s^2", "estimate of the lumped disturbance d_L1")]
    d2: Annotated[float, Field("N/s", "estimate of the lumped disturbance d_L2")]
    velocity: Annotated[float, Field("m/s", "velocity, which the law takes")]
    hydraulic_force: Annotated[float, Field("N", "hydraulic force, which the law takes")]
    opening: Annotated[float, Field("V", "modelled opening, as the command that would hold it")]
    observer: Block


@role(Observer)
class ValveLag(NamedTuple):
    """An observer that is told of the mean opening of a valve of first order in place of the command.

    With the opening x in volts and the command u applied over the period just ended, tau dx/dt = u - x::

        x_k = u + a (x_(k-1) - u)     a = exp(-dt/tau)
        u_m = u + (1 - a) tau/dt (x_(k-1) - u)

    u_m, the mean of x over the period, is what the nested observer is told for u, so that its d_L2 is what
    the oil does besides the model, and not the way of the spool. What it estimates is handed on as it is.

    Source: the exact solution of the lag, as OffsetFreeLQ, LinearMPC and ValveInversion have it.
    Fails in these three, which tell their observers of the lag themselves; in a law for a static valve that
    has nothing else against the lag, for which it then makes up by no d_L2 any more; and where the spool is
    of higher order or slew limited. ``estimate_rms_error_2`` is of a d_L2 by the command, lag and all.
    """

    observer: Observer
    time_constant: Annotated[float, Field("s", "modelled spool time constant", above=0)]

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return [valve_known(self.time_constant, facts)]

    def within(self, facts: Facts) -> Facts:
        return facts.knowing_the_lag(self.time_constant)

    def init(self) -> ValveLagState:
        return self.handed_on(self.observer.init(), 0.0)

    def step(self, s: ValveLagState, model: DesignModel, y: Measurement, dt: float) -> ValveLagState:
        spool = SpoolLag(self.time_constant).under_held_command(s.opening, y.command, dt)
        observer = self.observer.step(s.observer, model, y.with_command(spool.mean), dt)
        return self.handed_on(observer, spool.opening)

    def handed_on(self, o: Block, opening: float) -> ValveLagState:
        return ValveLagState(o.s1, o.s2, o.d1, o.d2, o.velocity, o.hydraulic_force, opening, o)
