"""CUDA C by hand, compiled on the spot: the laws and running metrics of C, a thread a run.

It is what a good programmer of such devices writes: constants formed once, those of all runs in the kernel's
arguments, demand and load computed once for the threads of a block and shared by them, and all samples in one
launch. Powers, roots and tanh are those of NVIDIA's own library.
"""

import ctypes
import shutil
import subprocess
import tempfile
from typing import NamedTuple

import numpy as np

from benchmarks.given import LAW, MACHINE, table
from benchmarks.jobs import Job, Result
from benchmarks.peer import Prepared
from benchmarks.peers.c import METRICS, SOURCES, address

__all__ = ["CudaC"]


class CudaC(NamedTuple):
    """In doubles, or in floats but for times and what depends on them alone."""

    name: str
    single: bool = False

    def available(self) -> str | None:
        return None if shutil.which("nvcc") else "there is no nvcc"

    def fitted(self, job: Job) -> Job | None:
        return job

    def prepare(self, job: Job) -> Prepared:
        library = built(["-DSINGLE"] if self.single else [])
        given = table(job.loop, MACHINE | LAW, job.varied)

        def run() -> Result:
            out = np.empty((job.runs, len(METRICS)))
            problem = library.closed_loop(
                address(given),
                ctypes.c_long(job.runs),
                ctypes.c_long(job.steps + 1),
                ctypes.c_double(job.period),
                address(out),
                ctypes.c_long(len(METRICS)),
            )
            if problem:
                raise RuntimeError(problem.decode())
            return dict(zip(METRICS, out.T, strict=True))

        return Prepared(run)


def built(flags: list[str]) -> ctypes.CDLL:
    """The CUDA C code for the device of this machine as a shared object, loaded; its file is gone again."""
    with tempfile.TemporaryDirectory() as folder:
        target = f"{folder}/loop.so"
        host = ["-Xcompiler", "-fPIC,-Wno-narrowing"]
        command = ["nvcc", "-O3", "-arch=native", "-shared", *host, *flags]
        subprocess.run([*command, SOURCES / "loop.cu", "-o", target], check=True)
        library = ctypes.CDLL(target)
    library.closed_loop.restype = ctypes.c_char_p
    return library
