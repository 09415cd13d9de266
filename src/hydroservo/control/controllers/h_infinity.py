"""H-infinity loop shaping: a PI law made as robust as it can be."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.biquad import Biquad, BiquadState
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.synthesis.coprime import robust_controller
from hydroservo.control.synthesis.gains import nine_digits
from hydroservo.control.synthesis.loop_shaping import from_bilinear, sampled_plant, to_bilinear
from hydroservo.control.synthesis.sections import sections
from hydroservo.core.assumptions import Assumption, Facts, above, robust, valve_known
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import Controller, controlling, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants.design_model import THIS_MACHINE, DesignModel

COMPUTED = "two Riccati equations"


class HInfinityLoopShapingState(NamedTuple):
    """The last command, the integral, and the sections of the filter."""

    u: Annotated[float, Field("V", "command")]
    integral: Annotated[float, Field("V", "integral part of the command")]
    unlimited: Annotated[float, Field("V", "command before saturation")]
    first: BiquadState
    second: BiquadState


@role(Controller)
@controlling(Velocity)
class HInfinityLoopShaping(NamedTuple):
    """A PI law as a weight, and around it the controller that bears the largest uncertainty of the plant.

    The PI law shapes the loop: G_s = G W with W = k_p + k_i h z/(z - 1), and G the design model about rest
    behind a valve of first order, its command held over a sample. The controller K_s is the one which
    stabilises all plants within 1/gamma of G_s in normalised coprime factors, gamma = factor gamma_min. It is
    written as its gain at rest and a filter F of order four, in two sections, with F = 1 at rest::

        e = K_s(1) (r - F y),   I := I + h (k_i e + k_aw (u_applied - u_unlimited))
        u = sat( k_p e + I )

    so that a demand passes no filter, and with an integral there is no error at rest. A gamma below 2 to 3
    says that the weight goes with the plant; beyond 4 or so it asks for more than the plant can give. All is
    computed before a run, for the model and the sample period, of the sampled plant by v = (z - 1)/(z + 1),
    which keeps every norm: the loop that is run has that gamma.

    Source: McFarlane, Glover, IEEE Trans. Automatic Control 37(6), 1992; the demand by the gain at rest:
    Skogestad, Postlethwaite, Multivariable Feedback Control, 2005, sec. 9.4.3; the plant: eqs. (6)-(7) of
    doi:10.1007/s42401-021-00087-w.
    Fails to gain much on a PI law that is robust already, to know of a valve of other order than the first,
    of a command that comes late and of slow sensors; and where it is asked for so much that its filter would
    be unstable, which is said before a run.
    """

    proportional_gain: Annotated[float, Field("V s/m", "proportional gain k_p of the weight", at_least=0)]
    integral_gain: Annotated[float, Field("V/m", "integral gain k_i of the weight", at_least=0)]
    valve_time_constant: Annotated[
        float, Field("s", "spool time constant T_sv; 0: a valve without lag", at_least=0)
    ]
    factor: Annotated[
        float, Field("", "gamma over the least there is", "Skogestad, Postlethwaite, sec. 9.4.1", above=1)
    ] = 1.1
    anti_windup: Annotated[
        float, Field("1/s", "back-calculation gain k_aw", "0: none, as in PI", at_least=0)
    ] = 0.0
    model: DesignModel = THIS_MACHINE
    saturation: Saturation = Saturation()
    gamma: Annotated[float, Field("", "gamma; 1/gamma is the stability margin", COMPUTED, derived=True)] = 0.0
    gain: Annotated[float, Field("", "gain at rest of the robust controller", COMPUTED, derived=True)] = 1.0
    first: Biquad = Biquad()
    second: Biquad = Biquad()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        meaning = "1/gamma is above the nu-gap between the machine and the model, both behind the weight"
        return [
            above("robust margin", meaning, 1.0 / self.gamma, self.gap(facts)),
            robust(facts),
            valve_known(self.valve_time_constant, facts),
        ]

    def gap(self, facts: Facts) -> float:
        """The nu-gap of the machine and the model, each with the weight, but for its winding number."""
        frequencies = np.geomspace(1e-3, 1.0, 400) * math.pi / facts.period
        k_p, k_i, h = self.proportional_gain, self.integral_gain, facts.period
        z = np.exp(1j * frequencies * h)
        a, b, c, d = sampled_plant(self.model, self.valve_time_constant, h, k_p, k_i)
        known = np.array([(c @ np.linalg.solve(one * np.eye(len(a)) - a, b) + d)[0, 0] for one in z])
        weight = k_p + k_i * h * z / (z - 1.0)
        true = weight * np.array([facts.response(float(w)) for w in frequencies])
        return float(
            (np.abs(true - known) / np.sqrt((1.0 + np.abs(true) ** 2) * (1.0 + np.abs(known) ** 2))).max()
        )

    def check(self) -> None:
        if self.proportional_gain == self.integral_gain == 0.0:
            raise ParameterError("proportional_gain", 0.0, "must be above 0 [V s/m] where integral_gain is 0")

    def init(self) -> HInfinityLoopShapingState:
        return HInfinityLoopShapingState(0.0, 0.0, 0.0, self.first.init(), self.second.init())

    def step(
        self, s: HInfinityLoopShapingState, y: Measurement, r: Demand, dt: float
    ) -> HInfinityLoopShapingState:
        first = self.first.step(s.first, y.velocity)
        second = self.second.step(s.second, first.value)
        error = self.gain * (r.value - second.value)
        correction = self.anti_windup * (y.command - s.unlimited)
        integral = s.integral + dt * (self.integral_gain * error + correction)
        unlimited = self.proportional_gain * error + integral
        u = self.saturation.apply(unlimited)
        return HInfinityLoopShapingState(u, integral, unlimited, first, second)

    def designed(self, model: DesignModel, period: float) -> "HInfinityLoopShaping":
        """The law with its filter for a model and a sample period [s].

        Raises:
            ParameterError: there is no such controller, or it is unstable, or out of the reach of
                floating-point numbers.
        """
        k_p, k_i, tau = self.proportional_gain, self.integral_gain, self.valve_time_constant
        try:
            plant = to_bilinear(sampled_plant(model, tau, period, k_p, k_i))
            found = robust_controller(plant, self.factor)
            gain, parts = sections(from_bilinear(found.k))
        except ValueError as error:
            problem = (
                f"with integral_gain = {k_i:g}, valve_time_constant = {tau:g} and a sample period of "
                f"{period:g} s there is no robust controller to run: {error}"
            )
            raise ParameterError("HInfinityLoopShaping.proportional_gain", k_p, problem) from None
        first, second = [*(Biquad(*part.weights()) for part in parts), Biquad()][:2]
        return self._replace(gamma=nine_digits(found.gamma), gain=gain, first=first, second=second)
