"""Wires blocks into a closed loop: a sampled controller around a continuous machine."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Block, Controller, Field, Integrator, Load, Reference, Sensors, Valve
from hydroservo.controllers.pi import PI
from hydroservo.integrators.rk4 import RK4
from hydroservo.loads.sine import Sine as SineLoad
from hydroservo.plants.design_model import DesignModel
from hydroservo.plants.load_pressure import LoadPressurePlant
from hydroservo.references.sine import Sine as SineReference
from hydroservo.sensors.ideal import IdealSensors
from hydroservo.signals import Demand, Draws
from hydroservo.sources import CHOSEN
from hydroservo.supplies.ideal import IdealSupply
from hydroservo.valves.static import StaticValve

__all__ = ["AUTO", "Loop", "LoopState", "MachineState", "Simulation"]

AUTO = -1  # for Simulation.substeps: as many as the machine needs; "auto" in a scenario


class Simulation(NamedTuple):
    """How long, how often, how finely.

    The controller runs every ``period`` with its command held; between samples the integrator follows the
    machine. RK4 takes ``substeps`` equal steps, which end on the samples; ``AUTO`` ("auto" in a scenario)
    takes so many that twice as many change no recorded state of the machine by more than ``tolerance``.
    """

    duration: Annotated[float, Field("s", "simulated time", CHOSEN, above=0)] = 8.0
    period: Annotated[float, Field("s", "sample period of the controller", CHOSEN, above=0)] = 1e-5
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


class Lumped(NamedTuple):
    """What the machine does besides its nominal model."""

    d1: Annotated[float, Field("m/s^2", "lumped disturbance d_L1")]
    d2: Annotated[float, Field("N/s", "lumped disturbance d_L2")]


class External(NamedTuple):
    """What acts on the rod from outside."""

    force: Annotated[float, Field("N", "external force F_L")]


class LoopState(NamedTuple):
    """Everything at one instant; each number in it can be recorded by its path."""

    plant: Block
    valve: Block
    sensors: Block
    controller: Block
    reference: Block
    load: External
    disturbance: Lumped


class Loop(NamedTuple):
    """A machine, its controller and how to simulate them.

    ``nominal`` is the model against which the lumped disturbances are defined; a scenario takes
    the controller's own model where it has one, else the machine before its uncertainty.
    """

    simulation: Simulation = Simulation()
    plant: LoadPressurePlant = LoadPressurePlant()
    valve: Valve = StaticValve()
    supply: IdealSupply = IdealSupply()
    load: Load = SineLoad()
    sensors: Sensors = IdealSensors()
    reference: Reference = SineReference()
    controller: Controller = PI()
    nominal: DesignModel = DesignModel()

    def init(self) -> LoopState:
        return LoopState(
            self.plant.init(),
            self.valve.init(),
            self.sensors.init(),
            self.controller.init(),
            Demand(0.0, 0.0, 0.0),
            External(0.0),
            Lumped(0.0, 0.0),
        )

    def sample(self, s: LoopState, t: float, dt: float) -> LoopState:
        """What happens at a sampling instant: measure, run the controller, hold its command."""
        r = self.reference.at(t)
        sensors = self.sensors.step(s.sensors, s.plant, self.draws(t, dt), dt)
        y = self.sensors.measure(sensors, s.plant, s.controller.u)
        controller = self.controller.step(s.controller, y, r, dt)
        disturbance = self.lumped(t, MachineState(s.plant, s.valve), controller.u)
        load = External(self.load.force(t))
        return LoopState(s.plant, s.valve, sensors, controller, r, load, disturbance)

    def draws(self, t: float, dt: float) -> Draws:
        """Where the sensors draw their random numbers."""
        return Draws(float(self.simulation.seed), 0.0, ops.nearest(t / dt))

    def lumped(self, t: float, x: MachineState, u: float) -> Lumped:
        """d_L1 and d_L2 of eq. (6): the machine's true rates less those of the nominal model."""
        m = self.nominal
        x1, x2 = x.plant.velocity, x.plant.load_force
        rate = self.deriv(t, x, u).plant
        return Lumped(
            rate.velocity - (m.f1(x1) + m.g1() * x2), rate.load_force - (m.f2(x1, x2) + m.g2(x2, u) * u)
        )

    def deriv(self, t: float, x: MachineState, u: float) -> MachineState:
        """Rates of the machine under a held command."""
        opening = self.valve.opening(x.valve, u)
        flow = self.valve.flow(opening, self.supply.drop(), self.plant.load_pressure(x.plant))
        return MachineState(self.plant.deriv(x.plant, flow, self.load.force(t)), self.valve.deriv(x.valve, u))

    def next_jump(self, t: float) -> float:
        """The first instant after ``t`` at which what drives the machine between samples jumps [s]."""
        return self.load.next_jump(t)

    def machine(self, s: LoopState) -> MachineState:
        """The part of the state that is integrated."""
        return MachineState(s.plant, s.valve)

    def command(self, s: LoopState) -> float:
        """The held command [V]."""
        u: float = s.controller.u
        return u

    def finite(self, x: MachineState) -> bool:
        """False once the velocity or the load force is no longer a finite number."""
        return ops.isfinite(x.plant.velocity) and ops.isfinite(x.plant.load_force)

    def moved(self, s: LoopState, x: MachineState) -> LoopState:
        """The state with its machine part exchanged."""
        return LoopState(x.plant, x.valve, s.sensors, s.controller, s.reference, s.load, s.disturbance)
