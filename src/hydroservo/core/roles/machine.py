"""What a machine is made of: cylinder, valve, supply, what acts on them, and what measures them."""

from typing import Protocol

from hydroservo.core.roles.saying import Block
from hydroservo.core.signals import (
    Draws,
    EdgeOpenings,
    Feed,
    MachineOutputs,
    Measurement,
    PortFlows,
    Pressures,
)


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
    Edges that overlap have their overlap as a field ``lap`` [m], those that are not straight how they open as
    a field ``shape``.
    """

    def flow(self, opening: float, supply_drop: float, load_pressure: float) -> float: ...
    def port_flows(
        self, opening: float, line: Pressures, pressure_a: float, pressure_b: float
    ) -> PortFlows: ...
    def simplified(self) -> Block: ...


class EdgeShape(Protocol):
    """How far each of four edges is open, from the opening of their spool [m]."""

    def openings(self, opening: float) -> EdgeOpenings: ...


class Valve(Protocol):
    """A servo valve: a spool driven by the command, and the metering edges that its opening [m] uncovers.

    One whose laws are to have a design model of it has its ``gain`` [m/V] as a field; with ``max_opening``
    [m], how far the spool travels, runs say where a law asks for far more.
    """

    @property
    def orifice(self) -> MeteringEdges: ...

    def init(self) -> Block: ...
    def deriv(self, s: Block, u: float) -> Block: ...
    def opening(self, s: Block, u: float) -> float: ...


class Drive(Protocol):
    """What turns a command and the pressures at the cylinder's two ports [Pa] into the flows through them.

    It is given what the loop's valve and supply hold ready, the :class:`~hydroservo.core.signals.Feed`.
    ``power`` [W] is what the drive draws while it passes these flows at these pressures: with the oil from
    the supply's line, and at the shaft of a motor of its own; negative where it gives back. One that stands
    in the valve's place is ``valveless``, as the decorator of that name says; one around another has that as
    its field ``drive``, and one whose start may be left open has ``at_rest(line, pressure_a, pressure_b)``.
    One that a cylinder described by its load pressure [Pa] may have, too, has ``load_flow(s, feed,
    load_pressure)`` [m^3/s].
    """

    def init(self) -> Block: ...
    def deriv(self, s: Block, feed: Feed, pressure_a: float, pressure_b: float) -> Block: ...
    def flows(self, s: Block, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows: ...
    def power(
        self, s: Block, feed: Feed, flows: PortFlows, pressure_a: float, pressure_b: float
    ) -> float: ...


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
    can, by ``positions()``; one whose tip can carry something says how that moves, by ``tip(position)``;
    one that does not go with every start and stroke refuses others by ``check_within(start_position,
    stroke)``.
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

    ``flows`` asks the drive's :class:`~hydroservo.machine.drives.ports.Ports` for what the cylinder takes.
    ``hydraulic_force`` is that of the oil on the piston, and linear in the state, so that it gives its rate
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
    def hydraulic_force(self, s: Block) -> float: ...
    def outputs(self, s: Block, line: Pressures, force: float) -> MachineOutputs: ...
    def simplified(self) -> Block: ...


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
