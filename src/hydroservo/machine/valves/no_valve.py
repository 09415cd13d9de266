"""In place of a valve, where the drive needs none."""

from typing import NamedTuple

from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import MeteringEdges, Valve, role
from hydroservo.core.signals import PortFlows, Pressures
from hydroservo.machine.valves.orifice import Orifice


@role(MeteringEdges)
class NoEdges(NamedTuple):
    """Edges that nothing passes.

    Source: a definition.
    Fails never.
    """

    def flow(self, opening: float, supply_drop: float, load_pressure: float) -> float:
        return 0.0

    def port_flows(self, opening: float, line: Pressures, pressure_a: float, pressure_b: float) -> PortFlows:
        return PortFlows(0.0, 0.0, supply=0.0, tank=0.0)

    def simplified(self) -> Orifice:
        """Nothing a design model could be made of.

        Raises:
            ParameterError: always.
        """
        raise ParameterError("orifice", "NoEdges", "have no design model")


class NoValveState(NamedTuple):
    """It remembers nothing."""


@role(Valve)
class NoValve(NamedTuple):
    """No valve, for a loop whose drive stands in its place, such as
    :class:`~hydroservo.machine.drives.PumpDrive`.

    Edges that it is given, as by the base of a scenario, count for nothing.

    Source: a definition.
    Fails with a drive that needs a valve, with which it is refused.
    """

    orifice: MeteringEdges = NoEdges()

    def init(self) -> NoValveState:
        return NoValveState()

    def deriv(self, s: NoValveState, u: float) -> NoValveState:
        return s

    def opening(self, s: NoValveState, u: float) -> float:
        return 0.0
