"""Adaptive backstepping, and direct adaptive robust control where it has a robust term."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.no_basis import NoBasis
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.observers.no_observer import NoObserver
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts, above, near, sampled_faster, valve_faster
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Basis, Controller, Observer, controlling, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants.design_model import THIS_MACHINE, DesignModel

LEAST = 1e-300  # keeps the share of a size beyond the dead zone finite where the size is 0


class Unknowns(NamedTuple):
    """A number for each thing not known of the machine: its estimate, or its effect as an acceleration."""

    damping: Annotated[float, Field("", "factor on the model's f1")]
    stiffness: Annotated[float, Field("", "factor on the model's f2(x1, 0)")]
    leakage: Annotated[float, Field("", "factor on the model's f2(0, x2)")]
    input_gain: Annotated[float, Field("", "factor on the model's g2")]
    load: Annotated[float, Field("m/s^2", "what else accelerates the piston")]
    flow: Annotated[float, Field("N/s", "what else changes the hydraulic force")]

    def squared(self, passed: float) -> float:
        """Sum of squares, where those that act on z1 act on e2 too, by a share ``passed``."""
        first = self.damping * self.damping + self.load * self.load
        second = self.stiffness * self.stiffness + self.leakage * self.leakage
        third = self.input_gain * self.input_gain + self.flow * self.flow
        return (1.0 + passed * passed) * first + second + third

    def most(self, passed: float) -> float:
        """Sum of sizes as they act on e2."""
        first = ops.absolute(self.damping) + ops.absolute(self.load)
        second = ops.absolute(self.stiffness) + ops.absolute(self.leakage)
        third = ops.absolute(self.input_gain) + ops.absolute(self.flow)
        return ops.absolute(passed) * first + second + third


class AdaptiveRobustState(NamedTuple):
    """The last command, the errors, what is estimated, and the states of the nested observer and basis."""

    u: Annotated[float, Field("V", "command")]
    unlimited: Annotated[float, Field("V", "command before saturation")]
    z1: Annotated[float, Field("m/s", "velocity less demand, z1")]
    z2: Annotated[float, Field("N", "error of the virtual control z2 = x2 - zeta1")]
    estimates: Unknowns
    observer: Block
    weights: Block


@role(Controller)
@controlling(Velocity)
class AdaptiveRobust(NamedTuple):
    """Backstepping on a model whose terms have factors that are estimated while the loop runs.

    The model, with a factor theta on each nominal term (1: as modelled), two constants and a function that
    the nested ``basis`` learns::

        dx1/dt = t_b f1(x1) + g1 x2 + t_d + a(x1)
        dx2/dt = t_k f2(x1, 0) + t_l f2(0, x2) + t_g g2 u + t_e

    The law is that of :class:`Backstepping` on it, with e2 = z2 g1/k1 the second error as a velocity, and
    A the most that what is unknown can accelerate e2 by::

        zeta1 = (-k1 z1 - t_b f1 - t_d + r')/g1,   z2 = x2 - zeta1
        u     = (-(k2 + k_s) z2 - t_k f2(x1, 0) - t_l f2(0, x2) - t_e - g1 z1 + dzeta1/dt)/(t_g g2)
        k_s   = kappa A^2/(1 + h kappa A^2)

    Each estimate follows the gradient of z1^2 + e2^2, and dzeta1/dt has in it how t_b and t_d change (tuning
    functions). With phi the term that an estimate stands at, as an acceleration of z1 or e2, and s how far
    the estimate may be from nominal::

        dt_b/dt, dt_d/dt      = gamma s^2 phi (z1 + p e2)/N,   p = (k1 + t_b f1')/k1
        dt_k/dt ... dt_e/dt   = gamma s^2 phi e2/N
        N                     = 1 + 4 h gamma/min(k1, k2) sum(s^2 phi^2)

    with those of t_b and t_d in the sum 1 + p^2 times, for they act on both errors. Estimates are clipped to
    nominal +-s, and factors at 0: what is more uncertain is adapted more, as in least squares that start from
    there. N keeps their step, at any gain, below half of what the sampled decay of the errors bears; kappa
    A^2 is taken by an implicit step for the same reason. Errors are shortened by ``dead_zone``, so that
    nothing is adapted within it, nor after a sample at which the law's own saturation limited the command.
    Weights of a basis are adapted as t_d is, with phi its functions.
    kappa = 0 is adaptive backstepping, kappa > 0 adaptive robust control, gamma = kappa = 0 Backstepping.
    x1, x2 and what is known of the disturbances are as the nested ``observer`` hands them on; u in phi and A
    is the command applied over the last period.

    Source: Krstic, Kanellakopoulos, Kokotovic, Nonlinear and Adaptive Control Design, 1995, ch. 4 (tuning
    functions); Yao, Tomizuka, Automatica 33(5), 1997, and, for a double-rod cylinder, Yao, Bu, Chiu, Int. J.
    Control 74(8), 2001 (all unverified). The weight g1/k1 of z2, N and the implicit k_s are derived here.
    Fails where k2 is not above k1/4, which the proof with that weight asks for; where the law without
    adaptation fails for being sampled too slowly against the oil; under noise, which reaches the estimates,
    as dead_zone must be above it; where the valve lags (ValveInversion helps), for the factors take that for
    a fault of the model; and where the demand excites too little, for then the estimates drift to whatever
    makes the errors small. The mass is taken as known.
    """

    velocity_gain: Annotated[float, Field("1/s", "gain k1", above=0)]
    force_gain: Annotated[float, Field("1/s", "gain k2", above=0)]
    adaptation_gain: Annotated[float, Field("s^2/m^2", "gain gamma of all estimates", at_least=0)]
    robust_gain: Annotated[
        float, Field("s^3/m^2", "gain kappa of the robust term", "0: adaptation alone", at_least=0)
    ] = 0.0
    damping_spread: Annotated[
        float, Field("", "how far the factor on f1 may be from 1", "0: known", at_least=0)
    ] = 0.0
    stiffness_spread: Annotated[
        float, Field("", "how far the factor on f2(x1, 0) may be from 1", "0: known", at_least=0)
    ] = 0.0
    leakage_spread: Annotated[
        float, Field("", "how far the factor on f2(0, x2) may be from 1", "0: known", at_least=0)
    ] = 0.0
    input_spread: Annotated[
        float, Field("", "how far the factor on g2 may be from 1", "0: known", at_least=0, below=1)
    ] = 0.0
    largest_load: Annotated[
        float, Field("m/s^2", "bound on the constant acceleration", "0: none", at_least=0)
    ] = 0.0
    largest_flow: Annotated[
        float, Field("N/s", "bound on the constant rate of the hydraulic force", "0: none", at_least=0)
    ] = 0.0
    dead_zone: Annotated[
        float, Field("m/s", "size of both errors within which nothing is adapted", "0: none", at_least=0)
    ] = 0.0
    model: DesignModel = THIS_MACHINE
    saturation: Saturation = Saturation()
    observer: Observer = NoObserver()
    basis: Basis = NoBasis()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        truth, model, load, flow = facts.truth, self.model, *facts.disturbances
        fastest = max(self.velocity_gain, self.force_gain)
        found = [
            above("gains", "k2 is above k1/4", self.force_gain, 0.25 * self.velocity_gain, "1/s"),
            sampled_faster(fastest, facts, "the larger of k1 and k2"),
            valve_faster(fastest, facts, "the larger of k1 and k2"),
            above(
                "dead zone", "dead_zone is above the velocity's noise", self.dead_zone, facts.noise[0], "m/s"
            ),
            Assumption(
                "excitation", "the demand excites as much as is estimated", math.nan, math.nan, "", math.nan
            ),
        ]
        if self.largest_load:
            meaning = "largest_load is above the largest d_L1"
            found += [above("load's bound", meaning, self.largest_load, load, "m/s^2", measured=True)]
        if self.largest_flow:
            meaning = "largest_flow is above the largest d_L2"
            found += [above("flow's bound", meaning, self.largest_flow, flow, "N/s", measured=True)]
        if truth is None:
            return found
        factors = (
            ("damping", "damping_spread", truth.f1_slope(), model.f1_slope()),
            ("stiffness", "stiffness_spread", truth.f2(1.0, 0.0), model.f2(1.0, 0.0)),
            ("leakage", "leakage_spread", truth.f2(0.0, 1.0), model.f2(0.0, 1.0)),
            ("input gain", "input_spread", truth.g2(0.0, 0.0), model.g2(0.0, 0.0)),
        )
        for name, spread, is_, taken in factors:
            if taken:
                meaning, apart = f"{spread} is above what the machine differs by", abs(is_ / taken - 1.0)
                found += [above(f"{name}'s bound", meaning, getattr(self, spread), apart)]
        meaning = "the mass of the model is within 10 % of the machine's"
        return [*found, near("mass known", meaning, model.plant.mass, truth.plant.mass, 1.1, "kg")]

    def init(self) -> AdaptiveRobustState:
        nominal = Unknowns(1.0, 1.0, 1.0, 1.0, 0.0, 0.0)
        return AdaptiveRobustState(0.0, 0.0, 0.0, 0.0, nominal, self.observer.init(), self.basis.init())

    def step(self, s: AdaptiveRobustState, y: Measurement, r: Demand, dt: float) -> AdaptiveRobustState:
        m, k1, t = self.model, self.velocity_gain, s.estimates
        o = self.observer.step(s.observer, m, y, dt)
        x1, x2 = o.velocity, o.hydraulic_force
        f1, g1 = m.f1(x1), m.g1()
        functions = self.basis.at(x1)
        f1_slope = t.damping * m.f1_slope() + self.basis.slope(s.weights, functions)
        z1 = x1 - r.value
        learnt = self.basis.value(s.weights, functions)
        known = t.damping * f1 + t.load + learnt + o.d1
        z2 = x2 - (-k1 * z1 - known + r.rate) * (1.0 / g1)

        e2, passed = z2 * (g1 / k1), (k1 + f1_slope) / k1
        effect = self.effects(x1, x2, y.command)
        squared = effect.squared(passed) + (1.0 + passed * passed) * self.basis.squared(functions)
        weight = self.weight(z1, e2, squared, dt) * ops.where(s.u == s.unlimited, 1.0, 0.0)
        drive = weight * (z1 + passed * e2)
        estimates = self.adapted(t, effect, drive, weight * e2)
        weights = self.basis.adapted(s.weights, functions, drive, dt)
        moved = (estimates.damping - t.damping) * f1 + estimates.load - t.load
        moved = moved + (self.basis.value(weights, functions) - learnt)

        acceleration = known + g1 * x2
        zeta1_rate = (
            -k1 * (acceleration - r.rate) - f1_slope * acceleration - moved / dt + r.second_rate
        ) * (1.0 / g1)
        free = t.stiffness * m.f2(x1, 0.0) + t.leakage * m.f2(0.0, x2) + t.flow + o.d2
        most = effect.most(passed) + ops.absolute(passed) * self.basis.most(functions)
        feedback = self.force_gain + self.robust(most, dt)
        numerator = -feedback * z2 - free - g1 * z1 + zeta1_rate
        input_gain = ops.maximum(t.input_gain, 1.0 - self.input_spread) * m.g2(x2, y.command)
        wanted = numerator / input_gain
        return AdaptiveRobustState(self.saturation.apply(wanted), wanted, z1, z2, estimates, o, weights)

    def effects(self, x1: float, x2: float, u: float) -> Unknowns:
        """What accelerates z1 or e2 if an unknown is off by its whole spread [m/s^2]."""
        m = self.model
        weight = m.g1() / self.velocity_gain
        return Unknowns(
            damping=self.damping_spread * m.f1(x1),
            stiffness=self.stiffness_spread * weight * m.f2(x1, 0.0),
            leakage=self.leakage_spread * weight * m.f2(0.0, x2),
            input_gain=self.input_spread * weight * m.g2(x2, u) * u,
            load=self.largest_load,
            flow=self.largest_flow * weight,
        )

    def weight(self, z1: float, e2: float, squared: float, dt: float) -> float:
        """dt gamma/N [s^3/m^2], times the share of the errors that lies beyond the dead zone."""
        size = ops.sqrt(z1 * z1 + e2 * e2)
        beyond = ops.maximum(size - self.dead_zone, 0.0) / (size + LEAST)
        slowest = ops.minimum(self.velocity_gain, self.force_gain)
        step = dt * self.adaptation_gain
        return beyond * step / (1.0 + 4.0 * step / slowest * squared)

    def adapted(self, t: Unknowns, effect: Unknowns, first: float, second: float) -> Unknowns:
        """The estimates moved by their spread times their effect times the errors, within their bounds."""
        load, flow = self.largest_load, self.largest_flow
        return Unknowns(
            damping=self.factor(t.damping, self.damping_spread, effect.damping * first),
            stiffness=self.factor(t.stiffness, self.stiffness_spread, effect.stiffness * second),
            leakage=self.factor(t.leakage, self.leakage_spread, effect.leakage * second),
            input_gain=self.factor(t.input_gain, self.input_spread, effect.input_gain * second),
            load=self.moved(t.load, -load, load, load * effect.load * first),
            flow=self.moved(t.flow, -flow, flow, flow * effect.flow * second),
        )

    def factor(self, value: float, spread: float, drive: float) -> float:
        return self.moved(value, ops.maximum(1.0 - spread, 0.0), 1.0 + spread, spread * drive)

    def moved(self, value: float, least: float, largest: float, step: float) -> float:
        """Within bounds; a step that is not a number, after a measurement that is none, is none."""
        return ops.clip(value + ops.where(ops.isnan(step), 0.0, step), least, largest)

    def robust(self, most: float, dt: float) -> float:
        """k_s [1/s]."""
        gain = self.robust_gain * most * most
        return gain / (1.0 + dt * gain)
