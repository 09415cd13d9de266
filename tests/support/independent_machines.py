"""Machines simulated without the engine: each block's equations as its documentation has them, and RK4.

Many logs run side by side. Of the package nothing is used, so that what it identifies is held against physics
that it did not simulate itself.
"""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

FOLDER = Path(__file__).parent / "benches"
PERIOD = 1e-3
SUBSTEPS = 10
ATMOSPHERE = 101325.0
CENTRING = 15.0  # V/m, by which a command leads the piston back to where it began
LARGEST = 10.0  # V
SPANS = {"position": 0.1, "velocity": 0.3, "pressure_a": 1e7, "pressure_b": 1e7, "hydraulic_force": 1e4}

Rows = NDArray[np.float64]
Log = dict[str, NDArray[np.float64]]


class State(NamedTuple):
    """What moves, a column for each log."""

    velocity: Rows
    position: Rows
    pressure_a: Rows
    pressure_b: Rows
    drive: Rows  # opening of the spool, or speed of the pump's shaft
    spool_speed: Rows
    bristles: Rows


def scenario(name: str) -> Path:
    """The file that describes a machine to the package."""
    return FOLDER / f"{name}.toml"


def numbers_of(name: str, changes: Mapping[str, Any]) -> dict[str, Any]:
    """All that a scenario and what it builds on hold, by dotted path."""
    table = tomllib.loads(scenario(name).read_text("utf-8"))
    base = table.pop("base", None)
    own = flat(table) | dict(changes)
    replaced = {path.removesuffix(".type") for path in own if path.endswith(".type")}
    below = numbers_of(base.removesuffix(".toml"), {}) if base else {}
    kept = {path: value for path, value in below.items() if path.rpartition(".")[0] not in replaced}
    return kept | own


def flat(table: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """The values of nested tables by dotted path."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        path = f"{before}{key}"
        found |= flat(value, f"{path}.") if isinstance(value, Mapping) else {path: value}
    return found


def measured(
    name: str,
    signals: tuple[str, ...],
    logs: int,
    seconds: float,
    seed: int,
    changes: Mapping[str, Any] | None = None,
    skipped: float = 0.0,
) -> list[Log]:
    """Logs of a machine, each under a command of its own, with noise of 0.05 to 0.5 % of a signal's span.

    Args:
        name: of the machine.
        signals: that are measured.
        logs: how many.
        seconds: that each lasts.
        seed: of commands and noise.
        changes: of numbers, by dotted path; arrays of shape (logs,) are one for each log.
        skipped: seconds that a machine has moved for when its log begins.
    """
    rng = np.random.default_rng(seed)
    numbers = numbers_of(name, changes or {})
    exact = simulated(numbers, excitation(logs, seconds + skipped, rng))
    first = round(skipped / PERIOD)
    share = 10.0 ** rng.uniform(np.log10(5e-4), np.log10(5e-3), size=logs)
    found = []
    for k in range(logs):
        log = {"command": exact["command"][first:, k]}
        log["time"] = PERIOD * np.arange(log["command"].size)
        for signal in signals:
            noise = share[k] * SPANS[signal] * rng.normal(size=log["time"].size)
            log[signal] = exact[signal][first:, k] + noise
        found.append(log)
    return found


def excitation(logs: int, seconds: float, rng: np.random.Generator) -> Rows:
    """Five sines of random frequency and phase, and steps at random [V], shape (samples, logs)."""
    time = PERIOD * np.arange(round(seconds / PERIOD))[:, np.newaxis]
    total = np.zeros((time.size, logs))
    for least, most in ((0.4, 1.0), (1.0, 2.0), (2.0, 4.0), (4.0, 8.0), (8.0, 16.0)):
        frequency, phase = rng.uniform(least, most, logs), rng.uniform(0.0, 2.0 * np.pi, logs)
        total += 0.8 * (np.sin(2.0 * np.pi * frequency * time + phase) - np.sin(phase))
    for _ in range(4):
        total += np.where(time > rng.uniform(0.0, seconds, logs), rng.uniform(-1.5, 1.5, logs), 0.0)
    return total - total[0]


def simulated(p: Mapping[str, Any], excited: Rows) -> dict[str, Rows]:
    """What a machine shows at each sample, and the commands, which lead it back to where it began."""
    start = [
        0.0,
        *(p[f"plant.start_{key}"] for key in ("position", "pressure_a", "pressure_b")),
        0.0,
        0.0,
        0.0,
    ]
    x = np.repeat(np.array(start)[:, np.newaxis], excited.shape[1], axis=1)
    h, rows, commands = PERIOD / SUBSTEPS, [], []
    for demand in excited:
        u = np.clip(demand - CENTRING * (x[1] - start[1]), -LARGEST, LARGEST)
        rows.append(x)
        commands.append(u)
        for _ in range(SUBSTEPS):
            k1 = rates(p, x, u)
            k2 = rates(p, x + 0.5 * h * k1, u)
            k3 = rates(p, x + 0.5 * h * k2, u)
            k4 = rates(p, x + h * k3, u)
            x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    shown = dict(zip(State._fields, np.moveaxis(np.array(rows), 1, 0), strict=True))
    force = p["plant.area_a"] * shown["pressure_a"] - p["plant.area_b"] * shown["pressure_b"]
    return shown | {"hydraulic_force": force, "command": np.array(commands)}


def rates(p: Mapping[str, Any], x: Rows, u: Rows) -> Rows:
    """How fast all states change."""
    s = State(*x)
    drive, spool, into_a, out_of_b = (pumped if "drive.displacement" in p else metered)(p, s, u)
    friction, bristles = friction_of(p, s)
    spring = p.get("plant.mechanism.stiffness", 0.0)
    met = p["load.amplitude"] + spring * (s.position - p.get("plant.mechanism.rest_position", 0.0))
    area_a, area_b = p["plant.area_a"], p["plant.area_b"]
    force = area_a * s.pressure_a - area_b * s.pressure_b - met - friction
    leak = p["plant.internal_leakage"] * (s.pressure_a - s.pressure_b)
    volume_a = p["plant.dead_volume_a"] + area_a * s.position
    volume_b = p["plant.dead_volume_b"] + area_b * (p["plant.stroke"] - s.position)
    rate_a = bulk_modulus(p, s.pressure_a) / volume_a * (into_a - area_a * s.velocity - leak)
    rate_b = bulk_modulus(p, s.pressure_b) / volume_b * (area_b * s.velocity - out_of_b + leak)
    acceleration = force / p["plant.mechanism.mass"]
    return np.array([acceleration, s.velocity, rate_a, rate_b, drive, spool, bristles])


def bulk_modulus(p: Mapping[str, Any], pressure: Rows) -> Any:
    """-V dp/dV of oil, with the air in it where there is any, from V(P) and its slope."""
    if "plant.oil.effective_bulk_modulus" in p:
        return p["plant.oil.effective_bulk_modulus"]
    liquid, air = p["plant.oil.liquid_bulk_modulus"], p["plant.oil.air_content"]
    n = p["plant.oil.polytropic_index"]
    absolute = np.maximum(pressure + ATMOSPHERE, 1e-3)
    squeezed = 1.0 + (absolute - ATMOSPHERE) / liquid
    gas = air * (ATMOSPHERE / absolute) ** (1.0 / n)
    slope = (1.0 - air) / (liquid * squeezed**2) + gas / (n * absolute)
    return ((1.0 - air) / squeezed + gas) / slope


def friction_of(p: Mapping[str, Any], s: State) -> tuple[Any, Any]:
    """The force against motion, viscous or of bristles, and how fast these bend."""
    if "plant.friction.coulomb" not in p:
        return p["plant.friction.coefficient"] * s.velocity, np.zeros_like(s.velocity)
    least, most = p["plant.friction.coulomb"], p["plant.friction.breakaway"]
    sliding = least + (most - least) * np.exp(-((s.velocity / p["plant.friction.stribeck_velocity"]) ** 2))
    pull = p["plant.friction.bristle_stiffness"] * s.bristles
    bending = s.velocity - np.abs(s.velocity) * pull / sliding
    force = pull + p["plant.friction.bristle_damping"] * bending + p["plant.friction.viscous"] * s.velocity
    return force, bending


def metered(p: Mapping[str, Any], s: State, u: Rows) -> tuple[Any, Any, Any, Any]:
    """Rates of a spool's position and speed, and the flows through its four edges into A and out of B."""
    supply, tank = p["supply.supply_pressure"], p["supply.return_pressure"]
    size = p["valve.orifice.discharge_coefficient"] * p["valve.orifice.area_gradient"]
    size = size * np.sqrt(2.0 / p["valve.orifice.density"])
    forth, back = (edge(p, way * s.drive) * size for way in (1.0, -1.0))
    into_a = forth * root(p, supply - s.pressure_a) - back * root(p, s.pressure_a - tank)
    out_of_b = forth * root(p, s.pressure_b - tank) - back * root(p, supply - s.pressure_b)
    return *spool(p, s, u), into_a, p["valve.orifice.area_ratio_b"] * out_of_b


def edge(p: Mapping[str, Any], opening: Rows) -> Rows:
    """By how much an edge is open."""
    z = opening - p["valve.orifice.lap"]
    found: Rows = 0.5 * (z + np.sqrt(z**2 + 4.0 * p["valve.orifice.clearance"] ** 2))
    return found


def root(p: Mapping[str, Any], drop: Rows) -> Rows:
    """The root of a drop, laminar where that is small."""
    found: Rows = drop / (drop**2 + p["valve.orifice.transition_drop"] ** 2) ** 0.25
    return found


def spool(p: Mapping[str, Any], s: State, u: Rows) -> tuple[Rows, Rows]:
    """Rates of a spool's position and speed, of first order or of second with limits and play."""
    most = p["valve.max_opening"]
    wanted = np.clip(p["valve.gain"] * u, -most, most)
    if "valve.time_constant" in p:
        return (wanted - s.drive) / p["valve.time_constant"], np.zeros_like(u)
    wn, v = p["valve.natural_frequency"], s.spool_speed
    k, play = 5.0 * wn, 0.5 * p["valve.hysteresis"]
    at = np.clip(s.drive, wanted - play, wanted + play)
    free = wn**2 * (at - s.drive) - 2.0 * p["valve.damping_ratio"] * wn * v
    up = np.minimum(k * (p["valve.slew_limit"] - v), k**2 * (most - s.drive) - 2.0 * k * v)
    down = -np.minimum(k * (p["valve.slew_limit"] + v), k**2 * (most + s.drive) + 2.0 * k * v)
    return v, np.minimum(np.maximum(free, down), up)


def pumped(p: Mapping[str, Any], s: State, u: Rows) -> tuple[Any, Any, Any, Any]:
    """Rate of a pump's speed, and the flows into A and out of B, with those of check and relief valves."""
    swept = p["drive.displacement"]
    demanded = np.clip(p["drive.command_gain"] * u, -p["drive.max_speed"], p["drive.max_speed"])
    motor = p["drive.speed_gain"] * (demanded - s.drive)
    motor = np.clip(motor, -p["drive.max_torque"], p["drive.max_torque"])
    load = swept * (s.pressure_a - s.pressure_b) + p["drive.viscous"] * s.drive
    passed = swept * s.drive - p["drive.leakage"] * (s.pressure_a - s.pressure_b)
    into_a = passed + replenished(p, s.pressure_a, s.pressure_b)
    out_of_b = passed - replenished(p, s.pressure_b, s.pressure_a)
    return (motor - load) / p["drive.inertia"], np.zeros_like(u), into_a, out_of_b


def replenished(p: Mapping[str, Any], pressure: Rows, pilot: Rows) -> Rows:
    """What a port gets through its check valve less what its relief valve lets off."""
    line, check = p["supply.supply_pressure"], "drive.check_valve."
    forced = line - pressure + p[check + "pilot_ratio"] * np.maximum(pilot - line, 0.0)
    x = np.clip((forced - p[check + "cracking_pressure"]) / p[check + "opening_range"], 0.0, 1.0)
    passed = p[check + "conductance"] * x**2 * (3.0 - 2.0 * x) * (line - pressure)
    beyond = np.maximum(pressure - line - p["drive.relief.cracking_pressure"], 0.0)
    found: Rows = passed - p["drive.relief.gradient"] * beyond
    return found
