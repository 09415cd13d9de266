"""What closes a loop: laws and their parts, what is asked of them, when, and what they are judged by."""

from typing import Any, Protocol

from hydroservo.core.field import Field
from hydroservo.core.roles.saying import Block
from hydroservo.core.signals import Correction, Demand, Measurement, ReachingRate, Seen, VelocityError


class Controller(Protocol):
    """A sampled control law: measurement and demand in, a new state with its command ``u`` [V] out.

    What is computed before a run is, by ``designed(model, period)``, which blocks in a law may have too; a
    ``model`` of its own is what it, and what is in it, believes of the machine. A law that wraps another has
    that as its field ``controller``; its own limiter is its field ``saturation``. What it controls is its
    field ``controls``, and one of its ``signals`` if it can control but some; what the law inside controls,
    if another, its field ``inner_controls``. A law inside that controls a signal of its own is its field
    ``limiting``.
    """

    def init(self) -> Block: ...
    def step(self, s: Block, y: Measurement, r: Demand, dt: float) -> Block: ...


class Observer(Protocol):
    """A sampled disturbance observer.

    Its state holds the estimates ``d1`` [m/s^2] and ``d2`` [N/s], the surfaces ``s1`` [m/s] and ``s2`` [N],
    and the ``velocity`` [m/s] and ``hydraulic_force`` [N] that a law is to take. One whose d1 and d2 are no
    estimates says so, by the decorator ``without_estimates``.
    """

    def init(self) -> Block: ...
    def step(self, s: Block, model: Block, y: Measurement, dt: float) -> Block: ...


class Realisation(Protocol):
    """How a reaching law's sgn is realised in discrete time, for each of the two surfaces.

    It may say what it supposes of its sampling: ``supposes(D, noise, dt, unit)``.
    """

    def first(self, s: float, k: float, D: float, eps: float, a: float, dt: float) -> Correction: ...
    def second(self, s: float, k: float, D: float, eps: float, a: float, dt: float) -> Correction: ...


class ErrorDynamics(Protocol):
    """How a law wants the velocity's error to vanish: e'' = -q.

    Its state holds the two terms of q [m/s^3]: ``damping``, against the error's rate, and ``restoring``,
    against the error or a surface.
    """

    def init(self) -> Block: ...
    def step(self, s: Block, error: VelocityError, dt: float) -> Block: ...


class Reaching(Protocol):
    """How two surfaces are drawn to 0 in discrete time: the rate k s + eps |s|^a sgn(s), and its slope.

    The slope is the rate's derivative by s [1/s]; the second surface needs none. It may say what it supposes
    of its sampling: ``supposes(eps, a, size, unit, dt)``.
    """

    def first(self, s: float, k: float, eps: float, a: float, dt: float) -> ReachingRate: ...
    def second(self, s: float, k: float, eps: float, a: float, dt: float) -> float: ...


class Differentiator(Protocol):
    """The rate of a sampled signal; its state holds the estimate ``rate``."""

    def init(self) -> Block: ...
    def step(self, s: Block, value: float, model_rate: float, dt: float) -> Block: ...


class Limiter(Protocol):
    """The limit of a command [V]; as a field ``limit`` if it is one number either way."""

    def apply(self, u: float) -> float: ...


class Basis(Protocol):
    """An acceleration [m/s^2] that is a function of the velocity, learnt as a sum of weighted functions.

    ``s`` are the weights, its state, and ``at`` what the functions are ``at(velocity)``; ``slope`` is that of
    the acceleration [1/s], ``squared`` and ``most`` are the sums of squares and of sizes of what each weight
    can do. ``drive`` is what moves them [s^2/m].
    """

    def init(self) -> Block: ...
    def at(self, velocity: float) -> Block: ...
    def value(self, s: Block, at: Block) -> float: ...
    def slope(self, s: Block, at: Block) -> float: ...
    def squared(self, at: Block) -> float: ...
    def most(self, at: Block) -> float: ...
    def adapted(self, s: Block, at: Block, drive: float, dt: float) -> Block: ...


class Filter(Protocol):
    """A sampled filter of one signal, its numbers those of one sample period; its state holds ``value``."""

    def init(self) -> Block: ...
    def step(self, s: Block, value: float) -> Block: ...


class Model(Protocol):
    """A law's model of the machine, in strict-feedback form: x1 is the velocity, x2 the hydraulic force.

    dx1/dt = f1(x1) + g1 x2 and dx2/dt = f2(x1, x2) + g2(x2, u) u; ``f1_slope`` is df1/dx1 [1/s].
    """

    def f1(self, velocity: float) -> float: ...
    def f1_slope(self) -> float: ...
    def g1(self) -> float: ...
    def f2(self, velocity: float, hydraulic_force: float) -> float: ...
    def g2(self, hydraulic_force: float, command: float) -> float: ...


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
