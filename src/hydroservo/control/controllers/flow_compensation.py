"""Compensation of a valve's flow for the load and for a single rod."""

import math
from typing import Annotated, NamedTuple

from hydroservo.control.controllers.low_pass import LowPass
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement

LARGEST_DROP = 1e12  # [Pa] beyond any; so that no reading makes the gain 0, by which commands are divided


class FlowCompensationState(NamedTuple):
    """What is put out, the gain that it was given, and the slow part of the hydraulic force."""

    u: Annotated[float, Field("V", "command")]
    gain: Annotated[float, Field("", "command over that of the law")]
    slow_force: Annotated[float, Field("N", "hydraulic force through the low-pass")]
    controller: Block


@role(Controller)
class FlowCompensation(NamedTuple):
    """The command of a nested law, scaled so that the flow into chamber A is that at the rated drop.

    u = sat(u_law sqrt(rated_drop/max(drop, least_drop))); the drop is that over the open edge of port A in
    steady motion under the hydraulic force x2, with alpha = A_B/A_A, and p_s as the controller knows it::

        drop = (p_s - x2/A_A)/(1 + alpha^3)  where u_law > 0,  (alpha p_s + x2/A_A)/(1 + alpha^3)  elsewhere

    So the velocity per command is one number for both directions and all loads, K_v = Q_rated/(A_A u_rated).
    The hydraulic force is A_A p_A - A_B p_B as measured, through a low-pass of first order. The nested law
    learns of the applied command as its own.

    Source: the square-root law of two edges in series with a cylinder that is in balance: Merritt, Hydraulic
    Control Systems, 1967, ch. 5; with a return pressure of 0 and matched edges.
    Fails where the supply's pressure falls below p_s, where the load drives the cylinder until a chamber
    cavitates, and with a time constant as short as the axis swings: what damps a valve-controlled axis is
    that its flow falls with the load, and this takes it out.
    """

    controller: Controller
    supply_pressure: Annotated[float, Field("Pa", "supply pressure p_s as the controller knows it", above=0)]
    area_a: Annotated[float, Field("m^2", "piston area A_A of chamber A", above=0)]
    area_b: Annotated[float, Field("m^2", "piston area A_B of chamber B", above=0)]
    rated_drop: Annotated[float, Field("Pa", "drop over one edge at which the gain is 1", above=0)]
    least_drop: Annotated[float, Field("Pa", "drop below which the gain rises no further", above=0)]
    time_constant: Annotated[float, Field("s", "low-pass time constant of the hydraulic force", at_least=0)]
    saturation: Saturation = Saturation()

    def check(self) -> None:
        if not self.least_drop < self.supply_pressure:
            allowed = f"must be below supply_pressure, {self.supply_pressure:g} [Pa]"
            raise ParameterError("least_drop", self.least_drop, allowed)

    def init(self) -> FlowCompensationState:
        return FlowCompensationState(0.0, 1.0, math.nan, self.controller.init())

    def step(self, s: FlowCompensationState, y: Measurement, r: Demand, dt: float) -> FlowCompensationState:
        controller = self.controller.step(s.controller, y.with_command(y.command / s.gain), r, dt)
        slow_force = LowPass(self.time_constant).after(s.slow_force, y.hydraulic_force, dt)
        drop = ops.maximum(self.drop(controller.u, slow_force), self.least_drop)
        gain = ops.sqrt(self.rated_drop / ops.minimum(drop, LARGEST_DROP))
        return FlowCompensationState(self.saturation.apply(gain * controller.u), gain, slow_force, controller)

    def drop(self, u: float, hydraulic_force: float) -> float:
        """The drop over the edge of port A that a command opens [Pa]."""
        ratio, load = self.area_b / self.area_a, hydraulic_force / self.area_a
        held = ops.where(u > 0.0, self.supply_pressure - load, ratio * self.supply_pressure + load)
        return held / (1.0 + ratio * ratio * ratio)
