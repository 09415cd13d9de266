"""Kernels for arm64 have vectors of NEON or SVE and, run by an emulator, the bits of this processor."""

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from hydroservo import Loop, load_scenario, simulate
from hydroservo.core.block import value_at
from hydroservo.runs.batch import simulate_batch
from tests.support.arm64 import Arm64Kernel, kernels_for_arm64
from tests.support.digests import digest
from tests.support.export.emulators import run
from tests.support.needs import needs

pytestmark = pytest.mark.nightly

VARIED = {
    "axis/pump-controlled": "plant.mechanism.mass",
    "laws/mpc-sine": "plant.mass",
    "paper/sine-tsmc": "plant.bulk_modulus",
    "rig/excavator-link": "plant.mechanism.payload",
    "rig/noisy-1khz-tsmc-sine": "plant.mass",
}
MOVES_AT_ONCE = {"axis/pump-controlled": {"reference.time": "0 s"}}  # where it waits longer than a run lasts
RUNS = 40  # a group of lanes and a part of one
VECTORS = {
    "generic": ("+neon", re.compile(r"\tf(add|mul|div|sub)\tv\d+\.2d")),
    "neoverse-v1": ("+neon,+sve", re.compile(r"\tf(add|mul|div|sub)\tz\d+\.d")),
}
FUSED = re.compile(r"\tfn?m(add|sub|la|ls|ad|sb)\t")


@pytest.fixture(params=VECTORS)
def cpu(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture
def made(cpu: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Arm64Kernel]:
    """The kernels that are made for arm64."""
    return kernels_for_arm64(monkeypatch, tmp_path, cpu, VECTORS[cpu][0])


def single_run(scenario: str, strict: bool = True) -> xr.Dataset:
    return simulate(short(scenario), strict=strict)


def batch(scenario: str, strict: bool = True) -> xr.Dataset:
    loop, path = short(scenario), VARIED[scenario]
    values = value_at(loop, path) * np.linspace(0.9, 1.1, RUNS)
    return simulate_batch(loop, {path: values}, strict=strict, threads=1)


def short(scenario: str) -> Loop:
    return load_scenario(scenario, {"simulation.duration": "0.1 s", **MOVES_AT_ONCE.get(scenario, {})})


def bits(data: xr.Dataset) -> dict[str, str]:
    return {str(name): digest(one.values) for name, one in data.variables.items() if name != "diverged_by"}


def loops(made: list[Arm64Kernel]) -> list[Arm64Kernel]:
    """The kernels that run a loop; others ask a block for its rates or its demands."""
    return [one for one in made if one.name == "advance"]


def assembly(kernel: Arm64Kernel) -> str:
    needs("aarch64-linux-gnu-objdump")
    return run(kernel.folder, "aarch64-linux-gnu-objdump", "--disassemble", kernel.object.name)


@pytest.mark.parametrize("scenario", VARIED)
@pytest.mark.parametrize("made_by", [single_run, batch])
def test_strict_kernels_give_the_bits_of_this_processor(made_by, scenario, made, monkeypatch):
    found = made_by(scenario)
    assert len(loops(made)) == 1
    monkeypatch.undo()
    assert bits(found) == bits(made_by(scenario))


def test_lanes_are_in_vectors(cpu, made):
    batch("rig/noisy-1khz-tsmc-sine")
    batch("rig/noisy-1khz-tsmc-sine", strict=False)
    strict, default = map(assembly, loops(made))
    assert len(VECTORS[cpu][1].findall(strict)) > 100
    assert not FUSED.search(strict)
    assert FUSED.search(default)
