"""The energy that a run takes."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, role


class EnergyState(NamedTuple):
    """Integrals so far [J]."""

    supplied: Annotated[float, Field("J", "energy that the drive drew so far")]
    lost: Annotated[float, Field("J", "what of it did not reach the cylinder or the tank's line so far")]


class EnergyValues(NamedTuple):
    """The energies of the run."""

    supply_energy: Annotated[
        float,
        Field("J", "energy that the drive draws, not what the supply's pump takes", smaller_is_better=True),
    ]
    valve_loss: Annotated[
        float, Field("J", "what of it does not reach the cylinder or the tank's line", smaller_is_better=True)
    ]


@role(Monitor)
class Energy(NamedTuple):
    """The energy that the drive draws, and what of it is lost between there and the cylinder.

    supplied = integral of P dt,   lost = integral of (P - p_T Q_T - p_A Q_A + p_B Q_B) dt

    with gauge pressures p and the flows Q out of the ports T and A and into B; by the left rule over the
    integrator's steps. P is the power that the drive draws: p_P Q_P of a valve, with the flow Q_P into its
    port P; of a pump on a motor that of the replenishing line and of the motor's shaft. What a motor takes
    back while it brakes counts negative.

    Source: the power p Q at each port, the torque times speed of a shaft.
    Fails to know what the supply itself loses: the relief valve's flow and the pump's friction. What the oil
    in hoses and a shaft's inertia hold at the end of the run counts as lost.
    """

    def init(self) -> EnergyState:
        return EnergyState(0.0, 0.0)

    def step(self, m: EnergyState, loop: Block, s: Block, t: float, dt: float) -> EnergyState:
        ports = loop.ports(loop.machine(s), loop.hold.at(loop.held(s), t))
        line, flows = ports.feed.line, loop.plant.flows(s.plant, ports)
        seen = loop.seen(s, s.load.force)
        supplied = ports.power(flows, seen.pressure_a, seen.pressure_b)
        used = line.tank * flows.tank + seen.pressure_a * flows.a - seen.pressure_b * flows.b
        return EnergyState(m.supplied + supplied * dt, m.lost + (supplied - used) * dt)

    def values(self, m: EnergyState) -> EnergyValues:
        return EnergyValues(m.supplied, m.lost)
