"""A controller in a file of its own: copy it, change the law, run it.

In Python::

    from my_controller import PressureFeedbackPI
    loop = load_scenario("paper/sine-pi")
    simulate(replace(loop, {"controller": PressureFeedbackPI()}))

From a scenario: ``hydroservo run my.toml --plugin my_controller.py``.
"""

from typing import Annotated, NamedTuple

from hydroservo import Field, ops
from hydroservo.control.controllers import Saturation
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class PressureFeedbackPIState(NamedTuple):
    """What the controller remembers from one sample to the next."""

    u: Annotated[float, Field("V", "command")]
    integral: Annotated[float, Field("V", "integral part of the command")]
    slow_force: Annotated[float, Field("N", "hydraulic force through the low-pass")]


@role(Controller)
class PressureFeedbackPI(NamedTuple):
    """PI with demand feedforward and dynamic pressure feedback, which damps the hydraulic resonance.

    u = sat(k_v dy_d/dt + k_p e + k_i int e dt - k_f (x2 - x2 through a low-pass))

    The integral stands still while u is limited and would grow further.

    Source: pressure feedback as in Merritt, Hydraulic Control Systems, 1967; the gains were tried by hand on
    the machine of my.toml.
    Fails where k_f is so large that the valve's lag turns damping into oscillation: near three times
    the default.
    """

    feedforward: Annotated[float, Field("V s/m", "demand feedforward k_v", "example", at_least=0)] = 0.96
    proportional_gain: Annotated[float, Field("V s/m", "gain k_p", "example", at_least=0)] = 5.0
    integral_gain: Annotated[float, Field("V/m", "gain k_i", "example", at_least=0)] = 1000.0
    force_gain: Annotated[float, Field("V/N", "pressure feedback k_f", "example", at_least=0)] = 1e-3
    force_time: Annotated[float, Field("s", "low-pass time constant", "example", above=0)] = 0.02
    saturation: Saturation = Saturation()

    def init(self) -> PressureFeedbackPIState:
        return PressureFeedbackPIState(0.0, 0.0, 0.0)

    def step(
        self, s: PressureFeedbackPIState, y: Measurement, r: Demand, dt: float
    ) -> PressureFeedbackPIState:
        error = r.value - y.velocity
        integral = s.integral + dt * self.integral_gain * error
        slow_force = s.slow_force + dt / (self.force_time + dt) * (y.hydraulic_force - s.slow_force)
        wanted = (
            self.feedforward * r.value
            + self.proportional_gain * error
            + integral
            - self.force_gain * (y.hydraulic_force - slow_force)
        )
        u = self.saturation.apply(wanted)
        windup = (wanted - u) * error > 0.0
        return PressureFeedbackPIState(u, ops.where(windup, s.integral, integral), slow_force)
