"""A position law that yields to a force as a mass, a damper and a spring would."""

from typing import Annotated, NamedTuple

from hydroservo.control.controlled.position import Position
from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, controlling, role
from hydroservo.core.signals import Demand, Measurement


class ImpedanceState(NamedTuple):
    """The command, the deflection of the demand, and the state of the law."""

    u: Annotated[float, Field("V", "command")]
    deflection: Annotated[float, Field("m", "by which the demand yields z")]
    deflection_rate: Annotated[float, Field("m/s", "its rate")]
    controller: Block


@role(Controller)
@controlling(Position)
class Impedance(NamedTuple):
    """A nested position law whose demand yields to the force beyond a limit: position-based impedance.

    M z'' + B z' + K z = F - F_0,  z not below 0;  the law is given r - z and r' - z'

    Without stiffness K, the demand yields until the force is F_0, as long as it lies beyond what is pressed.
    The equation is solved from sample to sample by the implicit Euler method, so it is stable for any
    parameters.

    Source: Hogan, Journal of Dynamic Systems, Measurement, and Control 107(1), 1985; Seraji and Colbaugh,
    International Journal of Robotics Research 16(1), 1997 (a force that is held).
    Fails where the position law is slower than the force rises: what it does not follow becomes force.
    """

    controller: Controller
    force: Annotated[float, Field("N", "force F_0 beyond which it yields", above=0)]
    mass: Annotated[float, Field("kg", "mass M that it yields with", at_least=0)]
    damping: Annotated[float, Field("N s/m", "damping B", above=0)]
    stiffness: Annotated[float, Field("N/m", "stiffness K", "0: it holds the force", at_least=0)] = 0.0

    def init(self) -> ImpedanceState:
        return ImpedanceState(0.0, 0.0, 0.0, self.controller.init())

    def step(self, s: ImpedanceState, y: Measurement, r: Demand, dt: float) -> ImpedanceState:
        excess = y.force - self.force - self.stiffness * s.deflection
        inertia = self.mass + dt * (self.damping + dt * self.stiffness)
        rate = (self.mass * s.deflection_rate + dt * excess) / inertia
        deflection = ops.maximum(s.deflection + dt * rate, 0.0)
        rate = (deflection - s.deflection) / dt
        demand = Demand(r.value - deflection, r.rate - rate, r.second_rate)
        controller = self.controller.step(s.controller, y, demand, dt)
        return ImpedanceState(controller.u, deflection, rate, controller)
