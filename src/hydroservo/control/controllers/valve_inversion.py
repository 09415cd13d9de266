"""Makes a slow valve do what a law for a static one wants."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.observers.spool_lag import SpoolLag
from hydroservo.core.assumptions import Assumption, Facts, above, valve_known
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.core.sources import CHOSEN


class ValveInversionState(NamedTuple):
    """The last command, the modelled spool and the state of the law."""

    u: Annotated[float, Field("V", "command")]
    opening: Annotated[float, Field("V", "modelled opening, as the command that would hold it")]
    controller: Block


@role(Controller)
class ValveInversion(NamedTuple):
    """A law for a valve without lag on a valve of first order, through a one-step model of the spool.

    With the opening x in volts, a = exp(-dt/tau) and u* what the law wants it to be::

        x_(k+1) = a x_k + (1 - a) u_k           u_k = sat((u* - a^n x_k)/(1 - a^n))

    so the spool would get there in n = ``reach`` sample periods, as far as the command's limit allows. In
    place of the command the law is told the mean opening over the period just ended.

    Source: deadbeat control of a first-order lag; Astrom and Wittenmark, Computer-Controlled Systems, 1997,
    sec. 4.3. The time constant's default is that of doi:10.1007/s42401-021-00087-w, Sec. 4.
    Fails where the spool is of higher order, slew limited or much slower than modelled: the command is
    1/(1 - a^n) times livelier than the law's, and so is its noise. A reach below 1 overshoots and rings.
    """

    controller: Controller
    time_constant: Annotated[float, Field("s", "modelled spool time constant", above=0)]
    reach: Annotated[
        float, Field("", "sample periods until the spool is where the law wants it", CHOSEN, at_least=0.5)
    ] = 1.0
    saturation: Saturation = Saturation()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return [
            valve_known(self.time_constant, facts),
            above("reach", "the reach is above 1 sample period, or nearly", self.reach, 0.99),
        ]

    def within(self, facts: Facts) -> Facts:
        return facts.knowing_the_lag(self.time_constant)

    def init(self) -> ValveInversionState:
        return ValveInversionState(0.0, 0.0, self.controller.init())

    def step(self, s: ValveInversionState, y: Measurement, r: Demand, dt: float) -> ValveInversionState:
        lag = SpoolLag(self.time_constant)
        spool = lag.under_held_command(s.opening, y.command, dt)
        controller = self.controller.step(s.controller, y.with_command(spool.mean), r, dt)
        aim = lag.kept(self.reach * dt)
        u = self.saturation.apply((controller.u - aim * spool.opening) / (1.0 - aim))
        return ValveInversionState(u, spool.opening, controller)
