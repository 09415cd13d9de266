"""What is not an FMU that a loop can have, and what a loop with one cannot do: a line each."""

import re
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest

from hydroservo import simulate, simulate_batch
from hydroservo.audits import audit
from hydroservo.control.loop import Loop
from hydroservo.core.errors import HydroservoError, LoopError, ScenarioError
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.linear import linearize
from hydroservo.runs.commanded import SteppedRuns
from hydroservo.scenario import fmus, load_plugin, load_scenario
from tests.support.export.foreign import SPRING, foreign_load, state_space


def changed(path: Path, description: Callable[[str], str], place: str | None = None) -> Path:
    """A copy of the FMU StateSpace with another description, or its binaries elsewhere."""
    with zipfile.ZipFile(state_space()) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                content = description(content.decode()).encode()
            new.writestr(name.replace(fmpy.platform_tuple, place) if place else name, content)
    return path


def without_co_simulation(text: str) -> str:
    return re.sub(r"<CoSimulation.*?/>", "", text, flags=re.DOTALL)


@pytest.mark.parametrize(
    ("description", "place", "said"),
    [
        (without_co_simulation, None, "is an FMU for model exchange alone"),
        (
            lambda text: text.replace("<CoSimulation", '<CoSimulation needsExecutionTool="true"'),
            None,
            "needs the tool that it was exported from",
        ),
        (str, "x86_64-beos", "has no binary for this machine, .*; those in it are for x86_64-beos"),
        (lambda _: "<a", None, "has a modelDescription.xml that cannot be read"),
        (lambda text: text.replace('"3.0"', '"1.0"'), None, "modelDescription.xml that cannot|FMI 1.0"),
    ],
)
def test_an_fmu_that_cannot_run_here_is_said_in_a_line(
    tmp_path: Path, description: Callable[[str], str], place: str | None, said: str
) -> None:
    with pytest.raises(ScenarioError, match=said) as caught:
        load_plugin(changed(tmp_path / "other.fmu", description, place))
    assert "\n" not in str(caught.value)


def test_a_file_that_is_no_fmu_is_said_in_a_line(tmp_path: Path) -> None:
    text, other = tmp_path / "text.fmu", tmp_path / "zip.fmu"
    text.write_text("no archive")
    with zipfile.ZipFile(other, "w") as archive:
        archive.writestr("a.txt", "a")
    for path, said in (
        (text, "it cannot be read as a zip archive"),
        (other, "it has no modelDescription.xml"),
        (tmp_path / "none.fmu", "cannot be read: no such file"),
    ):
        with pytest.raises(ScenarioError, match=said):
            load_plugin(path)


def test_a_scenario_alone_runs_no_native_code(monkeypatch: pytest.MonkeyPatch) -> None:
    file = state_space()
    monkeypatch.setattr(fmus, "allowed_digests", set())
    changes = {"load": {"type": "FMU", "file": str(file), **SPRING}}
    with pytest.raises(ScenarioError, match=r"which no scenario runs by itself; allow it: --plugin"):
        load_scenario("axis/position", changes)
    assert type(load_scenario("axis/position", changes, plugins=[file]).load).__name__ == "FMU"


def spring(**changes: Any) -> dict[str, Any]:
    return {part: {**SPRING[part], **changes.get(part, {})} for part in SPRING}


@pytest.mark.parametrize(
    ("load", "said"),
    [
        ({"file": "none.fmu"}, "load.file: .*there is no such file"),
        ({"file": 3}, "load.file: 3 must be a string"),
        ({"amplitude": 3}, "load.amplitude: unknown key .* one of file, signals, parameters, step"),
        (spring(signals={"torque": "y"}), "load.signals.torque: unknown key"),
        (spring(signals={"force": "yy"}), "'yy' is not a variable of the FMU"),
        (spring(signals={"force": "u[1]"}), "must be an output of real numbers, and is input"),
        (spring(signals={"force": "y[1] [kg]"}), "is in kg and does not convert to N"),
        (spring(signals={"force": "y[3]"}), r"has no y\[3\]: there are 1 numbers in y"),
        (spring(parameters={"D": [1.0]}), "takes 2 numbers for D, and 1 are given"),
        (spring(parameters={"D": [1.0, float("nan")]}), "must be of the FMU's type Float64"),
        (spring(parameters={"m": 2.5}), "must be of the FMU's type UInt64"),
        (
            spring(parameters={"m": 9}),
            "fmi3SetUInt64 returns error, and says: m, n and r are 5 at most",
        ),
        (spring(parameters={"y": [1.0]}), "is not a parameter of the FMU that can be set"),
        (spring(parameters={"u": [1.0, 2.0]}), "is given by a signal"),
        (
            {"parameters": {"m": 2}},
            "name an input of the FMU in signals.position or .*; it has u",
        ),
        ({"signals": {"velocity": "u[1]"}}, "name an output of the FMU in signals.force; it has y"),
        ({**SPRING, "step": "0.3 ms"}, "load.step = 0.0003: must divide the sample period of 0.001 s"),
    ],
)
def test_wrong_tables_are_said_in_a_line(load: dict[str, Any], said: str) -> None:
    with pytest.raises(HydroservoError, match=said) as caught:
        simulate(foreign_load(load))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("done", "said"),
    [
        (linearize, "linearise it"),
        (audit, "audit it"),
        (lambda loop: SteppedRuns(loop, {}, 1), "step it from outside"),
        (lambda loop: exported_unit(loop, Part.MACHINE, prefix="a", title="a"), "write its machine as C"),
    ],
)
def test_what_needs_more_than_steps_is_refused(done: Callable[[Loop], Any], said: str) -> None:
    with pytest.raises(LoopError, match=f"the load is the FMU StateSpace.fmu, .* nothing can {said}"):
        done(foreign_load())


def test_a_device_runs_no_fmu_and_a_law_around_one_is_exported() -> None:
    loop = foreign_load()
    with pytest.raises(LoopError, match="a CUDA device cannot run an FMU"):
        simulate_batch(loop, {"plant.friction.viscous": np.array([1.0])}, cuda=True)
    assert "law_step" in exported_unit(loop, Part.CONTROLLER, prefix="law", title="a").source
