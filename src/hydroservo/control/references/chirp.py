"""A sinusoidal demand that sweeps through frequencies."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand
from hydroservo.core.sources import CHOSEN


@role(Reference)
class Chirp(NamedTuple):
    """A sine whose frequency rises or falls linearly over the sweep and then stays, with exact derivatives.

    With f0 and f1 the first and last frequency, T the sweep time and tau = min(t, T)::

        r = amplitude sin(2 pi (f0 tau + (f1 - f0) tau^2/(2 T) + f1 (t - tau)))

    Value and rate are continuous at the end of the sweep; the second derivative jumps there.

    Source: Pintelon and Schoukens, System Identification, 2012, ch. 5 (the swept sine).
    Fails to excite evenly: the spectrum ripples near f0 and f1, and after T only f1 is excited; see
    Multisine.
    """

    amplitude: Annotated[float, Field("y", "amplitude")]
    first_frequency: Annotated[float, Field("Hz", "frequency f0 at t = 0", CHOSEN, at_least=0)] = 0.1
    last_frequency: Annotated[float, Field("Hz", "frequency f1 at the end", CHOSEN, at_least=0)] = 10.0
    sweep_time: Annotated[float, Field("s", "duration T of the sweep", CHOSEN, above=0)] = 8.0

    def at(self, t: float) -> Demand:
        span = self.last_frequency - self.first_frequency
        sweeping = t < self.sweep_time
        tau = ops.where(sweeping, t, self.sweep_time)
        done = tau / self.sweep_time
        cycles = (self.first_frequency + 0.5 * span * done) * tau + self.last_frequency * (t - tau)
        omega = 2.0 * math.pi * (self.first_frequency + span * done)
        omega_rate = ops.where(sweeping, 2.0 * math.pi * span / self.sweep_time, 0.0)
        sine, cosine = ops.sin(2.0 * math.pi * cycles), ops.cos(2.0 * math.pi * cycles)
        return Demand(
            self.amplitude * sine,
            self.amplitude * omega * cosine,
            self.amplitude * (omega_rate * cosine - omega * omega * sine),
        )
