"""A law whose command carries a small square wave, which keeps the spool moving."""

from typing import Annotated, Any, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block, Field, is_block
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class DitherState(NamedTuple):
    """The command, its share of dither, the phase of that, and the state of the law."""

    u: Annotated[float, Field("V", "command")]
    added: Annotated[float, Field("V", "dither in the command")]
    phase: Annotated[float, Field("Hz", "the dither's cycles, less whole ones, times the sample rate")]
    controller: Block


@role(Controller)
class Dither(NamedTuple):
    """The command of a nested law, and a square wave of mean 0::

        u_k = u_law + (a/h) (integral of sgn(sin(2 pi f t)) over t from k h to (k + 1) h)

    Each sample has the wave's mean over it: +a or -a, and less where the wave changes its sign within the
    sample. So the dither has no mean, whatever the frequency. The phase is counted in samples, p := (p + f)
    mod 1/h, without rounding where f and 1/h are whole numbers of hertz.

    A play of full width w [V] between command and spool becomes one of w - 2 a for slower commands, and none
    from a = w/2 on, where both halves of the wave move the spool. The nested law learns of the applied
    command without the dither; where a limit outside cuts the wave off, that is what was applied in the mean
    over a cycle.

    Source: Merritt, Hydraulic Control Systems, 1967 (dither against friction and hysteresis of the valve);
    Desoer and Shahruz, International Journal of Control 43(4), 1986, for backlash and hysteresis in a loop.
    Fails against overlap, of which it only rounds the corners off over +-a; with a frequency so low that the
    axis follows and shakes; and behind a valve so slow that its stiction, unlike play, feels little of the
    wave. It costs wear of the spool, and ripple in the lines.
    """

    controller: Controller
    amplitude: Annotated[float, Field("V", "amplitude a of the dither", at_least=0)]
    frequency: Annotated[float, Field("Hz", "frequency f, below half the sample rate", above=0)]

    def smoothed(self) -> "Dither":
        return self._replace(amplitude=0.0)

    def init(self) -> DitherState:
        return DitherState(0.0, 0.0, 0.0, self.controller.init())

    def step(self, s: DitherState, y: Measurement, r: Demand, dt: float) -> DitherState:
        controller = self.controller.step(s.controller, y.with_command(y.command - s.added), r, dt)
        rate = 1.0 / dt
        later = s.phase + self.frequency
        phase = later - rate * ops.floor(later / rate)
        up = ops.absolute(s.phase - 0.5 * rate) - ops.absolute(phase - 0.5 * rate)  # f times the mean
        added = self.amplitude * (up / self.frequency)
        return DitherState(controller.u + added, added, phase, controller)


def without_dither(law: Block) -> Any:
    """A law without dither, in it or in a block in it."""
    parts = {name: without_dither(part) for name, part in law._asdict().items() if is_block(part)}
    law = law._replace(**parts)
    return law.smoothed() if isinstance(law, Dither) else law
