"""A terminal sliding mode observer whose switching gains follow the disturbances that they must exceed."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.observers.tsm import TSMObserver, TSMObserverState
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts, Peak, above, per_second
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import Observer, role
from hydroservo.core.signals import Measurement
from hydroservo.core.sources import CHOSEN
from hydroservo.machine.plants.design_model import DesignModel


class AdaptiveTSMObserverState(NamedTuple):
    """What TSMObserver has as its state, and the switching gains with what they follow."""

    s1: Annotated[float, Field("m/s", "observer surface s1 = v1 - x1")]
    s2: Annotated[float, Field("N", "observer surface s2 = v2 - x2")]
    d1: Annotated[float, Field("m/s^2", "estimate of the lumped disturbance d_L1")]
    d2: Annotated[float, Field("N/s", "estimate of the lumped disturbance d_L2")]
    velocity: Annotated[float, Field("m/s", "measured velocity, which the law takes")]
    hydraulic_force: Annotated[float, Field("N", "measured hydraulic force, which the law takes")]
    v1: Annotated[float, Field("m/s", "velocity predicted for the next sample")]
    v2: Annotated[float, Field("N", "hydraulic force predicted for the next sample, without the command")]
    g2: Annotated[float, Field("N/(s V)", "input gain g2 of this period")]
    switching_gain_1: Annotated[float, Field("m/s^2", "switching gain D_1")]
    switching_gain_2: Annotated[float, Field("N/s", "switching gain D_2")]
    filtered_1: Annotated[float, Field("m/s^2", "estimate of d_L1, low-passed")]
    filtered_2: Annotated[float, Field("N/s", "estimate of d_L2, low-passed")]


@role(Observer)
class AdaptiveTSMObserver(NamedTuple):
    """A :class:`TSMObserver` whose switching gains are no larger than the disturbances ask for, nor smaller.

    On a surface the switching term's mean is the disturbance: the equivalent of sgn. Each gain D, with least
    and largest value and rate R, and the estimate d through a low-pass, d_f, follows it at a margin alpha::

        dd_f/dt = w (d - d_f)
        dD/dt   = R sgn(D_least + alpha |d_f| - D)

    which ends at its target and does not switch about it. Off its surface an estimate is D and more, so that
    the target is ahead of D, which grows at its rate until the surface is reached, whatever the disturbance;
    on it D comes down again to D_least + alpha |d_L|. The nested observer's own switching gains are the least
    ones, from which they start.

    Source: Edwards, Shtessel, Int. J. Control 89(9), 2016 (dual layer; unverified), with one rate in place of
    its second layer; gains that grow off the surface and shrink on it: Shtessel, Taleb, Plestan, Automatica
    48(5), 2012 (unverified).
    Fails where a disturbance grows by more than R/alpha for long: its surface is then left until the gain has
    caught up. Noise of a measurement, over the sample period, is a disturbance to it, which only w quietens.
    """

    observer: TSMObserver
    largest_gain_1: Annotated[float, Field("m/s^2", "largest switching gain D_1", above=0)]
    largest_gain_2: Annotated[float, Field("N/s", "largest switching gain D_2", above=0)]
    gain_rate_1: Annotated[float, Field("m/s^3", "rate R of D_1", above=0)]
    gain_rate_2: Annotated[float, Field("N/s^2", "rate R of D_2", above=0)]
    margin: Annotated[float, Field("", "alpha, gain per disturbance", CHOSEN, above=1)] = 1.5
    filter_rate: Annotated[float, Field("1/s", "rate w of the low-pass", CHOSEN, above=0)] = 200.0

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        found = []
        for i, gain, rate in (
            (0, self.largest_gain_1, self.gain_rate_1),
            (1, self.largest_gain_2, self.gain_rate_2),
        ):
            unit, largest, speed = ("m/s", "N")[i], facts.disturbances[i], facts.disturbance_rates[i]
            needed = Peak(self.margin * largest.value, largest.time)
            meaning = f"the largest D_{i + 1} is above alpha times the largest d_L{i + 1}"
            found.append(above(f"Lemma 2, D_{i + 1}", meaning, gain, needed, per_second(unit), measured=True))
            faster = Peak(self.margin * speed.value, speed.time)
            meaning = f"R of D_{i + 1} is above alpha times the rate of d_L{i + 1}"
            found.append(
                above("gain's rate", meaning, rate, faster, per_second(per_second(unit)), measured=True)
            )
        return found

    def check(self) -> None:
        o = self.observer
        for i, least, largest in (
            (1, o.switching_gain_1, self.largest_gain_1),
            (2, o.switching_gain_2, self.largest_gain_2),
        ):
            if least > largest:
                allowed = f"must be at least observer.switching_gain_{i}, {least:g}, the least"
                raise ParameterError(f"largest_gain_{i}", largest, allowed)

    def init(self) -> AdaptiveTSMObserverState:
        o = self.observer
        first = o.init()
        return AdaptiveTSMObserverState(
            s1=first.s1,
            s2=first.s2,
            d1=first.d1,
            d2=first.d2,
            velocity=first.velocity,
            hydraulic_force=first.hydraulic_force,
            v1=first.v1,
            v2=first.v2,
            g2=first.g2,
            switching_gain_1=o.switching_gain_1,
            switching_gain_2=o.switching_gain_2,
            filtered_1=0.0,
            filtered_2=0.0,
        )

    def step(
        self, s: AdaptiveTSMObserverState, model: DesignModel, y: Measurement, dt: float
    ) -> AdaptiveTSMObserverState:
        least = self.observer
        observer = TSMObserver(
            least.linear_gain_1,
            least.linear_gain_2,
            s.switching_gain_1,
            s.switching_gain_2,
            least.power_gain_1,
            least.power_gain_2,
            least.exponent,
            least.realisation,
        )
        last = TSMObserverState(s.s1, s.s2, s.d1, s.d2, s.velocity, s.hydraulic_force, s.v1, s.v2, s.g2)
        o = observer.step(last, model, y, dt)
        filtered_1, filtered_2 = self.filtered(s.filtered_1, o.d1, dt), self.filtered(s.filtered_2, o.d2, dt)
        target_1 = ops.minimum(
            least.switching_gain_1 + self.margin * ops.absolute(filtered_1), self.largest_gain_1
        )
        target_2 = ops.minimum(
            least.switching_gain_2 + self.margin * ops.absolute(filtered_2), self.largest_gain_2
        )
        step_1, step_2 = dt * self.gain_rate_1, dt * self.gain_rate_2
        return AdaptiveTSMObserverState(
            s1=o.s1,
            s2=o.s2,
            d1=o.d1,
            d2=o.d2,
            velocity=o.velocity,
            hydraulic_force=o.hydraulic_force,
            v1=o.v1,
            v2=o.v2,
            g2=o.g2,
            switching_gain_1=ops.clip(target_1, s.switching_gain_1 - step_1, s.switching_gain_1 + step_1),
            switching_gain_2=ops.clip(target_2, s.switching_gain_2 - step_2, s.switching_gain_2 + step_2),
            filtered_1=filtered_1,
            filtered_2=filtered_2,
        )

    def filtered(self, last: float, estimate: float, dt: float) -> float:
        """The low-pass; what is not a number passes by it."""
        kept = ops.power(math.e, -self.filter_rate * dt)
        return ops.where(ops.isnan(estimate), last, estimate + kept * (last - estimate))
