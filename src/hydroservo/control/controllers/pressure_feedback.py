"""Dynamic pressure feedback around any law."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controllers.low_pass import LowPass
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core.assumptions import Assumption, Facts, valve_damps
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class PressureFeedbackState(NamedTuple):
    """What is put out, what of it is fed back, and the slow part of the hydraulic force."""

    u: Annotated[float, Field("V", "command")]
    fed_back: Annotated[float, Field("V", "what the pressures took off the command")]
    slow_force: Annotated[float, Field("N", "hydraulic force through the low-pass")]
    controller: Block


@role(Controller)
class PressureFeedback(NamedTuple):
    """The command of a nested law, less the quick part of the hydraulic force: electronic damping.

    u = sat(u_law - k_f (x2 - x2 through a low-pass of first order)),  x2 = A_A p_A - A_B p_B as measured

    With a valve that is faster than the axis, and 1/tau well below omega_h, it adds g2 k_f/(2 omega_h) to
    the damping ratio, with g2 [N/(s V)] the rate of the hydraulic force per command. A steady load is not fed
    back, and costs no stiffness. The nested law learns of the applied command without what was fed back.

    Source: dynamic pressure feedback, with an example by Moog: Kutz (ed.), Mechanical Engineers' Handbook,
    vol. 2, 2006, p. 615, figs. 52 to 54 and table 11; static pressure feedback: Merritt, Hydraulic Control
    Systems, 1967.
    Fails with a valve slower than the axis, whose lag turns the damping into a spring and then into
    excitation: it should have three times the axis' frequency. A long tau lets slow loads through.
    """

    controller: Controller
    force_gain: Annotated[float, Field("V/N", "pressure feedback k_f", at_least=0)]
    time_constant: Annotated[float, Field("s", "of the low-pass that is taken off, tau", above=0)]
    saturation: Saturation = Saturation()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return [valve_damps(facts)]

    def init(self) -> PressureFeedbackState:
        return PressureFeedbackState(0.0, 0.0, math.nan, self.controller.init())

    def step(self, s: PressureFeedbackState, y: Measurement, r: Demand, dt: float) -> PressureFeedbackState:
        slow_force = LowPass(self.time_constant).after(s.slow_force, y.hydraulic_force, dt)
        fed_back = self.force_gain * (y.hydraulic_force - slow_force)
        controller = self.controller.step(s.controller, y.with_command(y.command + s.fed_back), r, dt)
        u = self.saturation.apply(controller.u - fed_back)
        return PressureFeedbackState(u, fed_back, slow_force, controller)
