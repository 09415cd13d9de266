"""C by hand, compiled on the spot: the same laws and running metrics, constants formed once per run.

In scalars it is what a good C programmer writes first: one run after another, libm, -O3 -march=native. In
vectors, runs go side by side in registers (GCC's vector extension), with libmvec for powers and tanh, single
instructions for roots and choices, and what all runs have in common computed once for them together. Threads
are OpenMP's.
"""

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.given import AXIS, LAW, MACHINE, table
from benchmarks.isa import gcc_flags, lanes, widest
from benchmarks.jobs import Job, Result, end_state
from benchmarks.peer import STEPS, Prepared, cheapest
from hydroservo.core.block import value_at

__all__ = ["Scalar", "Vector"]

SOURCES = Path(__file__).parents[1] / "c"
METRICS = (  # in the order of the function report in c/metrics.h
    "steady_rms_error",
    "rms_error",
    "max_error",
    "steady_max_error",
    "settling_time",
    "overshoot",
    "control_rms",
    "control_total_variation",
    "control_max",
    "estimate_rms_error_1",
    "estimate_rms_error_2",
    "disturbance_rms_1",
    "disturbance_rms_2",
    "disturbance_max_1",
    "disturbance_max_2",
    "position_min",
    "position_max",
)
AXIS_METRICS = (  # in the order of the function report in c/axis.c
    "rms_error",
    "max_error",
    "steady_rms_error",
    "steady_max_error",
    "settling_time",
    "overshoot",
    "control_rms",
    "control_total_variation",
    "control_max",
    "position_min",
    "position_max",
    "pressure_min",
    "pressure_max",
    "low_pressure_time",
)
VECTOR_FLAGS = ("-fno-math-errno", "-fno-trapping-math")
GROUPS, AXIS_GROUPS = 4, 2  # vectors that advance together


class Scalar(NamedTuple):
    """One number at a time."""

    name: str = "C scalar"

    def available(self) -> str | None:
        return no_compiler()

    def fitted(self, job: Job) -> Job | None:
        return job

    def prepare(self, job: Job) -> Prepared:
        library = built(source(job), ["-DLANES=1", "-DGROUPS=1"], ["-lm"])
        if job.on_axis:
            return Prepared(axes(library, job))
        return plant(library, job) if job.plant_only else Prepared(closed_loop(library, job))


class Vector(NamedTuple):
    """Several runs in one vector register."""

    name: str = "C SIMD"

    def available(self) -> str | None:
        return no_compiler() or ("the processor has no AVX2" if widest() == "no AVX2" else None)

    def fitted(self, job: Job) -> Job | None:
        return job if job.varied else None

    def prepare(self, job: Job) -> Prepared:
        groups = AXIS_GROUPS if job.on_axis else GROUPS
        flags = [f"-DLANES={lanes()}", f"-DGROUPS={groups}", *VECTOR_FLAGS]
        library = built(source(job), flags, ["-lmvec", "-lm"])
        run = axes(library, job) if job.on_axis else closed_loop(library, job)
        return Prepared(run, f"{lanes()} runs in a vector")


def no_compiler() -> str | None:
    return None if shutil.which("gcc") else "there is no gcc"


def source(job: Job) -> str:
    return "axis.c" if job.on_axis else "loop.c"


def built(name: str, flags: Sequence[str], libraries: Sequence[str]) -> ctypes.CDLL:
    """The C code as a shared object, loaded; its file is gone again."""
    with tempfile.TemporaryDirectory() as folder:
        target = f"{folder}/loop.so"
        command = ["gcc", "-O3", *gcc_flags(), "-fopenmp", "-shared", "-fPIC", *flags]
        subprocess.run([*command, SOURCES / name, "-o", target, *libraries], check=True)
        return ctypes.CDLL(target)


def address(array: NDArray[np.float64]) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def closed_loop(library: ctypes.CDLL, job: Job) -> Callable[[], Result]:
    given = table(job.loop, MACHINE | LAW, job.varied)

    def run() -> Result:
        out = np.empty((job.runs, len(METRICS)))
        library.closed_loop(
            address(given),
            ctypes.c_long(job.runs),
            ctypes.c_long(job.steps + 1),
            ctypes.c_double(job.period),
            ctypes.c_int(job.threads),
            address(out),
            ctypes.c_long(len(METRICS)),
        )
        return dict(zip(METRICS, out.T, strict=True))

    return run


def axes(library: ctypes.CDLL, job: Job) -> Callable[[], Result]:
    given = table(job.loop, AXIS, job.varied)

    def run() -> Result:
        out = np.empty((job.runs, len(AXIS_METRICS)))
        library.axis(
            address(given),
            ctypes.c_long(job.runs),
            ctypes.c_long(job.steps),
            ctypes.c_double(job.period),
            ctypes.c_long(job.loop.simulation.substeps),
            ctypes.c_int(job.threads),
            address(out),
            ctypes.c_long(len(AXIS_METRICS)),
        )
        return dict(zip(AXIS_METRICS, out.T, strict=True))

    return run


def plant(library: ctypes.CDLL, job: Job) -> Prepared:
    given = np.zeros(len(MACHINE) + len(LAW))
    given[: len(MACHINE)] = table(job.loop, MACHINE, {})[0]
    amplitude, frequency = (value_at(job.loop, f"valve.{name}") for name in ("amplitude", "frequency"))
    duration = job.loop.simulation.duration

    def end(steps: int) -> Result:
        state = np.empty(3)
        library.plant(
            address(given),
            ctypes.c_double(amplitude),
            ctypes.c_double(frequency),
            ctypes.c_long(steps),
            ctypes.c_double(duration / steps),
            address(state),
        )
        return end_state(state)

    steps = cheapest(job.exact, STEPS, end)
    return Prepared(lambda: end(steps), f"RK4, {steps:,} steps")
