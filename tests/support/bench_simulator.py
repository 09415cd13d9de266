"""A double-acting cylinder on a servo valve, by SciPy alone, and logs of it: what maps are judged by.

Nothing here comes from the engine of hydroservo, so that what maps find is compared with another calculation.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.signal import lsim

Samples = NDArray[np.float64]
Signals = dict[str, Samples]

SPEED = 2e-4  # m/s, over which dry friction changes its sign
RESOLUTION = {"position": 1e-6, "velocity": 1e-5, "pressure_a": 6e3, "pressure_b": 6e3, "command": 3e-4}
NOISE = {"position": 5e-6, "velocity": 2e-3, "pressure_a": 2e4, "pressure_b": 2e4}


class Bench(NamedTuple):
    """The machine, in SI units, with the areas, volumes and supply of examples/maps/machine.toml."""

    area_a: float = 12.566e-4
    area_b: float = 8.765e-4
    stroke: float = 0.4
    dead_volume: float = 1e-4  # of each chamber
    modulus: float = 1.1e9
    inside: float = 2e-13  # leakage past the piston [m^3/(s Pa)]
    outside: float = 4e-14  # of each chamber to the outside
    mass: float = 80.0
    coulomb: float = 180.0
    breakaway: float = 260.0
    stribeck_velocity: float = 0.025
    viscous: float = 2500.0
    weight: float = 0.0  # constant force against motion [N]
    supply: float = 120e5
    tank: float = 2e5
    flow: float = 3.33e-8  # of an edge per volt and root of its drop [m^3/(s V sqrt(Pa))]
    dead_band: float = 0.4  # half its width [V]
    clearance: float = 1e-3  # over which an edge is round [V]
    hysteresis: float = 0.06  # full width [V]
    frequency: float = 60.0  # of the valve [Hz]
    damping: float = 0.8

    def flow_gain(self) -> float:
        """At half of the supply's drop [m^3/(s V)]."""
        return self.flow * float(np.sqrt(0.5 * (self.supply - self.tank)))

    def friction(self, velocity: float) -> float:
        """Stribeck's, at a speed [N]."""
        fall = 1.0 / (1.0 + (velocity / self.stribeck_velocity) ** 2)
        dry = self.coulomb + (self.breakaway - self.coulomb) * fall
        return dry * float(np.tanh(velocity / SPEED)) + self.viscous * velocity

    def opening(self, time: Samples, command: Samples) -> Samples:
        """The spool in volts: a lag of second order behind a play."""
        behind, half = np.empty(command.size), 0.5 * self.hysteresis
        now = command[0]
        for i, u in enumerate(command.tolist()):
            now = min(max(now, u - half), u + half)
            behind[i] = now
        w = 2.0 * np.pi * self.frequency
        return lsim(([w * w], [1.0, 2.0 * self.damping * w, w * w]), behind, time)[1]

    def edge(self, opening: float, drop: float) -> float:
        """The flow of one edge [m^3/s]."""
        wide = 0.5 * (opening + np.hypot(opening, self.clearance))
        return float(self.flow * wide * drop / np.sqrt(abs(drop) + 1e3))

    def port(self, spool: float, pressure: float) -> float:
        """The flow into a chamber whose supply edge opens with a positive spool [m^3/s]."""
        fed = self.edge(spool - self.dead_band, self.supply - pressure)
        return fed - self.edge(-spool - self.dead_band, pressure - self.tank)


def moved(
    bench: Bench, time: Samples, command: Samples, start: float = 0.2, load: Samples | None = None
) -> Signals:
    """What the machine does under a command, the piston free, without error."""
    spool = bench.opening(time, command)

    def rate(t: float, state: Samples) -> list[float]:
        x, v, a, b = state
        y = float(np.interp(t, time, spool))
        leak = bench.inside * (a - b)
        to_a = bench.port(y, a) - bench.area_a * v - leak - bench.outside * a
        to_b = bench.port(-y, b) + bench.area_b * v + leak - bench.outside * b
        driving = bench.area_a * a - bench.area_b * b - bench.friction(v) - bench.weight
        return [
            v,
            driving / bench.mass,
            bench.modulus * to_a / (bench.dead_volume + bench.area_a * x),
            bench.modulus * to_b / (bench.dead_volume + bench.area_b * (bench.stroke - x)),
        ]

    b = 0.5 * bench.supply
    begun = [start, 0.0, (bench.area_b * b + bench.weight) / bench.area_a, b]
    found = solve_ivp(
        rate, time[[0, -1]], begun, "LSODA", time, rtol=1e-6, atol=[1e-9, 1e-7, 10.0, 10.0], max_step=0.02
    )
    x, v, a, b_ = found.y
    return {"time": time, "command": command, "position": x, "velocity": v, "pressure_a": a, "pressure_b": b_}


def blocked(bench: Bench, time: Samples, command: Samples, volume: float = 8e-6) -> Signals:
    """What the pressures of plugged ports do under a command, without error."""
    spool = bench.opening(time, command)

    def rate(t: float, state: Samples) -> list[float]:
        y = float(np.interp(t, time, spool))
        return [bench.modulus / volume * bench.port(one, p) for one, p in zip((y, -y), state, strict=True)]

    middle = 0.5 * (bench.supply + bench.tank)
    found = solve_ivp(rate, time[[0, -1]], [middle] * 2, "LSODA", time, rtol=1e-6, atol=10.0, max_step=0.02)
    return {"time": time, "command": command, "pressure_a": found.y[0], "pressure_b": found.y[1]}


def closed(bench: Bench, time: Samples, pressures: tuple[float, float], position: float = 0.2) -> Signals:
    """How the pressures of closed chambers decay with the piston held, in closed form by two eigenvalues."""
    volumes = np.array(
        [
            bench.dead_volume + bench.area_a * position,
            bench.dead_volume + bench.area_b * (bench.stroke - position),
        ]
    )
    leaks = np.array([[-1.0, 1.0], [1.0, -1.0]]) * bench.inside - np.eye(2) * bench.outside
    values, vectors = np.linalg.eig(bench.modulus * leaks / volumes[:, np.newaxis])
    parts = vectors * np.linalg.solve(vectors, np.array(pressures))
    a, b = parts @ np.exp(np.outer(values, time))
    return {"time": time, "pressure_a": a, "pressure_b": b}


def seen(exact: Signals, seed: int, *names: str) -> Signals:
    """Some signals as sensors show them: with noise and in steps."""
    rng = np.random.default_rng(seed)
    found = {"time": exact["time"]}
    for name in names:
        noisy = exact[name] + rng.normal(scale=NOISE.get(name, 0.0), size=exact["time"].size)
        found[name] = RESOLUTION[name] * np.round(noisy / RESOLUTION[name])
    return found


def triangle(time: Samples, amplitude: float, frequency: float) -> Samples:
    """A sweep of constant rate about 0, upwards first."""
    phase = (frequency * time + 0.25) % 1.0
    return amplitude * (4.0 * np.abs(phase - 0.5) - 1.0) * -1.0


def steps(time: Samples, levels: list[tuple[float, float]]) -> Samples:
    """Levels of the command [V], each for a time [s]."""
    ends = np.cumsum([duration for _, duration in levels])
    places = np.minimum(np.searchsorted(ends, time, side="right"), len(levels) - 1)
    return np.array([level for level, _ in levels])[places]


class Case(NamedTuple):
    """A log without error, what may be measured of it, and the numbers that a map should find."""

    kind: str
    exact: Signals
    measured: tuple[str, ...]
    truth: dict[str, float]


def case(kind: str, seed: int) -> Case:
    """An experiment on a machine drawn at random around that of examples/maps."""
    share = np.random.default_rng([seed, 7]).uniform(0.8, 1.25, 8)
    own = Bench()
    drawn = {"valve-flow": of_valve, "pressure-gain": of_blocked, "friction": of_moves, "decay": of_decay}
    return drawn[kind](own, share)


def of_valve(own: Bench, share: Samples) -> Case:
    """A slow sine, the piston free of all but a little friction and a weight."""
    own = own._replace(
        flow=own.flow * share[0],
        dead_band=own.dead_band * share[1],
        hysteresis=own.hysteresis * share[2],
        mass=20.0,
        coulomb=30.0,
        breakaway=40.0,
        weight=400.0 * (share[3] - 1.0),
    )
    time = np.arange(0.0, 40.0, 2e-3)
    amplitude = own.dead_band + 0.6 / share[0]
    exact = moved(own, time, amplitude * np.sin(2.0 * np.pi * 0.05 * time), 0.05)
    gain, edge = own.flow_gain(), own.dead_band
    truth = {
        "flow_gain_plus": gain,
        "flow_gain_minus": gain,
        "dead_band_plus": edge,
        "dead_band_minus": -edge,
        "dead_band": 2.0 * edge,
        "null_offset": 0.0,
        "hysteresis": own.hysteresis,
    }
    return Case("valve-flow", exact, ("command", "velocity", "position", "pressure_a", "pressure_b"), truth)


def of_blocked(own: Bench, share: Samples) -> Case:
    """A slow sine about null of a valve without overlap whose edges leak, its ports plugged."""
    own = own._replace(dead_band=0.0, clearance=0.03 * share[0], hysteresis=0.01 * share[1])
    time = np.arange(0.0, 160.0, 4e-3)
    exact = blocked(own, time, 0.15 * np.sin(2.0 * np.pi * 0.0125 * time))
    openings = np.linspace(-0.1, 0.1, 2001)
    drop = own.supply - own.tank
    middle = np.array([load_pressure(own, y) for y in openings.tolist()])
    on = np.abs(middle) < 0.4 * drop
    gain = float(np.polyfit(openings[on], middle[on], 1)[0])
    truth = {"pressure_gain": gain, "null_offset": 0.0, "hysteresis": own.hysteresis}
    return Case("pressure-gain", exact, ("command", "pressure_a", "pressure_b"), truth)


def load_pressure(own: Bench, spool: float) -> float:
    """p_A - p_B of plugged ports in the steady state [Pa]."""
    ends = own.tank, own.supply
    return float(brentq(lambda p: own.port(spool, p), *ends) - brentq(lambda p: own.port(-spool, p), *ends))


def of_moves(own: Bench, share: Samples) -> Case:
    """Moves at constant speeds to and fro."""
    own = own._replace(
        coulomb=own.coulomb * share[0],
        breakaway=own.breakaway * share[1] + 30.0,
        viscous=own.viscous * share[2],
        weight=400.0 * (share[3] - 1.0),
    )
    levels = [
        (sign * (0.4 + speed / 0.085), min(0.12 / speed, 4.0)) for speed in SPEEDS for sign in (1.0, -1.0)
    ]
    moves = [one for level in levels for one in (level, (0.0, 0.2))]
    time = np.arange(0.0, sum(duration for _, duration in moves), 2e-3)
    exact = moved(own, time, steps(time, moves), 0.15)
    names = ("coulomb", "breakaway", "stribeck_velocity", "viscous")
    truth = {name: getattr(own, name) for name in names} | {"offset": own.weight}
    return Case("friction", exact, ("command", "position", "pressure_a", "pressure_b"), truth)


SPEEDS = (0.006, 0.009, 0.013, 0.02, 0.03, 0.045, 0.07, 0.1, 0.15)


def of_decay(own: Bench, share: Samples) -> Case:
    """Pressures that decay in closed chambers."""
    own = own._replace(inside=own.inside * share[0], outside=own.outside * share[1])
    exact = closed(own, np.arange(0.0, 40.0, 4e-3), (110e5 * share[2], 15e5))
    truth = {"internal_leakage": own.inside, "external_leakage": own.outside}
    return Case("decay", exact, ("pressure_a", "pressure_b"), truth)
