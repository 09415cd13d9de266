"""Feedback of the state's distance from where demand and disturbances put it."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.signals import Demand
from hydroservo.machine.plants.design_model import DesignModel

COMPUTED = "a Riccati equation"

# What the laws that have it share.
Effort = Annotated[float, Field("m/(s V)", "velocity error that a volt of command counts for", above=0)]
ForceWeight = Annotated[
    float, Field("m/(s N)", "velocity error that a newton off its target counts for", "0: none", at_least=0)
]
IntegralRate = Annotated[
    float, Field("1/s", "velocity error that a metre of its integral counts for", above=0)
]
AntiWindupWeight = Annotated[
    float, Field("m/(s V)", "velocity error that a volt not applied counts for", "0: none, as PI", at_least=0)
]
SpoolTimeConstant = Annotated[float, Field("s", "modelled spool time constant; 0: no lag", at_least=0)]
VelocityGain = Annotated[float, Field("V s/m", "gain of the velocity", COMPUTED, derived=True)]
ForceGain = Annotated[float, Field("V/N", "gain of the hydraulic force", COMPUTED, derived=True)]
OpeningGain = Annotated[float, Field("", "gain of the opening", COMPUTED, derived=True)]


class Target(NamedTuple):
    """Where the model follows a demand, and the orifice's gain there."""

    hydraulic_force: Annotated[float, Field("N", "hydraulic force x2r")]
    opening: Annotated[float, Field("V", "opening x3r, as the command that would hold it")]
    gain: Annotated[float, Field("", "gain of the orifice at rest over that now, g2(0)/g2")]


class StateFeedback(NamedTuple):
    """u = x3r - K (x - xr), with the orifice's gain made that at rest.

    x = [x1, x2, x3] is velocity, hydraulic force and the valve's opening in volts. Where the model follows
    the demand r under disturbances that stay, it is at xr::

        x1r = r,   x2r = (r' - f1(r) - d1)/g1,   x3r = ((r'' - f1' r')/g1 - f2(x1r, x2r) - d2)/g2(x2, x3)
        u   = x3r - g2(0)/g2(x2, x3) (k1 (x1 - x1r) + k2 (x2 - x2r) + v) - k3 (x3 - x3r)

    v is what a law remembers. K is designed at rest; the ratio of the gains keeps the loop as it is there
    under any load.

    Source: Maeder, Borrelli, Morari, Automatica 45(10), 2009 (the target under disturbances; unverified).
    Fails to know the demand's third rate, so that a lagging valve is asked too late by tau dx3r/dt.
    """

    gain_1: Annotated[float, Field("V s/m", "gain of the velocity")]
    gain_2: Annotated[float, Field("V/N", "gain of the hydraulic force")]
    gain_3: Annotated[float, Field("", "gain of the opening")]

    def target(self, model: DesignModel, x2: float, x3: float, d1: float, d2: float, r: Demand) -> Target:
        """Where hydraulic force and opening are to be."""
        g1, g2 = model.g1(), model.g2(x2, x3)
        x2r = (r.rate - model.f1(r.value) - d1) * (1.0 / g1)
        rate = (r.second_rate - model.f1_slope() * r.rate) * (1.0 / g1)
        x3r = (rate - model.f2(r.value, x2r) - d2) / g2
        return Target(x2r, x3r, model.g2(0.0, 0.0) / g2)

    def command(
        self,
        model: DesignModel,
        x1: float,
        x2: float,
        x3: float,
        d1: float,
        d2: float,
        r: Demand,
        remembered: float,
    ) -> float:
        """The command before saturation [V]."""
        target = self.target(model, x2, x3, d1, d2, r)
        pull = self.gain_1 * (x1 - r.value) + self.gain_2 * (x2 - target.hydraulic_force) + remembered
        return target.opening - target.gain * pull - self.gain_3 * (x3 - target.opening)
