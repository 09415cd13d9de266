"""An FMU as the machine of a loop: cylinder, valve, supply, sensors and what it moves in one."""

import math
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Annotated, Any, NamedTuple

from hydroservo.core.block import Block, Field, declared_fields
from hydroservo.core.errors import LoopError, ParameterError
from hydroservo.core.field import OPEN
from hydroservo.core.roles import Drive, Load, Plant, Supply, role, valveless
from hydroservo.core.signals import Feed, MachineOutputs, PortFlows, Pressures
from hydroservo.core.sources import CHOSEN
from hydroservo.cosimulation.fmu import Foreign
from hydroservo.cosimulation.instance import Instance

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


LOAD, MACHINE = "load", "plant"
ROUNDED = 1e-9  # relative, by which a whole number of steps may miss a period


def fmus_in(loop: Block) -> dict[str, Foreign]:
    """The FMUs in a loop, by the field that holds them."""
    parts = ((LOAD, ForeignLoad), (MACHINE, ForeignMachine))
    return {name: getattr(loop, name).foreign for name, cls in parts if isinstance(getattr(loop, name), cls)}


def has_fmu(loop: Block) -> bool:
    """Whether a loop has an FMU in it, so that it can only run in plain Python."""
    return bool(fmus_in(loop))


def refuse_fmus(loop: Block, what: str) -> None:
    for name, foreign in fmus_in(loop).items():
        raise LoopError(
            f"the {name} is the FMU {foreign.name}, of which only steps are known, so nothing can {what}; "
            "runs and batches can have it"
        )


def first_force(loop: Any, state: Any) -> float:
    """What the FMU of a load answers at t = 0 [N]."""
    signals = seen_by_load(state)
    with Instance(loop.load.foreign, LOAD, signals) as load:
        return load.exchange(signals)["force"]


def seen_by_load(state: Any) -> dict[str, float]:
    return {"position": state.position, "velocity": state.velocity}


class PeriodProgress(NamedTuple):
    """How far a sample period is."""

    done: int  # communications
    gone: float  # [s]
    substeps: int  # of the integrator in all of the period


class Communications:
    """An integrator whose steps end at communications, ``parts`` of equal length in a sample period."""

    def __init__(self, inner: Any, parts: int) -> None:
        self.inner, self.parts = inner, parts

    def begin(self, t: float, dt: float, substeps: int) -> PeriodProgress:
        return PeriodProgress(0, 0.0, substeps)

    def attempt(self, system: "Coupled", t: float, x: Any, u: Any, dt: float, p: PeriodProgress) -> Any:
        """The state at the next communication; every attempt is a step."""
        h = dt / self.parts
        now = t + p.done * h
        if p.done > 0:  # the first comes with the sample
            system.exchange(now, x)
        x = system.carried(self.inner, now, x, u, h, -(-p.substeps // self.parts))
        done = p.done + 1
        return x, PeriodProgress(done, dt if done == self.parts else done * h, p.substeps)

    def advance(self, system: "Coupled", t: float, x: Any, u: Any, dt: float, substeps: int) -> Any:
        p = self.begin(t, dt, substeps)
        while p.gone < dt:
            x, p = self.attempt(system, t, x, u, dt, p)
        return x


class Coupled:
    """A loop and the instances of its FMUs; what it is asked for besides is the loop's."""

    def __init__(self, loop: Any, instances: dict[str, Instance]) -> None:
        self._loop = loop
        self._load, self._machine = instances.get(LOAD), instances.get(MACHINE)
        self._last = -1.0  # when the load communicated, none yet

    def __getattr__(self, name: str) -> Any:
        return getattr(self._loop, name)

    def sample(self, s: Any, t: float, dt: float) -> Any:
        if self._machine is not None and t == 0.0:
            s = s._replace(plant=with_outputs(self._machine.outputs(), s.plant))
        self.exchange(t, s)
        return self._loop.sample(s, t, dt)

    def exchange(self, t: float, x: Any) -> None:
        """Bring the load's FMU to an instant, and hold what it answers to the rod's motion there."""
        if self._load is None:
            return
        if self._last >= 0.0:
            self._load.step(self._last, t - self._last)
        self._last = t
        force = self._load.exchange(seen_by_load(x.plant))["force"]
        self._loop = self._loop._replace(load=self._loop.load._replace(held=force))

    def carried(self, inner: Any, t: float, x: Any, u: Any, h: float, substeps: int) -> Any:
        """The machine's state a communication step later."""
        if self._machine is None:
            return inner.advance(self, t, x, u, h, substeps)
        self._machine.give({"command": self._loop.hold.at(u, t), "external_force": self._loop.load.force(t)})
        self._machine.step(t, h)
        return x._replace(plant=with_outputs(self._machine.outputs(), x.plant))


def with_outputs(outputs: dict[str, float], before: Any) -> Any:
    """The state of a machine that an FMU answers."""
    return before._replace(**{name: outputs[name] for name in MACHINE_OUTPUTS if name in outputs})


@contextmanager
def couple_fmus(study: Any) -> Iterator[Any]:
    """A study whose system has FMUs in it with their instances, which go at the end; any other as it is."""
    loop = study.system
    found = fmus_in(loop)
    if not found:
        yield study
        return
    period = loop.simulation.period
    parts = communications_per_period(loop, found, period)
    if MACHINE in found:
        check_machine(loop, found[MACHINE], period / parts)
    first = {LOAD: seen_by_load(loop.init().plant), MACHINE: {"command": 0.0, "external_force": 0.0}}
    with ExitStack() as stack:
        instances = {
            name: stack.enter_context(Instance(foreign, name, first[name])) for name, foreign in found.items()
        }
        system = Coupled(loop, instances)
        yield study._replace(system=system, integrator=Communications(study.integrator, parts))


def communications_per_period(loop: Any, found: dict[str, Foreign], period: float) -> int:
    """How many communications there are in a sample period."""
    steps = {name: getattr(loop, name).step for name in found}
    parts = {name: 1 if step == OPEN else round(period / step) for name, step in steps.items()}
    for name, step in steps.items():
        if step != OPEN and abs(parts[name] * step - period) > ROUNDED * period:
            raise ParameterError(f"{name}.step", step, f"must divide the sample period of {period:g} s")
    if len(set(parts.values())) > 1:
        raise ParameterError("load.step", steps[LOAD], "must be that of the plant's FMU")
    return next(iter(parts.values()))


def check_machine(loop: Any, foreign: Foreign, step: float) -> None:
    """Refuse what cannot go around a machine that is an FMU."""
    delay = getattr(loop.hold, "delay", 0.0)
    if abs(delay - round(delay / step) * step) > ROUNDED * step:
        raise ParameterError("hold.delay", delay, f"must be whole communication steps of {step:g} s")
    if MACHINE in loop.start.given._fields:
        raise ParameterError("start.given.plant", foreign.name, "is an FMU, which starts where itself says")
    takes = {wire.signal for wire in foreign.inputs}
    if "external_force" not in takes and tuple(loop.load) != (0.0,):
        load = type(loop.load).__name__
        raise LoopError(
            f"the plant's FMU {foreign.name} takes no force of the load {load}: name its input in "
            'plant.signals.external_force, or give load.type = "Constant"'
        )
