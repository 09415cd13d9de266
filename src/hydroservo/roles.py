"""The roles that a block can play: what each must be able to do.

A block says its role above its class::

    @role(Controller)
    class Proportional(NamedTuple): ...

A role is a Protocol: the methods that its blocks have, with as many arguments. What a block may have besides
is in :mod:`hydroservo.hooks`.
"""

from collections.abc import Callable
from typing import Any, Protocol, TypeVar

from hydroservo.errors import LoopError
from hydroservo.field import Field
from hydroservo.signals import (
    Correction,
    Demand,
    Draws,
    Feed,
    MachineOutputs,
    Measurement,
    PortFlows,
    Pressures,
    ReachingRate,
    Seen,
    VelocityError,
)

__all__ = [
    "Accumulator",
    "Block",
    "Carried",
    "CheckFlow",
    "ControlledSignal",
    "Controller",
    "Differentiator",
    "Drive",
    "EndStops",
    "Filter",
    "ForceSensor",
    "Friction",
    "Hold",
    "Integrator",
    "Limiter",
    "Load",
    "Mechanism",
    "MeteringEdges",
    "Model",
    "Monitor",
    "Observer",
    "Oil",
    "Plant",
    "Poppet",
    "PositionSensor",
    "PressureSensor",
    "Pull",
    "Reaching",
    "Realisation",
    "Reference",
    "Relief",
    "Sensors",
    "Start",
    "Supply",
    "Valve",
    "VelocityEstimator",
    "at_samples",
    "controlling",
    "role",
    "valveless",
    "without_estimates",
]

Block = Any  # a NamedTuple with methods; Python's type system has no name for "some NamedTuple"
BlockClass = TypeVar("BlockClass", bound=type)


def role(*roles: Any) -> Callable[[BlockClass], BlockClass]:
    """Says which role a block plays, as its class's attribute ``role``; several where it plays several.

    A decorator, for type checkers take a line ``role = Controller`` in a NamedTuple for one more field.
    Whether the class has what the role asks for is found out where a file is loaded as a plug-in, and by the
    contract.

    Raises:
        LoopError: it is given no roles, or stands above what is no NamedTuple, or says a role already.
    """
    for one in roles or (None,):
        if not is_role(one):
            given = "nothing" if one is None else getattr(one, "__name__", repr(one))
            raise LoopError(
                f"role is given {given}; it takes roles, in parentheses, such as @role(Controller)"
            )

    def say(cls: BlockClass) -> BlockClass:
        if not hasattr(cls, "_fields"):
            raise LoopError(f"{cls.__name__} is no NamedTuple; write class {cls.__name__}(NamedTuple):")
        if "role" in vars(cls) and "role" not in cls._fields:
            raise LoopError(f"{cls.__name__} says its role twice; several stand in one @role(..., ...)")
        cls.role = roles[0] if len(roles) == 1 else roles  # type: ignore[attr-defined]
        return cls

    return say


def is_role(value: object) -> bool:
    """True for a Protocol of this module."""
    return getattr(value, "_is_protocol", False) and getattr(value, "__module__", "") == __name__


def at_samples(cls: BlockClass) -> BlockClass:
    """Says of a monitor that ``step`` comes at samples alone, after the controller's, with the sample period.

    It stands above the class, beside its role.
    """
    cls.at_samples = True  # type: ignore[attr-defined]
    return cls


def controlling(*signals: type) -> Callable[[BlockClass], BlockClass]:
    """Says of a law which signals it can control, such as ``@controlling(Velocity)``; one that does not, any.

    It stands above the class, beside its role. A loop that controls another is refused.
    """

    def say(cls: BlockClass) -> BlockClass:
        cls.signals = signals  # type: ignore[attr-defined]
        return cls

    return say


def valveless(cls: BlockClass) -> BlockClass:
    """Says of a drive that it stands in the valve's place, so that the loop's valve must be a ``NoValve``.

    It stands above the class, beside its role.
    """
    cls.valveless = True  # type: ignore[attr-defined]
    return cls


def without_estimates(cls: BlockClass) -> BlockClass:
    """Says of an observer's state that its d1 and d2 are no estimates, so that no metric judges them."""
    cls.without_estimates = True  # type: ignore[attr-defined]
    return cls


class Controller(Protocol):
    """A sampled control law: measurement and demand in, a new state with its command ``u`` [V] out.

    What is computed before a run is, by ``designed(model, period)``, which blocks in a law may have too; a
    ``model`` of its own is what it, and what is in it, believes of the machine. A law that wraps another has
    that as its field ``controller``; its own limiter is its field ``saturation``. What it controls is its
    field ``controls``, and one of its ``signals`` if it can control but some; what the law inside controls,
    if another, its field ``inner_controls``.
    """

    def init(self) -> Block: ...
    def step(self, s: Block, y: Measurement, r: Demand, dt: float) -> Block: ...


class Observer(Protocol):
    """A sampled disturbance observer.

    Its state holds the estimates ``d1`` [m/s^2] and ``d2`` [N/s], the surfaces ``s1`` [m/s] and ``s2`` [N],
    and the ``velocity`` [m/s] and ``load_force`` [N] that a law is to take. One whose d1 and d2 are no
    estimates says so, by the decorator ``without_estimates``.
    """

    def init(self) -> Block: ...
    def step(self, s: Block, model: Block, y: Measurement, dt: float) -> Block: ...


class Realisation(Protocol):
    """How a reaching law's sgn is realised in discrete time, for each of the two surfaces."""

    def first(self, s: float, k: float, D: float, eps: float, a: float, dt: float) -> Correction: ...
    def second(self, s: float, k: float, D: float, eps: float, a: float, dt: float) -> Correction: ...


class Pull(Protocol):
    """How a law wants the velocity's error to vanish: e'' = -q.

    Its state holds the two terms of q [m/s^3]: ``damping``, against the error's rate, and ``restoring``,
    against the error or a surface.
    """

    def init(self) -> Block: ...
    def step(self, s: Block, error: VelocityError, dt: float) -> Block: ...


class Reaching(Protocol):
    """How a pull draws two surfaces to 0 in discrete time: the rate k s + eps |s|^a sgn(s), and its slope.

    The slope is the rate's derivative by s [1/s]; the second surface needs none.
    """

    def first(self, s: float, k: float, eps: float, a: float, dt: float) -> ReachingRate: ...
    def second(self, s: float, k: float, eps: float, a: float, dt: float) -> float: ...


class Differentiator(Protocol):
    """The rate of a sampled signal; its state holds the estimate ``rate``."""

    def init(self) -> Block: ...
    def step(self, s: Block, value: float, model_rate: float, dt: float) -> Block: ...


class ControlledSignal(Protocol):
    """What a loop controls, and a law's demand is of.

    ``declared`` is its unit and its name; ``of`` picks it from what is seen of the machine, by sensors or as
    it is, and the command [V]. One that a machine can take within limits has ``reach(plant, line)``.
    """

    def declared(self) -> Field: ...
    def of(self, seen: Seen, command: float) -> float: ...


class Reference(Protocol):
    """What the controlled signal should be as a function of time, with its first two derivatives."""

    def at(self, t: float) -> Demand: ...


class Load(Protocol):
    """An external force on the piston rod [N] as a function of time, positive against motion.

    ``next_jump`` is the first instant after ``t`` at which the force or one of its derivatives jumps, inf if
    there is none; what the force jumps to holds from that instant on. Integrators end their steps there.
    """

    def force(self, t: float) -> float: ...
    def next_jump(self, t: float) -> float: ...


class MeteringEdges(Protocol):
    """What a spool opens.

    ``flow`` is the load flow [m^3/s] to a cylinder described by its load pressure, ``port_flows`` are the
    flows to one with two chambers, ``simplified`` is the Orifice that a design model takes the edges for.
    Edges that overlap have their overlap as a field ``lap`` [m].
    """

    def flow(self, opening: float, supply_drop: float, load_pressure: float) -> float: ...
    def port_flows(
        self, opening: float, line: Pressures, pressure_a: float, pressure_b: float
    ) -> PortFlows: ...
    def simplified(self) -> Block: ...


class Valve(Protocol):
    """A servo valve: a spool driven by the command, and the metering edges that its opening [m] uncovers.

    One whose laws are to have a design model of it has its ``gain`` [m/V] as a field.
    """

    @property
    def orifice(self) -> MeteringEdges: ...

    def init(self) -> Block: ...
    def deriv(self, s: Block, u: float) -> Block: ...
    def opening(self, s: Block, u: float) -> float: ...


class Start(Protocol):
    """Where a run starts: the loop's first state, from that which its blocks start in.

    Numbers of the state that are given are in a group ``given``, as :func:`~hydroservo.group.nested` makes
    it. A start that finds others before a run has ``found(steady)``, which gives them in such a group, or as
    a state of the machine; ``steady(command)`` is the machine's steady state under a command [V]. The loop
    then starts :class:`~hydroservo.starts.AsBuilt` with both.
    """

    @property
    def given(self) -> Block: ...

    def of(self, s: Block) -> Block: ...


class Drive(Protocol):
    """What turns a command and the pressures at the cylinder's two ports [Pa] into the flows through them.

    It is given what the loop's valve and supply hold ready, the :class:`~hydroservo.signals.Feed`. ``power``
    [W] is what the drive draws while it passes these flows: with the oil from the supply's line, and at the
    shaft of a motor of its own; negative where it gives back. One that stands in the valve's place is
    ``valveless``, as the decorator of that name says; one around another has that as its field ``drive``, and
    one whose start may be left open has ``at_rest(line, pressure_a, pressure_b)``. One that a cylinder
    described by its load pressure [Pa] may have, too, has ``load_flow(s, feed, load_pressure)`` [m^3/s].
    """

    def init(self) -> Block: ...
    def deriv(self, s: Block, feed: Feed, pressure_a: float, pressure_b: float) -> Block: ...
    def flows(self, s: Block, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows: ...
    def power(self, s: Block, feed: Feed, flows: PortFlows) -> float: ...


class Supply(Protocol):
    """Where the pressure comes from, when a flow [m^3/s] is drawn at the valve's port P.

    ``simplified`` is the IdealSupply that a design model takes it for.
    """

    def init(self) -> Block: ...
    def deriv(self, s: Block, drawn: float) -> Block: ...
    def pressures(self, s: Block) -> Pressures: ...
    def simplified(self) -> Block: ...


class Accumulator(Protocol):
    """What a supply line stores besides its oil: volume per pressure [m^3/Pa] at a gauge pressure [Pa].

    One that takes in nothing up to some pressure has that as a field ``precharge`` [Pa].
    """

    def compliance(self, pressure: float) -> float: ...


class Oil(Protocol):
    """The compressed oil: its effective bulk modulus [Pa] at a gauge pressure [Pa]."""

    def bulk_modulus(self, pressure: float) -> float: ...


class Friction(Protocol):
    """What resists the piston's motion; positive against a positive velocity.

    ``net`` is the sum of all other forces on the moving parts [N] and ``mass`` their inertia [kg], from which
    a friction that sticks knows what holds them. ``simplified`` is the viscous coefficient [N s/m] that a
    design model takes it for.
    """

    def init(self) -> Block: ...
    def deriv(self, s: Block, velocity: float) -> Block: ...
    def force(self, s: Block, velocity: float, net: float, mass: float) -> float: ...
    def simplified(self) -> float: ...


class EndStops(Protocol):
    """The force of the ends of the stroke on the piston [N], positive where it pushes outwards."""

    def force(self, position: float, velocity: float, stroke: float) -> float: ...


class Mechanism(Protocol):
    """What the rod moves: inertia(x) dv/dt = (sum of the forces on the rod) - resistance(x, v).

    The inertia [kg] may depend on the position; the resistance [N] is that of gravity, springs and a changing
    inertia, positive against a positive velocity. A mechanism that cannot take every position says which it
    can, by ``positions()``; one whose tip can carry something says how that moves, by ``tip(position)``.
    """

    def inertia(self, position: float) -> float: ...
    def resistance(self, position: float, velocity: float) -> float: ...


class Carried(Protocol):
    """What the mechanism carries that has a motion of its own, with what the rod then meets.

    With x the rod's position and q what it carries moves by itself, Lagrange's equations are::

        M_xx dv/dt + M_xq q'' = F - R_x        M_xq dv/dt + M_qq q'' = -R_q

    The rod thus meets inertia [kg] M_xx - M_xq^2/M_qq and resistance [N] R_x - R_q M_xq/M_qq, mechanism and
    all: ``inertia`` and ``resistance``, which a friction that sticks, and a load cell, take like those of a
    mechanism alone. ``deriv`` gives the state's rates under the rod's acceleration [m/s^2]. What goes with
    some mechanisms alone refuses others by ``check_on(mechanism)``.
    """

    def init(self) -> Block: ...
    def inertia(self, s: Block, mechanism: Mechanism, position: float) -> float: ...
    def resistance(self, s: Block, mechanism: Mechanism, position: float, velocity: float) -> float: ...
    def deriv(
        self, s: Block, mechanism: Mechanism, position: float, velocity: float, acceleration: float
    ) -> Block: ...


class Plant(Protocol):
    """A cylinder and what it moves, from the valve's flows and an external force on the rod [N].

    ``flows`` asks the drive's :class:`~hydroservo.drives.ports.Ports` for what the cylinder takes.
    ``load_force`` is that of the oil on the piston, and linear in the state, so that it also gives its rate
    from the state's. States have ``velocity`` [m/s] and ``position`` [m], plants have ``stroke`` [m].
    ``simplified`` is the LoadPressurePlant that a design model takes it for. ``outputs`` is given the
    external force, too, for what a load cell at the rod shows. A plant whose start may be left open has
    ``at_rest(line, force)``. Sensors of pressures take the piston's areas ``area_a`` and ``area_b`` [m^2]
    from it, or ``piston_area`` for both.
    """

    @property
    def stroke(self) -> float: ...

    def init(self) -> Block: ...
    def flows(self, s: Block, ports: Block) -> PortFlows: ...
    def deriv(self, s: Block, flows: PortFlows, force: float) -> Block: ...
    def load_force(self, s: Block) -> float: ...
    def outputs(self, s: Block, line: Pressures, force: float) -> MachineOutputs: ...
    def simplified(self) -> Block: ...


class Hold(Protocol):
    """How a command is held between samples.

    ``step`` comes at a sample, before the controller, with the command that it replaces; ``held`` is what
    integrators carry to the machine, ``at`` its value at an instant and ``next_jump`` the first instant after
    it at which it jumps. ``applied`` is the mean command over the period just ended, and ``steady`` what is
    held of a command that never changes. A hold that comes late has its ``delay`` [s] as a field.
    """

    def init(self) -> Block: ...
    def step(self, s: Block, u: float, t: float) -> Block: ...
    def held(self, s: Block, u: float) -> Any: ...
    def steady(self, u: float) -> Any: ...
    def at(self, held: Any, t: float) -> float: ...
    def next_jump(self, held: Any, t: float) -> float: ...
    def applied(self, s: Block, u: float, dt: float) -> float: ...


class Integrator(Protocol):
    """Carries a system's continuous state ``x`` from one sample to the next, under what is held of a command.

    The system has ``deriv(t, x, u)`` and ``next_jump(t, u)``, which is as a load's. ``substeps`` is how many
    equal steps a fixed-step method takes in ``dt``. ``trusted_rate`` is the largest |lambda| [1/s] of the
    system's Jacobian that such steps can be trusted with, and ``substeps_for`` how many of them follow one
    that moves at a ``rate`` [1/s] to a relative ``tolerance``.

    A method that has ``substep(system, t, x, u, h)`` says that ``advance`` is this, ``substeps`` times with
    h = dt/substeps; many runs side by side, and runs with monitors, then call it directly. One that chooses
    its steps says what ``advance`` is by two others: ``begin(t, dt, substeps)`` is how far the period is
    integrated at its start, and ``attempt(system, t, x, u, dt, p)`` the state and how far it is after one
    more try, from such a ``p``. Its ``gone`` [s] grows where the try was accepted, until it is ``dt``.
    Monitors hear each step of either kind, and one a sample period of a method that says neither.
    """

    def advance(self, system: Block, t: float, x: Block, u: Any, dt: float, substeps: int) -> Block: ...
    def trusted_rate(self, dt: float, substeps: int) -> float: ...
    def substeps_for(self, rate: float, dt: float, tolerance: float) -> int: ...


class Sensors(Protocol):
    """What the controller sees of the machine: a sampled state (noise, filters), and the measurement from it.

    ``step`` comes first at a sample; ``measure`` then sees its new state. Sensors that leave fields of the
    measurement unmeasured, as nan, have a method ``missing()`` that names them. Those with fields ``area_a``
    and ``area_b`` [m^2] are given the plant's; those that wrap others have them as their field ``sensors``.
    """

    def init(self) -> Block: ...
    def step(self, s: Block, machine: MachineOutputs, draws: Draws, dt: float) -> Block: ...
    def measure(self, s: Block, machine: MachineOutputs, command: float) -> Measurement: ...


class PositionSensor(Protocol):
    """A sensor of the piston's position [m]; its state holds the reading ``value``, nan if it has none."""

    def init(self) -> Block: ...
    def step(self, s: Block, position: float, draws: Draws, dt: float) -> Block: ...


class VelocityEstimator(Protocol):
    """The piston's velocity [m/s]; its state holds it as ``value``.

    It is estimated from the ``position`` as measured, or measured at the machine itself.
    """

    def init(self) -> Block: ...
    def step(self, s: Block, machine: MachineOutputs, position: float, draws: Draws, dt: float) -> Block: ...


class PressureSensor(Protocol):
    """A sensor of a chamber's pressure [Pa]; its state holds the reading ``value``, nan if it has none."""

    def init(self) -> Block: ...
    def step(self, s: Block, pressure: float, draws: Draws, dt: float) -> Block: ...


class ForceSensor(Protocol):
    """A sensor of the force at the rod [N]; its state holds the reading ``value``, nan if it has none."""

    def init(self) -> Block: ...
    def step(self, s: Block, force: float, draws: Draws, dt: float) -> Block: ...


class Limiter(Protocol):
    """The limit of a command [V]."""

    def apply(self, u: float) -> float: ...


class Filter(Protocol):
    """A sampled filter of one signal, its numbers those of one sample period; its state holds ``value``."""

    def init(self) -> Block: ...
    def step(self, s: Block, value: float) -> Block: ...


class Model(Protocol):
    """What a law believes of the machine, in strict-feedback form with x1 the velocity and x2 the load force.

    dx1/dt = f1(x1) + g1 x2 and dx2/dt = f2(x1, x2) + g2(x2, u) u; ``f1_slope`` is df1/dx1 [1/s].
    """

    def f1(self, velocity: float) -> float: ...
    def f1_slope(self) -> float: ...
    def g1(self) -> float: ...
    def f2(self, velocity: float, load_force: float) -> float: ...
    def g2(self, load_force: float, command: float) -> float: ...


class CheckFlow(Protocol):
    """What lets oil pass one way: its flow [m^3/s] at a drop [Pa], negative where it comes back.

    ``piloted`` is the flow with a pilot's pressure above that before the valve [Pa]; one that a pilot opens
    has its ``pilot_ratio`` as a field.
    """

    def flow(self, drop: float) -> float: ...
    def piloted(self, drop: float, pilot: float) -> float: ...


class Relief(Protocol):
    """What lets a supply's oil off to the tank: its flow [m^3/s] at a gauge pressure [Pa]."""

    def flow(self, pressure: float) -> float: ...


class Poppet(Protocol):
    """How the poppet of a relief valve, the supply's ReliefValve, follows the gauge pressure [Pa].

    ``steady_at`` is the state in which the ``flow`` [m^3/s] is that of the relief valve's own curve.
    """

    def init(self) -> Block: ...
    def steady_at(self, relief: Block, pressure: float) -> Block: ...
    def deriv(self, s: Block, relief: Block, pressure: float) -> Block: ...
    def flow(self, s: Block, relief: Block, pressure: float) -> float: ...


class Monitor(Protocol):
    """What a run is judged by: numbers gathered while it goes on, and what they come to.

    ``step`` comes before each of the integrator's steps, with the loop, the loop's state at that instant
    ``t`` and how long the step is; and once more at the end of the run, with ``dt`` = 0. ``values`` is called
    after the run, and before it with what ``init`` gives, both in plain Python: a NamedTuple of floats and
    flags, each declared as ``Annotated[float, Field(unit, meaning, smaller_is_better=True)]``. Numbers of the
    state that are declared likewise can be recorded. Under the decorator ``at_samples``, ``step`` comes at
    the samples alone.
    """

    def init(self) -> Block: ...
    def step(self, m: Block, loop: Block, s: Block, t: float, dt: float) -> Block: ...
    def values(self, m: Block) -> Block: ...
