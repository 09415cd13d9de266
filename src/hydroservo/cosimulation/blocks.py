"""An FMU as the machine of a loop: cylinder, valve, supply, sensors and what it moves in one."""

import math
from typing import Annotated, Any, NamedTuple

from hydroservo.core.block import Block, Field, declared_fields
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import OPEN
from hydroservo.core.roles import Drive, Load, Plant, Supply, role, valveless
from hydroservo.core.signals import Feed, MachineOutputs, PortFlows, Pressures
from hydroservo.core.sources import CHOSEN

MACHINE_INPUTS = {"command": "V", "external_force": "N"}
MACHINE_OUTPUTS = {name: field.unit for name, field in declared_fields(MachineOutputs).items()}
STEP = Field("s", "communication step; automatic: the sample period", CHOSEN, above=0, auto=OPEN)
LOAD_INPUTS = {"position": "m", "velocity": "m/s"}
LOAD_OUTPUTS = {"force": "N"}


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
        """What laws take it for."""
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
        """What laws take it for."""
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


@role(Load)
class ForeignLoad(NamedTuple):
    """F_L = what an FMU answers to the rod's position and velocity, positive against motion.

    At each communication t_i it is given both, and answers F(t_i); that is held until t_(i+1), while the FMU
    steps there with its inputs held. Of a smooth force the hold is h/2 late on average, h the step, so that
    errors of the run are of the first order in h.

    Source: Kuebler and Schiehlen, Mathematical and Computer Modelling of Dynamical Systems 6(2), 2000
    (parallel exchange of held values).
    Fails with an FMU stiff enough to swing against the machine at that delay: a spring k gains k v^2 h/2 of
    power as a damper of -k h/2 would. One that answers its inputs only after a step is one step later still.
    """

    step: Annotated[float, STEP] = OPEN
    held: Annotated[float, Field("N", "force held until the next communication", "the FMU", derived=True)] = (
        0.0
    )

    def force(self, t: float) -> float:
        return self.held

    def next_jump(self, t: float) -> float:
        return math.inf
