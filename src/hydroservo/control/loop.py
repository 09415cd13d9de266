"""Wires blocks into a closed loop: a sampled controller around a continuous machine."""

from typing import Annotated, Any, NamedTuple

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.holds.zero_order import ZeroOrderHold
from hydroservo.control.monitors.group import Usual
from hydroservo.control.outline import outline, outline_table
from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.command_scale import CommandScale
from hydroservo.core.roles import (
    ControlledSignal,
    Controller,
    Drive,
    Hold,
    Integrator,
    Load,
    Plant,
    Reference,
    Sensors,
    Start,
    Supply,
    Valve,
)
from hydroservo.core.signals import Demand, Draws, Feed, MachineOutputs
from hydroservo.core.sources import CHOSEN
from hydroservo.machine.drives.ports import Ports
from hydroservo.machine.drives.valve_on_supply import ValveOnSupply
from hydroservo.machine.integrators.rk4 import RK4
from hydroservo.machine.loads.constant import Constant
from hydroservo.machine.sensors.ideal import IdealSensors
from hydroservo.machine.starts.as_built import AsBuilt

AUTO = -1  # for Simulation.substeps: as many as the machine needs; "auto" in a scenario


class Simulation(NamedTuple):
    """How long, how often, how finely.

    The controller runs every ``period`` with its command held; between samples the integrator follows the
    machine. RK4 takes ``substeps`` equal steps, which end on the samples; ``AUTO`` ("auto" in a scenario)
    takes so many that twice as many change no recorded state of the machine by more than ``tolerance``.
    """

    duration: Annotated[float, Field("s", "simulated time", CHOSEN, above=0)] = 8.0
    period: Annotated[float, Field("s", "sample period of the controller", CHOSEN, at_least=1e-12)] = 1e-5
    substeps: Annotated[
        int, Field("", "integration steps per sample period", CHOSEN, at_least=1, at_most=1e6, auto=AUTO)
    ] = 1
    record_period: Annotated[
        float, Field("s", "time between recorded samples; at least one sample period", CHOSEN, above=0)
    ] = 1e-3
    seed: Annotated[int, Field("", "seed of all random numbers", CHOSEN, at_least=0, below=2**53)] = 0
    integrator: Integrator = RK4()
    tolerance: Annotated[
        float,
        Field(
            "",
            "of automatic substeps, relative to each state's largest value",
            CHOSEN,
            at_least=1e-12,
            below=1,
        ),
    ] = 1e-6


class MachineState(NamedTuple):
    """What is integrated."""

    plant: Block
    valve: Block
    supply: Block
    drive: Block


class External(NamedTuple):
    """What acts on the rod from outside."""

    force: Annotated[float, Field("N", "external force F_L")]


class Controlled(NamedTuple):
    """The signal that is controlled."""

    value: Annotated[float, Field("y", "{y}")]


class LoopState(NamedTuple):
    """Everything at one instant; each number in it can be recorded by its path."""

    plant: Block
    valve: Block
    supply: Block
    drive: Block
    sensors: Block
    controller: Block
    hold: Block
    reference: Block
    controlled: Controlled
    load: External


class Loop(NamedTuple):
    """A machine, its controller and how to simulate them.

    ``controls`` is the signal that the demand is of, and every verdict; ``drive`` what lies between the valve
    and the cylinder, or stands in the valve's place. ``metrics`` are the monitors that judge a run: those of
    :func:`~hydroservo.control.metrics.usual` where it is left as it is. ``command`` says in what a person
    reads and writes commands, which are volts for all blocks. What a law believes of the machine and what
    sensors know of it is filled from the machine before a run where it is left open, as
    :func:`~hydroservo.control.wiring.wired` does.
    """

    simulation: Simulation
    plant: Plant
    valve: Valve
    supply: Supply
    reference: Reference
    controller: Controller
    controls: ControlledSignal = Velocity()
    drive: Drive = ValveOnSupply()
    load: Load = Constant()
    sensors: Sensors = IdealSensors()
    hold: Hold = ZeroOrderHold()
    start: Start = AsBuilt()
    metrics: Block = Usual()
    command: CommandScale = CommandScale()

    def __repr__(self) -> str:
        return outline(self)

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        return outline_table(self)

    def init(self) -> LoopState:
        begun: LoopState = self.start.of(self.blocks_begin())
        return begun

    def blocks_begin(self) -> LoopState:
        """The first state of each block, whatever the start says."""
        return LoopState(
            self.plant.init(),
            self.valve.init(),
            self.supply.init(),
            self.drive.init(),
            self.sensors.init(),
            self.controller.init(),
            self.hold.init(),
            Demand(0.0, 0.0, 0.0),
            Controlled(0.0),
            External(0.0),
        )

    def sample(self, s: LoopState, t: float, dt: float) -> LoopState:
        """What happens at a sampling instant: measure, run the controller, hold its command."""
        r, force = self.reference.at(t), self.load.force(t)
        seen = self.seen(s, force)
        sensors = self.sensors.step(s.sensors, seen, self.draws(t, dt), dt)
        y = self.sensors.measure(sensors, seen, self.hold.applied(s.hold, s.controller.u, dt))
        hold = self.hold.step(s.hold, s.controller.u, t)
        controller = self.controller.step(s.controller, y, r, dt)
        controlled = Controlled(self.controls.of(seen, controller.u))
        return LoopState(
            s.plant, s.valve, s.supply, s.drive, sensors, controller, hold, r, controlled, External(force)
        )

    def draws(self, t: float, dt: float) -> Draws:
        """Where the sensors draw their random numbers."""
        return Draws(float(self.simulation.seed), 0.0, ops.nearest(t / dt))

    def deriv(self, t: float, x: MachineState, held: Any) -> MachineState:
        """Rates of the machine under a held command."""
        return self.rates(x, self.hold.at(held, t), self.load.force(t))

    def rates(self, x: MachineState, u: float, force: float) -> MachineState:
        """Rates of the machine under a command at the valve [V] and a force on the rod [N]."""
        ports = self.ports(x, u)
        flows = self.plant.flows(x.plant, ports)
        seen = self.seen(x, force)
        return MachineState(
            self.plant.deriv(x.plant, flows, force),
            self.valve.deriv(x.valve, u),
            self.supply.deriv(x.supply, flows.supply),
            self.drive.deriv(x.drive, ports.feed, seen.pressure_a, seen.pressure_b),
        )

    def seen(self, x: MachineState | LoopState, force: float) -> MachineOutputs:
        """What can be seen of the machine under a force on the rod [N]."""
        return self.plant.outputs(x.plant, self.supply.pressures(x.supply), force)

    def ports(self, x: MachineState, u: float) -> Ports:
        """The cylinder's ports as the drive holds them under a command [V]."""
        line = self.supply.pressures(x.supply)
        feed = Feed(u, self.valve.orifice, self.valve.opening(x.valve, u), line)
        return Ports(self.drive, x.drive, feed)

    def next_jump(self, t: float, held: Any) -> float:
        """The first instant after ``t`` at which what drives the machine between samples jumps [s]."""
        return ops.minimum(self.load.next_jump(t), self.hold.next_jump(held, t))

    def machine(self, s: LoopState) -> MachineState:
        """The part of the state that is integrated."""
        return MachineState(s.plant, s.valve, s.supply, s.drive)

    def held(self, s: LoopState) -> Any:
        """What is held of the command until the next sample."""
        return self.hold.held(s.hold, s.controller.u)

    def with_machine(self, s: LoopState, x: MachineState) -> LoopState:
        """The state with its machine part exchanged."""
        return LoopState(*x, s.sensors, s.controller, s.hold, s.reference, s.controlled, s.load)

    def between(self, s: LoopState, x: MachineState, t: float) -> LoopState:
        """The state between samples, with its machine part as it is then, and what changes with it."""
        force = self.load.force(t)
        controlled = Controlled(self.controls.of(self.seen(x, force), s.controller.u))
        r = self.reference.at(t)
        return LoopState(*x, s.sensors, s.controller, s.hold, r, controlled, External(force))
