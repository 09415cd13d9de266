# mypy: disable-error-code="untyped-decorator"
"""The loops that peers/numba.py runs, as a user of numba writes them."""

import math
from typing import Any

import numpy as np
from numba import njit, prange

__all__ = ["closed_loops", "plant_alone"]

Row = Any  # numbers in the order of laws.Machine or laws.Law
Three = tuple[float, float, float]


@njit(fastmath=True, error_model="numpy")
def sign(x: float) -> float:
    """-1, 0 or +1."""
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0


@njit(fastmath=True, error_model="numpy")
def signed_power(x: float, a: float) -> float:
    """|x|^a sgn(x)."""
    return math.copysign(math.pow(abs(x), a), x)


@njit(fastmath=True, error_model="numpy")
def rk4(c: Row, x1: float, x2: float, x3: float, h: float, push: Three, edge: Three, load: Three) -> Three:
    """One classical Runge-Kutta step; valve and load at its start, middle and end."""
    inv_mass, damping, by_velocity, by_force, supply = c[0], c[1], c[2], c[3], c[6]
    a1 = (x2 - damping * x1 - load[0]) * inv_mass
    a2 = -by_velocity * x1 - by_force * x2 + push[0] * math.sqrt(max(supply - edge[0] * x2, 0.0))
    y1, y2 = x1 + 0.5 * h * a1, x2 + 0.5 * h * a2
    b1 = (y2 - damping * y1 - load[1]) * inv_mass
    b2 = -by_velocity * y1 - by_force * y2 + push[1] * math.sqrt(max(supply - edge[1] * y2, 0.0))
    z1, z2 = x1 + 0.5 * h * b1, x2 + 0.5 * h * b2
    c1 = (z2 - damping * z1 - load[1]) * inv_mass
    c2 = -by_velocity * z1 - by_force * z2 + push[1] * math.sqrt(max(supply - edge[1] * z2, 0.0))
    w1, w2 = x1 + h * c1, x2 + h * c2
    d1 = (w2 - damping * w1 - load[2]) * inv_mass
    d2 = -by_velocity * w1 - by_force * w2 + push[2] * math.sqrt(max(supply - edge[2] * w2, 0.0))
    return (
        x1 + h / 6.0 * (a1 + 2.0 * (b1 + c1) + d1),
        x2 + h / 6.0 * (a2 + 2.0 * (b2 + c2) + d2),
        x3 + h / 6.0 * (x1 + 2.0 * (y1 + z1) + w1),
    )


@njit(fastmath=True, error_model="numpy")
def closed_loop(c: Row, p: Row, steps: int, dt: float) -> float:
    """One run of the closed loop; c and p are in the order of laws.Machine and laws.Law."""
    flow, inv_area, valve_gain, max_opening = c[4], c[5], c[7], c[8]
    amplitude, omega, load_amplitude, load_omega = c[10], c[11], c[12], c[13]
    slope, g1, by_velocity, by_force, gain, model_inv_area, supply, least_drop = p[:8]
    mu1, mu2, delta1, delta2, a1, a2, least_xi, limit = p[8:16]
    kd1, kd2, D1, D2, eps1, eps2, a, inv_phi1, inv_phi2, time_constant = p[16:]
    weight = dt / (time_constant + dt)
    x1, x2, x3 = 0.0, 0.0, c[9]
    u, v1, v2, g2, rate, last = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    half = 0.5 * steps * dt
    squares = 0.0
    for k in range(steps):
        t = k * dt
        value = amplitude * math.sin(omega * t)
        demand_rate = amplitude * omega * math.cos(omega * t)
        jerk = -omega * omega * value
        if t >= half:
            squares += (x1 - value) ** 2
        v2 += dt * g2 * u
        s1, s2 = v1 - x1, v2 - x2
        d1 = -kd1 * s1 - D1 * math.tanh(s1 * inv_phi1) - eps1 * signed_power(s1, a)
        d2 = -kd2 * s2 - D2 * math.tanh(s2 * inv_phi2) - eps2 * signed_power(s2, a)
        f2 = -by_velocity * x1 - by_force * x2
        acceleration = slope * x1 + g1 * x2 + d1
        g2 = gain * math.sqrt(max(supply - sign(u) * x2 * model_inv_area, least_drop))
        xi1 = x1 - value + s1
        xi1_rate = acceleration - demand_rate
        xi2 = xi1_rate + mu1 * xi1 + delta1 * signed_power(xi1, a1) + g1 * s2 + slope * s1
        power_slope = a1 * math.pow(abs(xi1) + least_xi, a1 - 1.0)
        rate += weight * ((d1 - last) / dt - rate)
        drift = (
            slope * acceleration
            + g1 * (f2 + d2)
            + rate
            - jerk
            + (mu1 + delta1 * power_slope) * xi1_rate
            + mu2 * xi2
            + delta2 * signed_power(xi2, a2)
        )
        u = max(-limit, min(-drift / (g1 * g2), limit))
        v1 += dt * acceleration
        v2 += dt * (d2 + f2)
        last = d1
        opening = max(-max_opening, min(valve_gain * u, max_opening))
        push, edge = flow * opening, sign(opening) * inv_area
        load = (
            load_amplitude * math.sin(load_omega * t),
            load_amplitude * math.sin(load_omega * (t + 0.5 * dt)),
            load_amplitude * math.sin(load_omega * (t + dt)),
        )
        x1, x2, x3 = rk4(c, x1, x2, x3, dt, (push, push, push), (edge, edge, edge), load)
    return math.sqrt(squares / (steps // 2))


@njit(fastmath=True, error_model="numpy", parallel=True)
def closed_loops(rows: Any, p: Row, steps: int, dt: float) -> Any:
    """The steady rms error of each run."""
    out = np.empty(len(rows))
    for i in prange(len(rows)):
        out[i] = closed_loop(rows[i], p, steps, dt)
    return out


@njit(fastmath=True, error_model="numpy")
def valve(c: Row, u: float) -> tuple[float, float]:
    """What multiplies the root, and the opening's sign over the area."""
    opening = max(-c[8], min(c[7] * u, c[8]))
    return c[4] * opening, sign(opening) * c[5]


@njit(fastmath=True, error_model="numpy")
def plant_alone(c: Row, steps: int, dt: float) -> Three:
    """The machine under a smooth command; its state at the end."""
    load_amplitude, load_omega, amplitude, omega = c[12:]
    x1, x2, x3 = 0.0, 0.0, c[9]
    push, edge, load = 0.0, 0.0, 0.0
    for k in range(steps):
        centre, end = (k + 0.5) * dt, (k + 1) * dt
        push_middle, edge_middle = valve(c, amplitude * math.sin(omega * centre))
        push_end, edge_end = valve(c, amplitude * math.sin(omega * end))
        load_middle = load_amplitude * math.sin(load_omega * centre)
        load_end = load_amplitude * math.sin(load_omega * end)
        pushes, edges = (push, push_middle, push_end), (edge, edge_middle, edge_end)
        x1, x2, x3 = rk4(c, x1, x2, x3, dt, pushes, edges, (load, load_middle, load_end))
        push, edge, load = push_end, edge_end, load_end
    return x1, x2, x3
