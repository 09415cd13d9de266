"""Time per simulated second: the machine from the paper's plant to the whole rig, part by part."""

from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np

from benchmarks import isa
from benchmarks.jobs import Job
from benchmarks.machine import described
from benchmarks.worker import Failed, Worker
from hydroservo import Loop
from hydroservo.control.controllers import DAC, PI
from hydroservo.control.holds import DelayedHold
from hydroservo.control.loop import Simulation
from hydroservo.control.references import Sine
from hydroservo.core.block import leaves
from hydroservo.core.roles import Integrator
from hydroservo.engine.lanes import LANES
from hydroservo.machine.integrators import RK4, Rosenbrock
from hydroservo.machine.mechanics import LuGre, OneLinkArm, Stribeck
from hydroservo.machine.oils import AeratedOil
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.sensors import RigSensors
from hydroservo.machine.supplies import GasAccumulator, PumpSupply
from hydroservo.machine.valves import FourEdges, SecondOrderValve
from hydroservo.testing.examples import example

__all__ = ["INTEGRATORS", "loops", "machines"]

PERIOD = 1e-3  # [s] of the controller's samples
INTEGRATORS: dict[str, tuple[Integrator, int]] = {  # and substeps of a sample period
    "RK4, 10 µs": (RK4(), 100),
    "Rosenbrock, 100 µs": (Rosenbrock(), 10),
}
SECONDS, BATCH_SECONDS, BATCH = 4.0, 0.5, 16 * LANES
QUICK = 0.1  # of both times

KINDS = ("single", "batch")

Section = dict[str, Any]
Key = tuple[str, str, str]  # machine, integrator, kind


def loops() -> dict[str, Loop]:
    """A PI at 1 kHz around ever more of a machine; each has what those above it have."""
    loop = example(
        Loop,
        simulation=Simulation(period=PERIOD),
        reference=Sine(amplitude=0.03, frequency=1.0),
        controller=PI(0.3, 30.0),
    )
    found = {"the paper's plant": loop}

    def add(name: str, **parts: Any) -> None:
        nonlocal loop
        loop = loop._replace(**parts)
        found[name] = loop

    edges, cylinder, pump = example(FourEdges), example(Cylinder, start_position=0.02), example(PumpSupply)
    add("two chambers instead", plant=cylinder)
    add("+ four edges on a spool of second order", valve=example(SecondOrderValve, orifice=edges))
    add("+ pump with relief valve and line", supply=pump)
    add("+ Stribeck friction", plant=cylinder._replace(friction=example(Stribeck)))
    cylinder = cylinder._replace(friction=example(LuGre))
    add("+ LuGre friction in its place", plant=cylinder)
    cylinder = cylinder._replace(oil=AeratedOil())
    add("+ air in the oil", plant=cylinder)
    add("+ one-link arm", plant=cylinder._replace(mechanism=example(OneLinkArm)))
    add(
        "+ accumulator and a rig's sensors and electronics",
        supply=pump._replace(accumulator=example(GasAccumulator)),
        sensors=example(RigSensors),
        controller=DAC(loop.controller),
        hold=DelayedHold(0.5 * PERIOD),
    )
    return found


def machines(
    chosen: dict[str, Loop], rounds: int, say: Callable[[str], None], quick: bool = False
) -> Section:
    """Seconds of each machine, alone and in a batch on one core, with each integrator; medians.

    Raises:
        RuntimeError: a machine that cannot be simulated, or one that diverges.
    """
    size = QUICK if quick else 1.0
    jobs = {
        (name, how, kind): job(name, loop, how, kind, size)
        for name, loop in chosen.items()
        for how in INTEGRATORS
        for kind in KINDS
    }
    times: dict[Key, list[float]] = {key: [] for key in jobs}
    worker, order, keys = Worker("hydroservo", 1, "native"), np.random.default_rng(0), list(jobs)
    try:
        for i in range(rounds):
            say(f"machines: round {i + 1} of {rounds}")
            for at in order.permutation(len(keys)):
                times[keys[at]].append(seconds(worker, jobs[keys[at]]))
    finally:
        worker.close()
    rows = [row(name, loop, times, jobs) for name, loop in chosen.items()]
    return {"machine": described() | {"instructions": isa.used("native")}, "rows": rows}


def row(name: str, loop: Loop, times: dict[Key, list[float]], jobs: dict[Key, Job]) -> Section:
    """A machine with its seconds per simulated second, by integrator and kind."""

    def found(how: str, kind: str) -> float:
        return median(times[name, how, kind]) / simulated(jobs[name, how, kind])

    return {
        "name": name,
        "states": sum(1 for _ in leaves(loop.machine(loop.init()))),
        "seconds": {how: {kind: found(how, kind) for kind in KINDS} for how in INTEGRATORS},
    }


def job(name: str, loop: Loop, how: str, kind: str, size: float) -> Job:
    """One machine to be simulated with one integrator, once or with valve gains of its own in each run."""
    integrator, substeps = INTEGRATORS[how]
    duration = PERIOD * round(size * (SECONDS if kind == "single" else BATCH_SECONDS) / PERIOD)
    simulation = loop.simulation._replace(
        duration=duration, record_period=PERIOD, integrator=integrator, substeps=substeps
    )
    gains = loop.valve.gain * np.linspace(0.9, 1.1, BATCH)
    varied = {} if kind == "single" else {"valve.gain": gains}
    return Job(kind, f"{name}, {how}", loop._replace(simulation=simulation), varied)


def simulated(job: Job) -> float:
    """Seconds of all runs together [s]."""
    return job.runs * job.loop.simulation.duration


def seconds(worker: Worker, job: Job) -> float:
    """What a job takes once it is compiled."""
    first = worker.prepare(job)
    if isinstance(first, Failed):
        raise RuntimeError(f"{job.title}: {first.reason}")
    if first.result["diverged"].any():
        raise RuntimeError(f"{job.title}: a run diverged")
    return worker.seconds()
