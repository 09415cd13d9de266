# %% [markdown]
# # A law of my own
#
# A law is a class with its numbers, a state, and one step. It is compiled with the machine, tuned, and
# exported to C as any other.

# %%
from typing import Annotated, NamedTuple

import hydroservo as hs
from hydroservo import Field, ops
from hydroservo.control.controllers import Saturation
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class State(NamedTuple):
    """What the law remembers."""

    u: Annotated[float, Field("V", "command")]
    integral: Annotated[float, Field("V", "integral part of the command")]


@role(Controller)
class ForwardPI(NamedTuple):
    """PI with feedforward of the demand: u = sat(k_v r + k_p e + k_i int e dt)."""

    feedforward: Annotated[float, Field("V s/m", "feedforward k_v", at_least=0)] = 0.96
    proportional_gain: Annotated[float, Field("V s/m", "gain k_p", at_least=0)] = 3.2
    integral_gain: Annotated[float, Field("V/m", "gain k_i", at_least=0)] = 600.0
    saturation: Saturation = Saturation()

    def init(self) -> State:
        return State(0.0, 0.0)

    def step(self, s: State, y: Measurement, r: Demand, dt: float) -> State:
        error = r.value - y.velocity
        integral = s.integral + dt * self.integral_gain * error
        wanted = self.feedforward * r.value + self.proportional_gain * error + integral
        u = self.saturation.apply(wanted)
        return State(u, ops.where(u == wanted, integral, s.integral))


# %%
loop = hs.load_scenario("rig/1khz-pi-sine")
mine = hs.replace(loop, {"controller": ForwardPI()})
runs = {"PI": hs.simulate(loop), "with feedforward": hs.simulate(mine)}
{name: f"{1e3 * float(run['rms_error']):.4f} mm/s rms" for name, run in runs.items()}

# %%
picture = hs.plot(runs)
picture.save("own_law.png")
picture
