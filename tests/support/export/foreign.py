"""Loops whose load or machine is an FMU."""

import re
import subprocess
import sys
import zipfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import fmpy

from hydroservo.control.loop import Loop
from hydroservo.export.compilers import compile_file
from hydroservo.scenario import load_scenario

DRIVERS = Path(__file__).parent / "drivers"
STIFFNESS, DAMPING = 20e3, 400.0
SPRING = {  # a StateSpace without states: F = D (x, v)
    "signals": {"position": "u[1]", "velocity": "u[2]", "force": "y[1]"},
    "parameters": {"m": 2, "n": 0, "r": 1, "D": [STIFFNESS, DAMPING]},
}
OPEN_LOOP = {
    "simulation.duration": "0.1 s",
    "simulation.period": "1 ms",
    "simulation.substeps": 8,
    "controls.type": "Command",
    "controller.type": "OpenLoop",
    "reference.type": "Sine",
    "reference.amplitude": "3 V",
    "reference.frequency": "5 Hz",
}


@cache
def state_space() -> Path:
    """An FMU of FMI 3.0 whose inputs, outputs and parameters are arrays, and sizes of these."""
    place, code = Path(folder("StateSpace").name), Path(fmpy.__file__).parent / "c-code"
    library = f"StateSpace{fmpy.sharedLibraryExtension}"
    source = DRIVERS / "state_space.c"
    every = set(re.findall(r"^FMI3_Export \w+ +(\w+);", (code / "fmi3Functions.h").read_text(), re.MULTILINE))
    there = set(re.findall(r"\bfmi3\w+(?=\()", source.read_text()))
    absent = [f"int {name}(void) {{ return 3; }}" for name in sorted(every - there)]  # fmi3Error
    (place / "absent.c").write_text("\n".join(absent))
    words = ["-std=c99", "-shared", "-fPIC", f"-I{code}", str(source), str(place / "absent.c")]
    compile_file(place, words, library)
    with zipfile.ZipFile(place / "StateSpace.fmu", "w") as archive:
        archive.write(DRIVERS / "state_space.xml", "modelDescription.xml")
        archive.write(place / library, f"binaries/{fmpy.platform_tuple}/{library}")
    return place / "StateSpace.fmu"


@cache
def by_python_fmu(package: str, script: Path, model: str) -> Path:
    """What another tool makes an FMU of: the binary of PythonFMU, around a class."""
    place = Path(folder(f"{package} {model}").name)
    words = [
        sys.executable,
        "-m",
        package,
        "build",
        "-f",
        str(script),
        "-d",
        str(place),
        "--no-external-tool",
    ]
    subprocess.run(words, check=True, capture_output=True)
    return place / f"{model}.fmu"


@cache
def folder(_name: str) -> "TemporaryDirectory[str]":
    """A folder for each name, which goes when the process ends."""
    return TemporaryDirectory()


def with_changes(load: Mapping[str, Any], *, plugins: Sequence[Path] = (), **more: Any) -> Loop:
    """A single-rod axis in open loop with a load."""
    allowed = [state_space(), *plugins]
    return load_scenario("axis/position", OPEN_LOOP | {"load": load} | more, plugins=allowed)


def foreign_load(load: Mapping[str, Any] = SPRING, **more: Any) -> Loop:
    """A single-rod axis whose load is a spring and a damper in the FMU StateSpace."""
    return with_changes({"type": "FMU", "file": str(state_space()), **load}, **more)
