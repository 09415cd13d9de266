"""What can be exported, each as a block: a controller, a machine, its equations, a demand, the whole loop."""

import math
from types import FunctionType
from typing import Annotated, Any, NamedTuple

from hydroservo.control.loop import AUTO, External, Loop, MachineState
from hydroservo.control.monitors.group import Usual
from hydroservo.core import ops
from hydroservo.core.block import Block, Field, values
from hydroservo.core.command_scale import is_volts
from hydroservo.core.roles import Controller, Reference
from hydroservo.core.signals import Demand, MachineOutputs, Measurement
from hydroservo.core.sources import CHOSEN
from hydroservo.engine import state_text
from hydroservo.export.converted import PER_VOLT, ConvertedController, ConvertedHold
from hydroservo.export.unit import Part
from hydroservo.language.terms import Record
from hydroservo.machine.integrators.jumps import BEFORE
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import simulate
from hydroservo.runs.step_sizes import with_substeps

PERIOD = Field("s", "sample period", CHOSEN, above=0)


class ControllerUnit(NamedTuple):
    """A controller and the sample period that it was designed for.

    A sample whose command is not a number, or that leaves an infinite number in the controller's state, is
    answered with the first state: its command goes out, 0 V for all laws here, and the controller begins anew
    at the next sample. As long as that does not happen this is the controller alone.

    Source: chosen here: a valve at 0 V is closed, and a law that begins anew is known to work.
    Fails to notice what is wrong and yet finite: a law believes any number.
    """

    controller: Controller
    period: Annotated[float, PERIOD]

    def init(self) -> Block:
        """The state before the first sample."""
        return self.controller.init()

    def step(self, state: Block, measurement: Measurement, demand: Demand) -> Block:
        """One sample; what goes out is the new state's u."""
        after = self.controller.step(state, measurement, demand, self.period)
        lost = ops.isnan(after.u) or infinite(after)
        return ops.where(lost, self.controller.init(), after)


def infinite(state: Block) -> bool:
    """True if any number of a state is infinite; nan may mean there that nothing is known yet."""
    return any(abs(value) == math.inf for value in values(state))


def infinite_text(shape: Record, test: str = "absolute({}) == inf", **names: Any) -> FunctionType:
    """``infinite`` for states of one type, by a test of each number."""
    tests = " or ".join(test.format(f"state.{place}") for place in state_text.places(shape))
    return state_text.defined(infinite, "state", tests, {"absolute": ops.absolute, "inf": math.inf, **names})


class Command(NamedTuple):
    """What a machine is given at a sample and holds until the next, or its equations at an instant."""

    u: Annotated[float, Field("V", "command")]


class ExternalForce(NamedTuple):
    """What mechanics that are modelled elsewhere do to the rod."""

    force: Annotated[float, Field("N", "force on the rod besides that of the load, positive against motion")]


class Driven(NamedTuple):
    """What acts on a machine from one sample to the next: the command, as it is held, and a force [N]."""

    held: Any
    force: float


class MachineUnitState(NamedTuple):
    """A machine at a sample, and what its sensors have measured there."""

    plant: Block
    valve: Block
    supply: Block
    drive: Block
    sensors: Block
    hold: Block
    measurement: Measurement
    load: External
    command: Annotated[float, Field("V", "command given at the sample before")]
    sample: Annotated[float, Field("", "number of samples since the start")]


class MachineUnit(NamedTuple):
    """A machine (plant, valve, supply, load, hold) and its sensors, from one sample to the next.

    At a sample the controller runs first, on the measurement; the machine then goes on to the next sample
    under its command and an external force, both held, and is measured there.
    """

    loop: Loop
    period: Annotated[float, PERIOD]

    def init(self) -> MachineUnitState:
        """At the start, measured."""
        m = self.loop
        machine = m.machine(m.init())
        return self.measured(machine, m.sensors.init(), m.hold.init(), Driven(0.0, 0.0), 0.0)

    def step(self, state: MachineUnitState, command: Command, external: ExternalForce) -> MachineUnitState:
        """From a sample to the next one."""
        m = self.loop
        t = state.sample * self.period
        hold = m.hold.step(state.hold, state.command, t)
        machine = MachineState(state.plant, state.valve, state.supply, state.drive)
        driven = Driven(m.hold.held(hold, command.u), external.force)
        integrator, substeps = m.simulation.integrator, m.simulation.substeps
        x = integrator.advance(self, t, machine, driven, self.period, substeps)
        done = Driven(command.u, external.force)
        return self.measured(x, state.sensors, hold, done, state.sample + 1.0)

    def deriv(self, t: float, x: MachineState, driven: Driven) -> MachineState:
        """Rates of the machine, for its integrator."""
        m = self.loop
        return m.rates(x, m.hold.at(driven.held, t), m.load.force(t) + driven.force)

    def next_jump(self, t: float, driven: Driven) -> float:
        """The first instant after ``t`` at which what drives the machine jumps [s]."""
        return self.loop.next_jump(t, driven.held)

    def measured(
        self, x: MachineState, sensors: Block, hold: Block, driven: Driven, sample: float
    ) -> MachineUnitState:
        """A machine's state with what the sensors make of it."""
        m = self.loop
        t = sample * self.period
        force = m.load.force(t)
        seen = m.seen(x, force + driven.force)
        read = m.sensors.step(sensors, seen, m.draws(t, self.period), self.period)
        y = m.sensors.measure(read, seen, m.hold.applied(hold, driven.held, self.period))
        return MachineUnitState(
            x.plant, x.valve, x.supply, x.drive, read, hold, y, External(force), driven.held, sample
        )


class Instant(NamedTuple):
    """When equations are asked for."""

    t: Annotated[float, Field("s", "time since the start")]
    until: Annotated[
        float, Field("s", "next jump of the load, of which nothing is to be seen yet; inf at a jump itself")
    ]


class EquationsUnitState(NamedTuple):
    """What a machine does at an instant."""

    start: MachineState
    rates: MachineState
    outputs: MachineOutputs
    load: External
    jump: Annotated[float, Field("s", "the first instant after this one at which the load jumps, or inf")]


class EquationsUnit(NamedTuple):
    """The differential equations of a machine (plant, valve, supply, load), for an integrator from elsewhere.

    An integrator goes no further than the next jump, and asks up to there with ``until`` = that jump, so that
    its last stage does not see what is beyond; then once with inf at the jump itself, which gives the next.
    The command is that at the valve: a hold that delays it, and sensors, belong to whoever samples.

    Source: FMI 2.0.4, sec. 3.1, has the same order of things.
    Fails to say where friction or the ends of the stroke change their law: their rates are continuous, but
    an integrator with error control takes small steps there.
    """

    loop: Loop

    def init(self) -> EquationsUnitState:
        """At the start, without a command."""
        m = self.loop
        start = m.machine(m.init())
        return self.at(start, Instant(0.0, math.inf), start, Command(0.0), ExternalForce(0.0))

    def step(
        self,
        state: EquationsUnitState,
        instant: Instant,
        machine: MachineState,
        command: Command,
        external: ExternalForce,
    ) -> EquationsUnitState:
        """At any instant, in any state; what was asked before does not matter."""
        return self.at(state.start, instant, machine, command, external)

    def at(
        self,
        start: MachineState,
        instant: Instant,
        x: MachineState,
        command: Command,
        external: ExternalForce,
    ) -> EquationsUnitState:
        """The rates and what else can be seen."""
        m = self.loop
        t = ops.minimum(instant.t, BEFORE * instant.until)
        force = m.load.force(t)
        return EquationsUnitState(
            start=start,
            rates=m.rates(x, command.u, force + external.force),
            outputs=m.seen(x, force + external.force),
            load=External(force),
            jump=m.load.next_jump(t),
        )


class ConvertedEquationsUnit(NamedTuple):
    """The equations of a machine whose command comes in another unit than its volts: u_valve = u/k."""

    loop: Loop
    per_volt: Annotated[float, PER_VOLT]

    def init(self) -> EquationsUnitState:
        """At the start, without a command."""
        return EquationsUnit(self.loop).init()

    def step(
        self,
        state: EquationsUnitState,
        instant: Instant,
        machine: MachineState,
        command: Command,
        external: ExternalForce,
    ) -> EquationsUnitState:
        """At any instant, in any state; what was asked before does not matter."""
        volts = Command(command.u / self.per_volt)
        return EquationsUnit(self.loop).step(state, instant, machine, volts, external)


class DemandUnitState(NamedTuple):
    """A demand at a sample."""

    demand: Demand
    sample: Annotated[float, Field("", "number of samples since the start")]


class DemandUnit(NamedTuple):
    """A demand, from one sample to the next."""

    reference: Reference
    period: Annotated[float, PERIOD]

    def init(self) -> DemandUnitState:
        """At the start."""
        return DemandUnitState(self.reference.at(0.0), 0.0)

    def step(self, state: DemandUnitState) -> DemandUnitState:
        """From a sample to the next one."""
        sample = state.sample + 1.0
        return DemandUnitState(self.reference.at(sample * self.period), sample)


class LoopUnitState(NamedTuple):
    """A loop at a sample, whose controller has just run."""

    loop: Block
    sample: Annotated[float, Field("", "number of samples since the start")]


class LoopUnit(NamedTuple):
    """A whole loop, from one sample to the next."""

    loop: Loop
    period: Annotated[float, PERIOD]

    def init(self) -> LoopUnitState:
        """The first sample."""
        return LoopUnitState(self.loop.sample(self.loop.init(), 0.0, self.period), 0.0)

    def step(self, state: LoopUnitState) -> LoopUnitState:
        """The machine goes on to the next sample, and the controller runs there."""
        m, s = self.loop, state.loop
        integrator, substeps = m.simulation.integrator, m.simulation.substeps
        t = state.sample * self.period
        x = integrator.advance(m, t, m.machine(s), m.held(s), self.period, substeps)
        sample = state.sample + 1.0
        return LoopUnitState(m.sample(m.with_machine(s, x), sample * self.period, self.period), sample)


def with_its_substeps(loop: Loop) -> Loop:
    """The loop with automatic substeps turned into the number that a run finds."""
    if loop.simulation.substeps != AUTO:
        return loop
    substeps = int(quietly(simulate)(loop, record=(), metrics=()).attrs["substeps"])
    return with_substeps(loop, substeps)


def block_of(loop: Loop, part: Part) -> Block:
    """The block that is stepped, without metrics; the seed becomes a number that can be changed.

    A controller and a machine have the command between them in the scenario's unit; a whole loop has volts.
    """
    loop, per_volt = loop._replace(metrics=Usual()), float(loop.command.per_volt)
    if not is_volts(loop.command) and part is Part.EQUATIONS:
        return ConvertedEquationsUnit(loop, per_volt)
    if not is_volts(loop.command) and part is not Part.LOOP:
        law, hold = ConvertedController(loop.controller, per_volt), ConvertedHold(loop.hold, per_volt)
        loop = loop._replace(controller=law, hold=hold)
    period = loop.simulation.period
    if part is Part.CONTROLLER:
        return ControllerUnit(loop.controller, period)
    if part is Part.DEMAND:
        return DemandUnit(loop.reference, period)
    if part is Part.EQUATIONS:
        return EquationsUnit(loop)
    seed = float(loop.simulation.seed)
    seeded = loop._replace(simulation=loop.simulation._replace(seed=seed))  # type: ignore[arg-type]
    return MachineUnit(seeded, period) if part is Part.MACHINE else LoopUnit(seeded, period)
