"""Where the time of a closed loop goes: parts left out one by one, and what the processor can do at best."""

import ctypes
import json
import re
import statistics
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import isa

__all__ = ["PARTS", "profile"]

SCENARIO, PERIOD = "paper/sine-tsmc", 1e-5
SAMPLES, LANE_SAMPLES = 100_000, 5_000
SPREAD = {"plant.bulk_modulus": 0.3, "plant.mass": 0.3, "plant.damping": 0.5, "plant.leakage": 0.5}
REPEATS = 100_000  # of what the processor is timed with

Section = dict[str, Any]


def product(x: float, y: float) -> float:
    return x * y


def half(x: float) -> float:
    return 0.5 * x


def without_power() -> None:
    exchange("power", "power", product)
    exchange("power", "signed_power", product)


def without_tanh() -> None:
    exchange("hyperbolic", "tanh", half)


def without_root() -> None:
    exchange("basic", "sqrt", half)


def without_sine() -> None:
    exchange("circular", "sin", half)
    exchange("circular", "cos", half)


def without_metrics() -> None:
    from hydroservo.runs import run

    run.monitors_of = lambda _loop: {}


def without_integration() -> None:
    from hydroservo.machine.integrators import RK4

    RK4.substep = stopped  # type: ignore[method-assign, assignment]


def stopped(_self: Any, _system: Any, _t: float, x: Any, _u: float, _h: float) -> Any:
    return x


PARTS: dict[str, Callable[[], None]] = {
    "nothing": lambda: None,
    "the five powers": without_power,
    "the two hyperbolic tangents": without_tanh,
    "the square roots": without_root,
    "the sines of demand and load": without_sine,
    "the running metrics": without_metrics,
    "the Runge-Kutta step": without_integration,
}


def exchange(module: str, name: str, function: Callable[..., Any]) -> None:
    """Puts a cheap function in the place of one of ops, before anything is compiled."""
    from hydroservo import ops

    place = sys.modules[f"hydroservo.core.ops.{module}"]
    function.__module__ = place.__name__  # which its callers in ops may call
    setattr(place, name, function)
    setattr(ops, name, function)


def profile(rounds: int) -> Section:
    """Nanoseconds of a sample period, alone and in lanes, without each part; and the processor's limits."""
    found: dict[str, list[Section]] = {part: [] for part in PARTS}
    for _ in range(rounds):
        for part in PARTS:
            found[part].append(in_process(part))
    parts = {
        part: {kind: statistics.median(one[kind] for one in measured) for kind in ("single", "lanes")}
        for part, measured in found.items()
    }
    return {"parts": parts, "operations": found["nothing"][0]["operations"], "limits": limits(rounds)}


def in_process(part: str) -> Section:
    """What :func:`measured` finds in a process whose kernels are its own."""
    with tempfile.TemporaryDirectory() as cache:
        command = [sys.executable, "-m", "benchmarks.profile", part, cache]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    result: Section = json.loads(done.stdout)
    return result


def measured(part: str) -> Section:
    """Nanoseconds of a sample period without a part, and how many vector operations lanes take."""
    PARTS[part]()
    from hydroservo.engine.kernel import CompiledRun
    from hydroservo.engine.lanes import LANES, CompiledLanes, LaneGroup
    from hydroservo.runs.fitting import first_state
    from hydroservo.runs.kernels import recording_of, run_spec
    from hydroservo.runs.run import runnable_loop
    from hydroservo.scenario import load_scenario

    loop = runnable_loop(load_scenario(SCENARIO))
    state = first_state(loop)
    wanted = recording_of(loop, state, ())
    operations = counted()
    run = CompiledRun(run_spec(loop, SAMPLES), wanted, state, strict=False)
    lanes = CompiledLanes(run_spec(loop, LANE_SAMPLES), wanted, state, tuple(SPREAD), strict=False)
    group = LaneGroup(lanes, {path: drawn(loop, path, LANES) for path in SPREAD})
    single = best(lambda: run.advance(0, SAMPLES, PERIOD, SAMPLES, np.zeros((1, 0))), SAMPLES)
    side_by_side = best(lambda: group.advance(0, LANE_SAMPLES, PERIOD), LANE_SAMPLES * LANES)
    return {"single": single, "lanes": side_by_side, "operations": operations[-1]}


def drawn(loop: Any, path: str, runs: int) -> Any:
    from hydroservo.core.block import value_at

    spread = np.random.default_rng(1).uniform(-SPREAD[path], SPREAD[path], runs)
    return value_at(loop, path) * (1.0 + spread)


def best(call: Callable[[], object], samples: int) -> float:
    """Nanoseconds a sample, of the quickest of some calls."""
    from time import perf_counter

    times = []
    for _ in range(15):
        began = perf_counter()
        call()
        times.append(perf_counter() - began)
    return 1e9 * min(times) / samples


def counted() -> list[dict[str, int]]:
    """Will hold the vector operations of the longest loop over lanes of each kernel compiled from now on."""
    from hydroservo.engine import machine_code
    from hydroservo.engine.lanes import LANES

    found: list[dict[str, int]] = []
    make = machine_code.optimise

    def optimise(given: str, triple: str, machine: Any, strict: bool) -> Any:
        module = make(given, triple, machine, strict)
        text = str(machine.emit_assembly(module))
        register, width = ("zmm", 8) if "zmm" in text else ("ymm", 4)
        blocks = [[line for line in block.splitlines() if register in line] for block in text.split("\n.LBB")]
        longest: list[str] = max(blocks, key=len)
        turns = LANES // (width * machine_code.VECTORS)
        found.append({name: turns * count for name, count in Counter(map(kind, longest)).items()})
        return module

    machine_code.optimise = optimise
    return found


def kind(instruction: str) -> str:
    """Which of the processor's limits an instruction counts against."""
    patterns = {"divide": "vdivpd", "root": "vsqrtpd", "multiply_add": "vf[n]?m|vmulpd", "move": "vmov"}
    name, *_ = instruction.split()
    return next((kind for kind, pattern in patterns.items() if re.match(pattern, name)), "other")


def limits(rounds: int) -> dict[str, float]:
    """Nanoseconds of one independent vector operation of each kind."""
    source = Path(__file__).parent / "c" / "limits.c"
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "limits.so"
        flags = [*isa.gcc_flags(), f"-DLANES={isa.lanes()}", "-O3", "-shared", "-fPIC"]
        subprocess.run(["gcc", *flags, "-o", target, source], check=True)  # noqa: S607 - ours, gcc of the path
        library = ctypes.CDLL(str(target))
    found = {}
    for name in ("multiply_add", "divide", "root"):
        function = getattr(library, name)
        function.restype, function.argtypes = ctypes.c_double, [ctypes.c_long]
        found[name] = 1e9 * min(function(REPEATS) for _ in range(5 * rounds))
    return found


def main(arguments: Sequence[str]) -> None:
    import os

    part, cache = arguments
    os.environ["HYDROSERVO_CACHE_DIR"] = cache
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    print(json.dumps(measured(part)))


if __name__ == "__main__":
    main(sys.argv[1:])
