"""Small exports in C, and the folders that are written of them."""

import subprocess
from pathlib import Path
from typing import Any

from hydroservo.control.loop import Loop
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import CModule, Part
from hydroservo.export.vectors import Vectors, make_vectors
from hydroservo.scenario import load_scenario
from tests.support.needs import needs

TITLE = "PI of scenario paper/sine-pi"


def scenario(**changes: object) -> Loop:
    """The paper's PI; 5001 samples."""
    dotted = {name.replace("__", "."): value for name, value in changes.items()}
    return load_scenario("paper/sine-pi", {"simulation.duration": 0.05} | dotted)


def unit(loop: Loop, part: Part = Part.CONTROLLER, **options: Any) -> tuple[CModule, Vectors]:
    """An export and its test vectors."""
    made = exported_unit(loop, part, **{"prefix": "law", "title": TITLE} | options)
    return made, make_vectors(loop, part, made)


def make(folder: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(["make", "-C", folder, *words], capture_output=True, text=True, check=False)


def check(folder: Path, compiler: str = "gcc") -> "subprocess.CompletedProcess[str]":
    needs("make", compiler)
    return make(folder, "check", f"CC={compiler}", "CFLAGS=-O2 -Werror")
