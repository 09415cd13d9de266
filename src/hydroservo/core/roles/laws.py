"""What a law is made of: what computes a command, and the parts that it may nest."""

from typing import Protocol

from hydroservo.core.roles.blocks import Block
from hydroservo.core.signals import Correction, Demand, Measurement, ReachingRate, VelocityError


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
