"""What is asked of a loop, how it runs between samples, and what it is judged by."""

from typing import Any, Protocol

from hydroservo.core.field import Field
from hydroservo.core.roles.blocks import Block
from hydroservo.core.signals import Demand, Seen


class ControlledSignal(Protocol):
    """What a loop controls, and a law's demand is of.

    ``declared`` is its unit and its name; ``of`` picks it from what is seen of the machine, by sensors or as
    it is, and the command [V]. One that a machine can take within limits has ``reach(plant, line)``.
    """

    def declared(self) -> Field: ...
    def of(self, seen: Seen, command: float) -> float: ...


class Reference(Protocol):
    """What the controlled signal should be as a function of time, with its first two derivatives.

    One that waits before it changes has the instant at which it begins [s] as its field ``time``.
    """

    def at(self, t: float) -> Demand: ...


class Start(Protocol):
    """Where a run starts: the loop's first state, from that which its blocks start in.

    Numbers of the state that are given are in a group ``given``, as :func:`~hydroservo.core.group.nested`
    makes it. A start that finds others before a run has ``found(steady)``, which gives them in such a group,
    or as a state of the machine; ``steady(command)`` is the machine's steady state under a command [V], and a
    start that asks for one alone has its ``command`` as a field: a batch then seeks them all at once. The
    loop then starts :class:`~hydroservo.machine.starts.AsBuilt` with both.
    """

    @property
    def given(self) -> Block: ...

    def of(self, s: Block) -> Block: ...


class Hold(Protocol):
    """How a command is held between samples.

    ``step`` comes at a sample, before the controller, with the command that it replaces; ``held`` is what
    integrators carry to the machine, ``at`` its value at an instant and ``next_jump`` the first instant after
    it at which it jumps. ``applied`` is the mean command over the period just ended. A hold that comes late
    has its ``delay`` [s] as a field.
    """

    def init(self) -> Block: ...
    def step(self, s: Block, u: float, t: float) -> Block: ...
    def held(self, s: Block, u: float) -> Any: ...
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
    Monitors hear each step of either kind, and one a sample period of a method that says neither. Where it
    says too ``most_steps``, how many of its least length a period may take, a run with twice as many is what
    its steps are held against.
    """

    def advance(self, system: Block, t: float, x: Block, u: Any, dt: float, substeps: int) -> Block: ...
    def trusted_rate(self, dt: float, substeps: int) -> float: ...
    def substeps_for(self, rate: float, dt: float, tolerance: float) -> int: ...


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
