"""The closed loop of the paper for tools that take a function, written over the mathematics of each tool.

Equations of doi:10.1007/s42401-021-00087-w, SI units. Constants are formed once per run, as in c/laws.h. A
machine's state is (velocity, hydraulic force, position); a controller's is (command, the observer's v1, v2
and g2, the filtered rate of d1, the last d1).
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.given import LAW, MACHINE, named
from hydroservo import Loop

__all__ = [
    "PLAIN",
    "Law",
    "Machine",
    "Maths",
    "closed_loop_step",
    "demand",
    "law_of",
    "machine_of",
    "machine_rates",
    "open_loop_rates",
    "rk4",
    "sample",
    "start",
    "valve",
    "wave",
]

Real = Any  # a float, or what the tool computes with
State = tuple[Real, ...]
Varied = Mapping[str, NDArray[np.float64]]


class Maths(NamedTuple):
    """The functions that a tool has for its numbers."""

    sin: Callable[[Real], Real]
    cos: Callable[[Real], Real]
    tanh: Callable[[Real], Real]
    sqrt: Callable[[Real], Real]
    power: Callable[[Real, Real], Real]  # of a base >= 0
    larger: Callable[[Real, Real], Real]
    smaller: Callable[[Real, Real], Real]
    sign: Callable[[Real], Real]
    magnitude: Callable[[Real], Real]


PLAIN = Maths(
    math.sin,
    math.cos,
    math.tanh,
    math.sqrt,
    math.pow,
    lambda a, b: a if a > b else b,
    lambda a, b: a if a < b else b,
    lambda x: (x > 0.0) - (x < 0.0),
    abs,
)


class Machine(NamedTuple):
    """dx1/dt = (x2 - b x1 - F)/m, dx2/dt = -by_velocity x1 - by_force x2 + flow x_v sqrt(drop)."""

    inv_mass: Real
    damping: Real
    by_velocity: Real
    by_force: Real
    flow: Real
    inv_area: Real
    supply: Real
    valve_gain: Real
    max_opening: Real
    start_position: Real
    amplitude: Real
    omega: Real
    load_amplitude: Real
    load_omega: Real
    command_amplitude: Real  # of the plant alone; 0 where there is a controller
    command_omega: Real


class Law(NamedTuple):
    """The controller and its nominal model: f1 = slope x1, f2 as the machine's, g2 = gain sqrt(drop)."""

    slope: Real
    g1: Real
    by_velocity: Real
    by_force: Real
    gain: Real
    inv_area: Real
    supply: Real
    least_drop: Real
    mu1: Real
    mu2: Real
    delta1: Real
    delta2: Real
    a1: Real
    a2: Real
    least_xi: Real
    limit: Real
    kd1: Real
    kd2: Real
    D1: Real
    D2: Real
    eps1: Real
    eps2: Real
    a: Real
    inv_phi1: Real
    inv_phi2: Real
    time_constant: Real


def machine_of(loop: Loop, varied: Varied) -> Machine:
    """The machine's constants; those that vary as arrays over the runs."""
    g = named(loop, MACHINE, varied)
    stiffness = 4.0 * g.bulk_modulus / g.volume
    return Machine(
        inv_mass=1.0 / g.mass,
        damping=g.damping,
        by_velocity=stiffness * g.area * g.area,
        by_force=stiffness * g.leakage,
        flow=stiffness * g.area * g.discharge * g.gradient / math.sqrt(g.density),
        inv_area=1.0 / g.area,
        supply=g.supply,
        valve_gain=g.valve_gain,
        max_opening=g.max_opening,
        start_position=g.start_position,
        amplitude=g.reference_amplitude,
        omega=2.0 * math.pi * g.reference_frequency,
        load_amplitude=g.load_amplitude,
        load_omega=2.0 * math.pi * g.load_frequency,
        command_amplitude=getattr(loop.valve, "amplitude", 0.0),
        command_omega=2.0 * math.pi * getattr(loop.valve, "frequency", 0.0),
    )


def law_of(loop: Loop) -> Law:
    """The controller's constants."""
    g = named(loop, LAW, {})
    stiffness = 4.0 * g.nominal_bulk_modulus / g.nominal_volume
    flow = (
        stiffness * g.nominal_area * g.nominal_discharge * g.nominal_gradient / math.sqrt(g.nominal_density)
    )
    return Law(
        slope=-g.nominal_damping / g.nominal_mass,
        g1=1.0 / g.nominal_mass,
        by_velocity=stiffness * g.nominal_area * g.nominal_area,
        by_force=stiffness * g.nominal_leakage,
        gain=flow * g.nominal_valve_gain,
        inv_area=1.0 / g.nominal_area,
        supply=g.nominal_supply,
        inv_phi1=1.0 / g.phi1,
        inv_phi2=1.0 / g.phi2,
        **{name: getattr(g, name) for name in LAW if name in Law._fields},
    )


def start(machine: Machine) -> tuple[State, State]:
    """Machine and controller at rest; the observer starts on its surfaces."""
    return (0.0, 0.0, machine.start_position), (0.0,) * 6


def wave(m: Maths, amplitude: Real, omega: Real, t: Real) -> Real:
    """amplitude sin(omega t)."""
    return amplitude * m.sin(omega * t)


def demand(m: Maths, c: Machine, t: Real) -> tuple[Real, Real, Real]:
    """The velocity demand and its first two derivatives."""
    value = wave(m, c.amplitude, c.omega, t)
    return value, c.amplitude * c.omega * m.cos(c.omega * t), -c.omega * c.omega * value


def sample(m: Maths, p: Law, x: State, r: tuple[Real, Real, Real], s: State, dt: float) -> State:
    """The controller's next state: eqs. (12)-(14) and (19)-(22) with boundary layers."""
    x1, x2 = x[0], x[1]
    u, v1, v2, g2, rate, last = s
    value, demand_rate, jerk = r

    def power(base: Real, exponent: Real) -> Real:
        return m.sign(base) * m.power(m.magnitude(base), exponent)

    v2 = v2 + dt * g2 * u
    s1, s2 = v1 - x1, v2 - x2
    d1 = -p.kd1 * s1 - p.D1 * m.tanh(s1 * p.inv_phi1) - p.eps1 * power(s1, p.a)
    d2 = -p.kd2 * s2 - p.D2 * m.tanh(s2 * p.inv_phi2) - p.eps2 * power(s2, p.a)
    f2 = -p.by_velocity * x1 - p.by_force * x2
    acceleration = p.slope * x1 + p.g1 * x2 + d1
    g2 = p.gain * m.sqrt(m.larger(p.supply - m.sign(u) * x2 * p.inv_area, p.least_drop))
    xi1, xi1_rate = x1 - value + s1, acceleration - demand_rate
    xi2 = xi1_rate + p.mu1 * xi1 + p.delta1 * power(xi1, p.a1) + p.g1 * s2 + p.slope * s1
    slope = p.a1 * m.power(m.magnitude(xi1) + p.least_xi, p.a1 - 1.0)
    rate = rate + dt / (p.time_constant + dt) * ((d1 - last) * (1.0 / dt) - rate)
    drift = (
        p.slope * acceleration
        + p.g1 * (f2 + d2)
        + rate
        - jerk
        + (p.mu1 + p.delta1 * slope) * xi1_rate
        + p.mu2 * xi2
        + p.delta2 * power(xi2, p.a2)
    )
    command = m.smaller(m.larger(-drift / (p.g1 * g2), -p.limit), p.limit)
    return command, v1 + dt * acceleration, v2 + dt * (d2 + f2), g2, rate, d1


def valve(m: Maths, c: Machine, u: Real) -> tuple[Real, Real]:
    """What multiplies the orifice's root under a held command, and the opening's sign over the area."""
    opening = m.smaller(m.larger(c.valve_gain * u, -c.max_opening), c.max_opening)
    return c.flow * opening, m.sign(opening) * c.inv_area


def machine_rates(m: Maths, c: Machine, held: tuple[Real, Real], load: Real, x: State) -> State:
    """The rates of the machine's state."""
    push, edge = held
    drop = m.larger(c.supply - edge * x[1], 0.0)
    return (
        (x[1] - c.damping * x[0] - load) * c.inv_mass,
        -c.by_velocity * x[0] - c.by_force * x[1] + push * m.sqrt(drop),
        x[0],
    )


def open_loop_rates(m: Maths, c: Machine, t: Real, x: State) -> State:
    """The rates under the smooth command of the plant alone."""
    held = valve(m, c, wave(m, c.command_amplitude, c.command_omega, t))
    return machine_rates(m, c, held, wave(m, c.load_amplitude, c.load_omega, t), x)


def rk4(rates: Callable[[Real, State], State], t: Real, x: State, h: float) -> State:
    """One step of the classical Runge-Kutta method."""

    def along(step: float, k: State) -> State:
        return tuple(a + step * b for a, b in zip(x, k, strict=True))

    k1 = rates(t, x)
    k2 = rates(t + 0.5 * h, along(0.5 * h, k1))
    k3 = rates(t + 0.5 * h, along(0.5 * h, k2))
    k4 = rates(t + h, along(h, k3))
    return tuple(
        a + h / 6.0 * (b + 2.0 * (c + d) + e) for a, b, c, d, e in zip(x, k1, k2, k3, k4, strict=True)
    )


def closed_loop_step(
    m: Maths, c: Machine, p: Law, t: Real, x: State, s: State, dt: float
) -> tuple[State, State, Real]:
    """One sample period: machine and controller at its end, and the velocity error at its start."""
    r = demand(m, c, t)
    s = sample(m, p, x, r, s, dt)
    held = valve(m, c, s[0])

    def rates(at: Real, y: State) -> State:
        return machine_rates(m, c, held, wave(m, c.load_amplitude, c.load_omega, at), y)

    return rk4(rates, t, x, dt), s, x[0] - r[0]
