"""What the paper prints and cannot mean, followed to the letter: laws, loops and the bound of Lemma 1."""

from typing import Annotated, Any, NamedTuple

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.backstepping import Backstepping
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.controllers.tsmc import TSMC, TSMCState
from hydroservo.control.loop import Loop
from hydroservo.core import ops
from hydroservo.core.block import Block, Field, replace, value_at
from hydroservo.core.roles import Controller, Differentiator, Observer, controlling, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants.design_model import DesignModel
from hydroservo.machine.theory import settling_bound
from hydroservo.papers.tsmc_eha_2021.machine import (
    BACKSTEPPING,
    COMMAND_LIMIT,
    MODEL,
    OBSERVER,
    SOURCE,
    TERMINAL,
)


class PrintedBacksteppingState(NamedTuple):
    """The last command and errors, the demand's integral, and the state of the nested derivative."""

    u: Annotated[float, Field("V", "command")]
    z1: Annotated[float, Field("m/s", "error z1 = x1 - y_d, whose units do not match")]
    z2: Annotated[float, Field("N", "error of the virtual control z2 = x2 - zeta1")]
    demand_position: Annotated[float, Field("m", "y_d, the integral of the demand")]
    derivative: Block


@role(Controller)
@controlling(Velocity)
class PrintedBackstepping(NamedTuple):
    """Two-step backstepping to the letter of the print.

    With z1 = x1 - y_d, f1 = +b x1/m, zeta1 the virtual control and z2 = x2 - zeta1::

        zeta1 = (-k1 z1 - f1 + d2y_d/dt2)/g1
        u     = (-k2 z2 - f2 - g1 z1 + dzeta1/dt)/g2

    y_d is the integral of the demand, so that a velocity follows a position; f1 has the wrong sign.
    :class:`~hydroservo.control.controllers.Backstepping` mends both. dzeta1/dt comes from the nested block.

    Source: eq. (26) of doi:10.1007/s42401-021-00087-w.
    Fails to track: z1 is the difference of a velocity and a position.
    """

    velocity_gain: Annotated[float, Field("1/s", "gain k1", SOURCE, above=0)] = BACKSTEPPING.velocity_gain
    force_gain: Annotated[float, Field("1/s", "gain k2", SOURCE, above=0)] = BACKSTEPPING.force_gain
    model: DesignModel = MODEL
    derivative: Differentiator = BACKSTEPPING.derivative
    saturation: Saturation = COMMAND_LIMIT

    def init(self) -> PrintedBacksteppingState:
        return PrintedBacksteppingState(0.0, 0.0, 0.0, 0.0, self.derivative.init())

    def step(
        self, s: PrintedBacksteppingState, y: Measurement, r: Demand, dt: float
    ) -> PrintedBacksteppingState:
        m = self.model
        x1, x2 = y.velocity, y.hydraulic_force
        f1, f1_slope, g1 = -m.f1(x1), -m.f1_slope(), m.g1()
        z1 = x1 - s.demand_position
        zeta1 = (-self.velocity_gain * z1 - f1 + r.rate) * (1.0 / g1)
        acceleration = f1 + g1 * x2
        z1_rate = acceleration - r.value
        model_rate = (-self.velocity_gain * z1_rate - f1_slope * acceleration + r.second_rate) * (1.0 / g1)
        derivative = self.derivative.step(s.derivative, zeta1, model_rate, dt)
        z2 = x2 - zeta1
        numerator = -self.force_gain * z2 - m.f2(x1, x2) - g1 * z1 + derivative.rate
        u = self.saturation.apply(numerator / m.g2(x2, y.command))
        return PrintedBacksteppingState(u, z1, z2, s.demand_position + dt * r.value, derivative)


@role(Controller)
@controlling(Velocity)
class PrintedTSMC(NamedTuple):
    """Terminal sliding mode velocity control to the letter of the print.

    With a_i = p_i/q_i and every power odd (|x|^a sgn x)::

        xi1    = x1 - dy_d/dt + s1
        dxi1   = f1 + g1 x2 + d1 - d2y_d/dt2
        xi2    = dxi1 + mu1 xi1 + delta1 xi1^a1 + g1 s2 - b/m s1
        u      = -1/(g1 g2) [ -b/m (f1 + g1 x2 + d1) + g1 (f2 + d2) + d1 - d2y_d/dt2
                              + mu1 dxi1 + delta1 d(s1^a1)/dt + mu2 xi2 + delta2 xi2^a2 ]

    u has d1 where its derivative is meant, the second derivative of y_d for the third, and s1 for xi1 under
    the last derivative, which comes from the nested block. :class:`~hydroservo.control.controllers.TSMC`
    mends them.

    Source: eqs. (19)-(22) of doi:10.1007/s42401-021-00087-w, in the text as it reached us.
    Fails where ``TSMC`` does. The study of the paper shows what its wrong terms cost under each condition:
    next to mu1 dxi1 they are often small.
    """

    linear_gain_1: Annotated[float, Field("1/s", "gain mu_1", SOURCE, above=0)] = TERMINAL.linear_gain_1
    linear_gain_2: Annotated[float, Field("1/s", "gain mu_2", SOURCE, above=0)] = TERMINAL.linear_gain_2
    power_gain_1: Annotated[
        float, Field("m^(2/7)/s^(9/7)", "gain delta_1 [(m/s)^(1-a1)/s]", SOURCE, at_least=0)
    ] = TERMINAL.power_gain_1
    power_gain_2: Annotated[
        float, Field("m^(4/9)/s^(17/9)", "gain delta_2 [(m/s^2)^(1-a2)/s]", SOURCE, at_least=0)
    ] = TERMINAL.power_gain_2
    exponent_1: Annotated[float, Field("", "exponent a1 = p_1/q_1", SOURCE, at_least=0.1, below=1)] = (
        TERMINAL.exponent_1
    )
    exponent_2: Annotated[float, Field("", "exponent a2 = p_2/q_2", SOURCE, at_least=0.1, below=1)] = (
        TERMINAL.exponent_2
    )
    model: DesignModel = MODEL
    observer: Observer = OBSERVER
    derivative: Differentiator = TERMINAL.derivative
    saturation: Saturation = COMMAND_LIMIT

    def init(self) -> TSMCState:
        return TSMCState(0.0, 0.0, 0.0, self.observer.init(), self.derivative.init())

    def step(self, s: TSMCState, y: Measurement, r: Demand, dt: float) -> TSMCState:
        m = self.model
        o = self.observer.step(s.observer, m, y, dt)
        x1, x2 = o.velocity, o.hydraulic_force
        g1, f1_slope = m.g1(), m.f1_slope()
        xi1 = x1 - r.value + o.s1
        acceleration = m.f1(x1) + g1 * x2 + o.d1
        xi1_rate = acceleration - r.rate
        pull = self.linear_gain_1 * xi1 + self.power_gain_1 * ops.signed_power(xi1, self.exponent_1)
        xi2 = xi1_rate + pull + g1 * o.s2 + f1_slope * o.s1
        derivative = self.derivative.step(s.derivative, ops.signed_power(o.s1, self.exponent_1), 0.0, dt)
        drift = (
            f1_slope * acceleration
            + g1 * (m.f2(x1, x2) + o.d2)
            + o.d1
            - r.rate
            + (self.linear_gain_1 * xi1_rate + self.power_gain_1 * derivative.rate)
            + (self.linear_gain_2 * xi2 + self.power_gain_2 * ops.signed_power(xi2, self.exponent_2))
        )
        u = self.saturation.apply(-drift * (1.0 / (g1 * m.g2(x2, y.command))))
        return TSMCState(u, xi1, xi2, o, derivative)


LAWS: dict[type, Any] = {Backstepping: PrintedBackstepping, TSMC: PrintedTSMC}  # PI is as printed


def printed_settling_bound(
    linear_rate: float, power_rate: float, exponent: float, initial: float, start: float = 0.0
) -> float:
    """The printed instant [s] by which a function V that decreases as in Lemma 1 were zero.

    ::

        t_0 + 1/(mu (1 + alpha)) ln(1 + mu V(t_0)^(1 - alpha)/delta)

    That is no bound: it is shorter than the right one by the factor (1 - alpha)/(1 + alpha).

    Args:
        linear_rate: mu [1/s], above 0.
        power_rate: delta [V^(1 - alpha)/s], above 0.
        exponent: alpha, above 0 and below 1.
        initial: V(t_0), in the unit of V, at least 0.
        start: t_0 [s].

    Raises:
        ParameterError: an argument out of range.

    Source: eq. (9) of doi:10.1007/s42401-021-00087-w.
    Fails always: where V decreases no faster than it must, it is still positive then.
    """
    right = settling_bound(linear_rate, power_rate, exponent, initial)
    return start + right * (1.0 - exponent) / (1.0 + exponent)


def printed(loop: Loop) -> Loop:
    """A loop with the machine and the law as they are printed: see the two functions below."""
    return printed_law(printed_leakage(loop))


def printed_leakage(loop: Loop) -> Loop:
    """A loop whose machine has the leakage term of the print, as has all that is believed of it.

    It is 4 beta_e A_p C_tl/V_t x2 for 4 beta_e C_tl/V_t x2: the machine with A_p C_tl in place of C_tl.
    The units do not match, and next to no damping is left.

    Args:
        loop: its plant is a :class:`~hydroservo.machine.plants.LoadPressurePlant`.

    Source: eqs. (5), (7) and (26) of doi:10.1007/s42401-021-00087-w.
    """
    paths = ["plant"]
    if isinstance(getattr(loop.controller, "model", None), DesignModel):
        paths.append("controller.model.plant")
    plants = {path: value_at(loop, path) for path in paths}
    changed: Loop = replace(
        loop, {f"{path}.leakage": plant.piston_area * plant.leakage for path, plant in plants.items()}
    )
    return changed


def printed_law(loop: Loop) -> Loop:
    """A loop whose ``TSMC`` or ``Backstepping`` is :class:`PrintedTSMC` or :class:`PrintedBackstepping`.

    Any other law, such as PI, stays.
    """
    kind = LAWS.get(type(loop.controller))
    if kind is None:
        return loop
    return loop._replace(controller=kind(**{name: getattr(loop.controller, name) for name in kind._fields}))
