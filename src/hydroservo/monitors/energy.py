"""The hydraulic energy that a run takes."""

from typing import Annotated, NamedTuple

from hydroservo.block import Block
from hydroservo.field import Field
from hydroservo.roles import Monitor, role

__all__ = ["Energy", "EnergyState", "EnergyValues"]


class EnergyState(NamedTuple):
    """Integrals so far [J]."""

    supplied: float
    lost: float


class EnergyValues(NamedTuple):
    """The energies of the run."""

    supply_energy: Annotated[float, Field("J", "energy drawn at the supply's port", smaller_is_better=True)]
    valve_loss: Annotated[float, Field("J", "energy that the valve turns into heat", smaller_is_better=True)]


@role(Monitor)
class Energy(NamedTuple):
    """The energy that the valve draws from the supply, and what of it is lost in the valve.

    supplied = integral of p_P Q_P dt,   lost = integral of (p_P Q_P - p_T Q_T - p_A Q_A + p_B Q_B) dt

    with gauge pressures p and the flows Q into port P, out of T and A, and into B; by the left rule over the
    integrator's steps.

    Source: the power p Q at each port of the valve.
    Fails to know what the supply itself loses: the relief valve's flow and the pump's friction.
    """

    def init(self) -> EnergyState:
        return EnergyState(0.0, 0.0)

    def step(self, m: EnergyState, loop: Block, s: Block, t: float, dt: float) -> EnergyState:
        line = loop.supply.pressures(s.supply)
        opening = loop.valve.opening(s.valve, loop.hold.at(loop.held(s), t))
        flows = loop.plant.flows(s.plant, loop.valve.orifice, opening, line)
        ports = loop.plant.outputs(s.plant, line)
        supplied = line.supply * flows.supply
        used = line.tank * flows.tank + ports.pressure_a * flows.a - ports.pressure_b * flows.b
        return EnergyState(m.supplied + supplied * dt, m.lost + (supplied - used) * dt)

    def values(self, m: EnergyState) -> EnergyValues:
        return EnergyValues(m.supplied, m.lost)
