"""The jobs that all contenders do."""

import os
from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchmarks.laws import PLAIN, machine_of, open_loop_rates, start
from benchmarks.programmed_valve import ProgrammedValve
from hydroservo import Loop
from hydroservo.control.controllers import PI
from hydroservo.control.metrics import monitors_of
from hydroservo.control.monitors import Oscillation
from hydroservo.control.references import Ramp
from hydroservo.core.block import value_at
from hydroservo.machine.drives import ValveOnSupply
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.sensors import IdealSensors
from hydroservo.machine.starts import AsBuilt
from hydroservo.runs.run import runnable_loop, with_metrics
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example

__all__ = ["ACCURACY", "Job", "Result", "device_job", "end_state", "jobs"]

WITHIN = "1e-6"
ACCURACY = float(WITHIN)  # of the plant alone at the end, relative
SCENARIO = "paper/sine-tsmc"
AXIS = "axis/position"
Ends = tuple[float, float]
SPREAD: dict[str, Ends] = {  # of the machine over the runs of a batch: the ends of uniform distributions
    "plant.bulk_modulus": (0.7, 1.3),
    "plant.mass": (0.7, 1.3),
    "plant.damping": (0.5, 1.5),
    "plant.leakage": (0.5, 2.0),
}
AXES: dict[str, Ends] = {
    "plant.mechanism.mass": (0.7, 1.3),
    "plant.oil.liquid_bulk_modulus": (0.8, 1.2),
    "plant.friction.viscous": (0.5, 1.5),
    "valve.natural_frequency": (0.9, 1.1),
}

Result = dict[str, NDArray[np.float64]]  # a number for each run, by name


class Job(NamedTuple):
    """Something to compute: one loop, or one with other parameters in each run."""

    name: str
    title: str
    loop: Loop
    varied: dict[str, NDArray[np.float64]]
    threads: int = 1
    exact: Result | None = None  # the answer, where it is known; else contenders are held against each other

    @property
    def plant_only(self) -> bool:
        """True where nothing is fed back."""
        return isinstance(self.loop.valve, ProgrammedValve)

    @property
    def on_axis(self) -> bool:
        """True of the axis under position control, which only hydroservo and C by hand do."""
        return isinstance(self.loop.plant, Cylinder)

    @property
    def runs(self) -> int:
        """How many trajectories."""
        return max((values.size for values in self.varied.values()), default=1)

    @property
    def period(self) -> float:
        """Of the samples [s]."""
        return self.loop.simulation.period

    @property
    def steps(self) -> int:
        """Sample periods of a run."""
        return round(self.loop.simulation.duration / self.period)

    @property
    def work(self) -> int:
        """Samples over all runs; both ends of a run are samples."""
        return self.runs * (self.steps + 1)

    def shortened(self, steps: int, runs: int | None = None) -> "Job":
        """The first so many steps of the first so many runs."""
        simulation = self.loop.simulation._replace(duration=min(steps, self.steps) * self.period)
        varied = {path: values[:runs] for path, values in self.varied.items()}
        return self._replace(loop=self.loop._replace(simulation=simulation), varied=varied)


def jobs(quick: bool = False) -> list[Job]:
    """All jobs; quick ones take a second in all."""
    seconds, steps, (runs, run_steps) = (
        (0.75, 2_000, (40, 500)) if quick else (60.5, 800_000, (1_000, 100_000))
    )
    loop = with_c_metrics(load_scenario(SCENARIO))
    one = Job("J2", f"one closed loop of {steps:,} steps", loop, {}).shortened(steps)
    title = f"{runs:,} closed loops of {run_steps:,} steps"
    many = Job("J3", f"{title}, on one core", loop, draw(loop, runs)).shortened(run_steps)
    cores = len(os.sched_getaffinity(0))
    everywhere = many._replace(name="J3 all", title=f"{title}, on {cores} cores", threads=cores)
    return [plant_alone(loop, seconds), one, many, everywhere, *axes(quick)]


def device_job(quick: bool = False) -> Job:
    """What takes a device to do: as J3, with very many runs."""
    steps, runs = (500, 1_000) if quick else (100_000, 1_000_000)
    loop = load_scenario(SCENARIO)
    title, cores = f"{runs:,} closed loops of {steps:,} steps", len(os.sched_getaffinity(0))
    return Job("J6", title, loop, draw(loop, runs), threads=cores).shortened(steps)


def axes(quick: bool) -> list[Job]:
    """The axis under position control, alone and many side by side."""
    loop, (runs, seconds) = with_c_metrics(axis()), (16, 0.3) if quick else (1_000, 3.0)
    steps = round(seconds / loop.simulation.period) * loop.simulation.substeps
    one = Job("J4", f"{AXIS}, {seconds:g} s in {steps:,} steps", loop, {})
    many = Job(
        "J5", f"{runs:,} of them with machines of their own, on one core", loop, draw(loop, runs, AXES)
    )
    return [job.shortened(round(seconds / job.period)) for job in (one, many)]


def with_c_metrics(loop: Loop) -> Loop:
    """The loop with the metrics that C by hand keeps: all the usual ones but sustained oscillation."""
    kept = {name: one for name, one in monitors_of(loop).items() if not isinstance(one, Oscillation)}
    return with_metrics(loop, kept)


def axis() -> Loop:
    """The scenario's loop, but that nothing in it rounds: one count more or less is a difference of its own.

    It moves along a ramp, and starts from given pressures.
    """
    loop = load_scenario(AXIS)
    start = runnable_loop(loop).init().plant
    plant = loop.plant._replace(start_pressure_a=start.pressure_a, start_pressure_b=start.pressure_b)
    move = Ramp(initial=0.05, final=0.25, rate=0.15, time=0.2)
    return loop._replace(
        plant=plant,
        reference=move,
        drive=ValveOnSupply(),
        sensors=IdealSensors(),
        controller=loop.controller.controller,
        start=AsBuilt(),
    )


def plant_alone(loop: Loop, seconds: float) -> Job:
    """The machine under a smooth command, to a given accuracy in as few steps as a contender needs."""
    simulation = loop.simulation._replace(duration=seconds, period=1e-3)
    valve = ProgrammedValve(orifice=value_at(loop, "valve.orifice"))
    loop = loop._replace(valve=valve, controller=example(PI), simulation=simulation)
    return Job("J1", f"plant alone, {seconds:g} s to {WITHIN}", loop, {}, exact=exact(loop))


@cache
def exact(loop: Loop) -> Result:
    """The state of the plant at the end, by a method of order 8 at a tight tolerance."""
    from scipy.integrate import solve_ivp

    c = machine_of(loop, {})
    done = solve_ivp(
        lambda t, x: open_loop_rates(PLAIN, c, t, x),
        (0.0, loop.simulation.duration),
        start(c)[0],
        method="DOP853",
        rtol=1e-12,
        atol=1e-15,
    )
    return end_state(done.y[:, -1])


def end_state(state: ArrayLike) -> Result:
    """What the plant's state at the end is compared by."""
    names = ("velocity", "hydraulic_force", "position")
    return {name: np.atleast_1d(value) for name, value in zip(names, np.asarray(state), strict=True)}


def draw(loop: Loop, runs: int, spread: Mapping[str, Ends] = SPREAD) -> dict[str, NDArray[np.float64]]:
    """The machine's parameters of each run, from the loop's seed."""
    rng = np.random.default_rng(loop.simulation.seed)
    return {path: value_at(loop, path) * rng.uniform(*ends, runs) for path, ends in spread.items()}
