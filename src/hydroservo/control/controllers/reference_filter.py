"""Smooths the demand of a law, and gives it the derivatives of what is smoothed."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class ReferenceFilterState(NamedTuple):
    """The last command, the filtered demand with its derivatives, and the state of the law."""

    u: Annotated[float, Field("V", "command")]
    value: Annotated[float, Field("y", "filtered {y} demand")]
    rate: Annotated[float, Field("y/s", "its first derivative")]
    second_rate: Annotated[float, Field("y/s^2", "its second derivative")]
    controller: Block


@role(Controller)
class ReferenceFilter(NamedTuple):
    """A nested law whose demand passes a filter of third order with its three poles at -w.

    r_f''' = w^3 (r - r_f) - 3 w^2 r_f' - 3 w r_f'', r held over the sample period, solved exactly

    The law is given r_f, r_f' and r_f'', which belong to each other whatever the demand does: where the
    demand jumps its own derivatives say nothing of it. The filter starts at the first demand, at rest. Errors
    are of the demand all the same, so that it costs 3/w of delay.

    Source: model reference prefilter; Astrom and Wittenmark, Computer-Controlled Systems, 1997, sec. 5.
    Fails where the demand is smooth already, by its delay.
    """

    controller: Controller
    bandwidth: Annotated[float, Field("rad/s", "w, each of the filter's three poles", above=0)]

    def init(self) -> ReferenceFilterState:
        return ReferenceFilterState(0.0, math.nan, 0.0, 0.0, self.controller.init())

    def step(self, s: ReferenceFilterState, y: Measurement, r: Demand, dt: float) -> ReferenceFilterState:
        filtered = self.filtered(s, r.value, dt)
        controller = self.controller.step(s.controller, y, filtered, dt)
        return ReferenceFilterState(
            controller.u, filtered.value, filtered.rate, filtered.second_rate, controller
        )

    def filtered(self, s: ReferenceFilterState, demand: float, dt: float) -> Demand:
        """The filtered demand a sample period on: r + (d + c1 t + c2 t^2) exp(-w t) of what it was off by."""
        w, lost = self.bandwidth, ops.isnan(s.value)
        off = ops.where(lost, 0.0, s.value - demand)
        c1 = s.rate + w * off
        c2 = 0.5 * (s.second_rate + w * (2.0 * s.rate + w * off))
        kept = ops.power(math.e, -w * dt)
        level = off + dt * (c1 + dt * c2)
        slope = c1 + 2.0 * dt * c2
        return Demand(
            demand + kept * level,
            kept * (slope - w * level),
            kept * (2.0 * c2 - w * (2.0 * slope - w * level)),
        )
