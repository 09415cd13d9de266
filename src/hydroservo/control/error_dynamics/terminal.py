"""Two nested terminal sliding surfaces: those of the first paper, and fast terminal sliding mode."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.error_dynamics.implicit_reaching import ImplicitReaching
from hydroservo.core.assumptions import Assumption, Facts, sampled_faster, supposed, valve_faster
from hydroservo.core.block import Field
from hydroservo.core.roles import ErrorDynamics, Reaching, role
from hydroservo.core.signals import VelocityError


class TerminalErrorDynamicsState(NamedTuple):
    """What is asked for at this sample, and the surfaces."""

    damping: Annotated[float, Field("m/s^3", "jerk asked against the error's rate")]
    restoring: Annotated[float, Field("m/s^3", "jerk asked against the second surface")]
    xi1: Annotated[float, Field("m/s", "sliding surface xi1")]
    xi2: Annotated[float, Field("m/s^2", "sliding surface xi2")]


@role(ErrorDynamics)
class TerminalErrorDynamics(NamedTuple):
    """Two nested surfaces, each drawn to 0 by a linear term and a power below 1.

    With every power odd (|x|^a sgn x) and s' the shift by the observer's surfaces::

        xi1 = e,    xi2 = dxi1/dt + mu1 xi1 + delta1 xi1^a1 + s'
        q   = mu1 dxi1/dt + delta1 d(xi1^a1)/dt + mu2 xi2 + delta2 xi2^a2

    The powers bring both surfaces to 0 in finite time, the linear terms from afar ("fast" terminal sliding
    mode); without powers it is :class:`LinearErrorDynamics` with the poles mu1 and mu2. The nested
    ``reaching`` realises the powers in discrete time.

    Source: Yu, Man, IEEE Trans. Circuits and Systems I 49(2), 2002, doi:10.1109/81.983876 (unverified); with
    an observer's surfaces: eqs. (19)-(22) of doi:10.1007/s42401-021-00087-w.
    Fails where the realisation is explicit, by chatter; where mu1 times the sample period nears 1 otherwise.
    """

    linear_gain_1: Annotated[float, Field("1/s", "gain mu_1", at_least=0)]
    linear_gain_2: Annotated[float, Field("1/s", "gain mu_2", at_least=0)]
    power_gain_1: Annotated[float, Field("m^(2/7)/s^(9/7)", "gain delta_1 [(m/s)^(1-a1)/s]", at_least=0)]
    power_gain_2: Annotated[float, Field("m^(4/9)/s^(17/9)", "gain delta_2 [(m/s^2)^(1-a2)/s]", at_least=0)]
    exponent_1: Annotated[float, Field("", "exponent a1", at_least=0.1, below=1)]
    exponent_2: Annotated[float, Field("", "exponent a2", at_least=0.1, below=1)]
    reaching: Reaching = ImplicitReaching()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        mu, size = max(self.linear_gain_1, self.linear_gain_2), facts.demand.value
        return [
            sampled_faster(mu, facts, "the larger of mu_1 and mu_2"),
            valve_faster(mu, facts, "the larger of mu_1 and mu_2"),
            *supposed(self.reaching, self.power_gain_1, self.exponent_1, size, "m/s", facts.period),
        ]

    def init(self) -> TerminalErrorDynamicsState:
        return TerminalErrorDynamicsState(0.0, 0.0, 0.0, 0.0)

    def step(
        self, s: TerminalErrorDynamicsState, error: VelocityError, dt: float
    ) -> TerminalErrorDynamicsState:
        first = self.reaching.first(error.value, self.linear_gain_1, self.power_gain_1, self.exponent_1, dt)
        xi2 = error.rate + first.rate + error.force_surface + error.velocity_surface
        return TerminalErrorDynamicsState(
            first.slope * error.rate,
            self.reaching.second(xi2, self.linear_gain_2, self.power_gain_2, self.exponent_2, dt),
            error.value,
            xi2,
        )
