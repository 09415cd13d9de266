"""Steps per second of environments of one task: the velocity of the rig's machine at 1 kHz.

``python -m benchmarks.environments NAME COUNT ROUNDS`` measures one of them in a process of its own, and
prints JSON. All take the same ten steps of the classical Runge-Kutta method a sample period, and must come to
the same velocities as ours.
"""

import json
import math
import sys
from collections.abc import Callable
from statistics import median
from time import perf_counter
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from numpy.typing import NDArray

import hydroservo as hs
from benchmarks.laws import PLAIN, Machine, Maths, State, demand, machine_of, machine_rates, rk4, wave
from benchmarks.peers.jax import maths
from hydroservo.core.block import value_at

__all__ = ["NAMES", "measured"]

TASK = "hydroservo/Velocity-v0"
SCENARIO = "rig/1khz-pi-sine"
# Amid the stroke, so that no run leaves it: others know no ends, and would not end the episode there.
NOMINAL = {"uncertainty.scale": 0, "controller.saturation.limit": "0.25 V", "plant.start_position": "39 mm"}
PERIODS = 200  # timed at a time, of an episode of 3000

Actions = NDArray[np.float64]
Step = Callable[[Actions], Any]  # of many runs


class Runs(NamedTuple):
    """Many runs of an environment: what takes them on, and what their velocities [m/s] are then."""

    step: Step
    velocities: Callable[[], NDArray[np.float64]]


class Rig(NamedTuple):
    """The machine with its valve's lag, its sample period and its steps in it."""

    machine: Machine
    lag: float
    limit: float
    period: float
    substeps: int

    def after(self, m: Maths, t: Any, x: State, action: Any) -> State:
        """The state (velocity, hydraulic force, position, opening) a sample period later."""
        c, h = self.machine, self.period / self.substeps
        asked = m.smaller(m.larger(c.valve_gain * self.limit * action, -c.max_opening), c.max_opening)

        def rates(at: Any, y: State) -> State:
            held = c.flow * y[3], m.sign(y[3]) * c.inv_area
            moved = machine_rates(m, c, held, wave(m, c.load_amplitude, c.load_omega, at), y[:3])
            return (*moved, (asked - y[3]) * self.lag)

        for i in range(self.substeps):
            x = rk4(rates, t + i * h, x, h)
        return x

    def seen(self, m: Maths, t: Any, x: State) -> tuple[tuple[Any, ...], Any]:
        """What is observed, in SI units, and the reward for it."""
        r = demand(m, self.machine, t)
        error = (x[0] - r[0]) / self.machine.amplitude
        return (*x[:3], *r), -m.smaller(error * error, 1.0)


def rig() -> Rig:
    """The task in numbers."""
    loop = hs.load_scenario(SCENARIO, NOMINAL)
    lag, limit = 1.0 / float(value_at(loop, "valve.time_constant")), loop.controller.saturation.limit
    return Rig(machine_of(loop, {}), lag, limit, loop.simulation.period, loop.simulation.substeps)


class PlainEnv(gymnasium.Env[NDArray[np.float64], NDArray[np.float64]]):
    """The task in plain Python, one run."""

    def __init__(self) -> None:
        self.rig = rig()
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (6,), np.float64)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float64)

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self.k, self.x = 0, (0.0, 0.0, self.rig.machine.start_position, 0.0)
        return np.array(self.rig.seen(PLAIN, 0.0, self.x)[0]), {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        dt = self.rig.period
        self.x = self.rig.after(PLAIN, self.k * dt, self.x, float(action[0]))
        self.k += 1
        seen, reward = self.rig.seen(PLAIN, self.k * dt, self.x)
        return np.array(seen), reward, False, self.k >= 3000, {}


def ours(count: int) -> Runs:
    """hydroservo's vectorised environment."""
    import hydroservo.gym

    gymnasium.register_envs(hydroservo.gym)
    mode = "vector_entry_point"
    envs: Any = gymnasium.make_vec(TASK, count, mode, scenario=SCENARIO, changes=NOMINAL)
    envs.reset(seed=0)
    return Runs(lambda actions: envs.step(actions[:, np.newaxis]), lambda: envs.task.runs["plant.velocity"])


def plain(count: int, mode: str) -> Runs:
    """Gymnasium's own vectors of the environment in plain Python."""
    kind = {"sync": gymnasium.vector.SyncVectorEnv, "async": gymnasium.vector.AsyncVectorEnv}[mode]
    envs = kind([PlainEnv] * count)
    envs.reset(seed=0)
    last: list[Any] = []

    def step(actions: Actions) -> None:
        last[:] = [envs.step(actions[:, np.newaxis])]

    return Runs(step, lambda: last[0][0][:, 0])


def in_jax(count: int) -> Runs:
    """The task under vmap and jit, its state an array on the processor."""
    m = maths()
    import jax

    own = rig()

    def one(k: Any, x: State, action: Any) -> Any:
        x = own.after(m, k * own.period, x, action)
        return x, own.seen(m, (k + 1) * own.period, x)

    many = jax.jit(jax.vmap(one, in_axes=(None, 0, 0)))
    begin = (0.0, 0.0, own.machine.start_position, 0.0)
    now: dict[str, Any] = {"k": 0, "x": tuple(np.full(count, value) for value in begin)}

    def step(actions: Actions) -> None:
        now["x"], seen = many(float(now["k"]), now["x"], actions)
        now["k"] += 1
        jax.block_until_ready(seen)  # type: ignore[no-untyped-call]

    return Runs(step, lambda: np.asarray(now["x"][0]))


NAMES: dict[str, Callable[[int], Runs]] = {
    "hydroservo": ours,
    "JAX": in_jax,
    "AsyncVectorEnv of plain Python": lambda count: plain(count, "async"),
    "SyncVectorEnv of plain Python": lambda count: plain(count, "sync"),
}


def measured(name: str, count: int, rounds: int) -> dict[str, float]:
    """Steps per second, and the velocity of the first run at the end.

    Args:
        name: of the environment.
        count: how many runs.
        rounds: of so many sample periods, of which the median counts; one before them compiles.
    """
    runs, times = NAMES[name](count), []
    for turn in range(rounds + 1):
        began = perf_counter()
        for k in range(PERIODS):
            runs.step(np.full(count, 0.5 * math.sin(0.05 * (turn * PERIODS + k))))
        times.append(perf_counter() - began)
    return {"rate": count * PERIODS / median(times[1:]), "velocity": float(runs.velocities()[0])}


if __name__ == "__main__":
    print(json.dumps(measured(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))))
