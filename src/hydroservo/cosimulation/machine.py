"""An FMU as the machine of a loop: cylinder, valve, supply, sensors and what it moves in one."""

import math
from typing import Annotated, Any, NamedTuple

from hydroservo.core.block import Block, declared_fields
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import OPEN
from hydroservo.core.roles import Drive, Plant, Supply, role, valveless
from hydroservo.core.signals import Feed, MachineOutputs, PortFlows, Pressures
from hydroservo.cosimulation.load import STEP

MACHINE_INPUTS = {"command": "V", "external_force": "N"}
MACHINE_OUTPUTS = {name: field.unit for name, field in declared_fields(MachineOutputs).items()}


class NoNominal(NamedTuple):
    """A machine of which nothing is known."""


@role(Plant)
class ForeignMachine(NamedTuple):
    """What an FMU answers to the command [V], at each communication.

    It is the whole machine, from the command to what is measured: the loop's sensors measure what it answers,
    and it stands in the place of valve, drive and supply too. ``nominal`` is the cylinder that laws take it
    for, with the scenario's valve and supply. Between communications the command is held, as it is at a rig.

    Its state is what it answered last; nan of what it does not answer.

    Source: FMI 2.0.5 and 3.0.2, co-simulation.
    Fails to say what oil and power the machine draws: metrics of these are nan.
    """

    step: Annotated[float, STEP] = OPEN
    nominal: Plant = NoNominal()  # type: ignore[assignment]

    @property
    def stroke(self) -> float:
        return getattr(self.nominal, "stroke", math.inf)

    def init(self) -> MachineOutputs:
        known = {wire.signal for wire in self.foreign.outputs}  # type: ignore[attr-defined]
        return MachineOutputs(*(0.0 if name in known else math.nan for name in MACHINE_OUTPUTS))

    def flows(self, s: MachineOutputs, ports: Block) -> PortFlows:
        return PortFlows(math.nan, math.nan, math.nan, math.nan)

    def deriv(self, s: MachineOutputs, flows: PortFlows, force: float) -> MachineOutputs:
        return MachineOutputs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def hydraulic_force(self, s: MachineOutputs) -> float:
        return s.hydraulic_force

    def outputs(self, s: MachineOutputs, line: Pressures, force: float) -> MachineOutputs:
        return s

    def simplified(self) -> Any:
        """What laws take it for.

        Raises:
            ParameterError: nothing says that.
        """
        if not hasattr(self.nominal, "simplified"):
            problem = "must be a cylinder that the law can take the FMU for, such as [plant.nominal]"
            raise ParameterError("plant.nominal", type(self.nominal).__name__, problem)
        return self.nominal.simplified()


class NoSupplyState(NamedTuple):
    """It remembers nothing."""


@role(Supply)
class NoSupply(NamedTuple):
    """No supply, for a loop whose machine has its own inside.

    Source: a definition.
    Fails with any other machine, which gets no oil.
    """

    def init(self) -> NoSupplyState:
        return NoSupplyState()

    def deriv(self, s: NoSupplyState, drawn: float) -> NoSupplyState:
        return s

    def pressures(self, s: NoSupplyState) -> Pressures:
        return Pressures(0.0, 0.0)

    def simplified(self) -> Block:
        """What laws take it for.

        Raises:
            ParameterError: nothing says that.
        """
        raise ParameterError("supply", "NoSupply", "must be given for the controller's model of the machine")


class ThroughFmuState(NamedTuple):
    """It remembers nothing."""


@valveless
@role(Drive)
class ThroughFmu(NamedTuple):
    """No drive, for a loop whose machine has its own inside; what it draws is not known, and nan.

    Source: a definition.
    Fails with any other machine, which gets no oil.
    """

    def init(self) -> ThroughFmuState:
        return ThroughFmuState()

    def deriv(self, s: ThroughFmuState, feed: Feed, pressure_a: float, pressure_b: float) -> ThroughFmuState:
        return s

    def flows(self, s: ThroughFmuState, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows:
        return PortFlows(math.nan, math.nan, math.nan, math.nan)

    def power(
        self, s: ThroughFmuState, feed: Feed, flows: PortFlows, pressure_a: float, pressure_b: float
    ) -> float:
        return math.nan
