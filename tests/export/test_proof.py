"""What is held against Python before an export is written, and what stops it."""

import re
from pathlib import Path

import pytest

from hydroservo import Loop, LoopError
from hydroservo.core.errors import HydroservoError
from hydroservo.export.c.project import proven_vectors
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.products import proof_line
from hydroservo.export.unit import CModule, Part, Precision, Proof
from hydroservo.export.vectors import Vectors
from hydroservo.scenario import load_scenario
from tests.support.export.small_laws import NAMED, law
from tests.support.needs import needs

pytestmark = pytest.mark.slow  # each builds a library or a program

TEXT = """\
u = y.velocity
if self.gain < 0.0:
    u = 1.0
return LawState(u, 0.0)"""


def unit_of(loop: Loop, part: Part = Part.CONTROLLER, **options: Precision) -> CModule:
    return exported_unit(loop, part, **NAMED | options)


def proven(loop: Loop, unit: CModule, part: Part = Part.CONTROLLER) -> tuple[Vectors, Proof]:
    needs("gcc")
    return proven_vectors(loop, part, unit)


def test_c_that_is_not_what_python_is_is_not_written(tmp_path: Path) -> None:
    loop = law(tmp_path, TEXT)
    unit = unit_of(loop)
    source, count = re.subn(r"= y->velocity", "= y->velocity + 1e-300", unit.source)
    assert count == 1
    with pytest.raises(LoopError, match=r"^nothing is written: the C differs from Python: .*controller\.u"):
        proven(loop, unit._replace(source=source))


def test_c_that_does_not_compile_is_not_written(tmp_path: Path) -> None:
    loop = law(tmp_path, TEXT)
    unit = unit_of(loop)
    with pytest.raises(LoopError, match=r"^nothing is written: the C compiler \S+ fails: .*error"):
        proven(loop, unit._replace(source=unit.source + "\nnp.float64(1.4)\n"))


@pytest.mark.parametrize("part", [Part.MACHINE, Part.LOOP])
def test_machines_and_loops_are_proved_too(part: Part, tmp_path: Path) -> None:
    loop = law(tmp_path, TEXT)
    proof = proven(loop, unit_of(loop, part), part)[1]
    assert proof.samples == 500
    assert proof.compiler


@pytest.mark.parametrize(
    "changes",
    [
        {"sensors.pressure_a.type": "NoPressure", "sensors.pressure_b.type": "NoPressure"},
        {"simulation.duration": "1 ms"},
    ],
)
def test_what_is_not_measured_and_short_runs_are_no_obstacle(changes: dict[str, str]) -> None:
    loop = load_scenario("rig/encoder-pi-sine", changes)
    proof = proven(loop, unit_of(loop))[1]
    assert proof.compiler


@pytest.mark.parametrize("prefix", ["nothing", "replay", "try_compiler", "driver"])
def test_any_name_may_be_the_prefix(prefix: str, tmp_path: Path) -> None:
    loop = law(tmp_path, TEXT)
    unit = exported_unit(loop, Part.CONTROLLER, prefix=prefix, title="a law")
    proof = proven(loop, unit)[1]
    assert proof.unproved == ""


def test_options_of_the_environment_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "gcc -ffast-math")
    loop = law(tmp_path, TEXT)
    with pytest.raises(LoopError, match=r"CC has options, -ffast-math: try without them$"):
        proven(loop, unit_of(loop))


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("no-compiler", "CC names the C compiler no-compiler, which is not found"),
        ("'", "CC = ': No closing quotation"),
    ],
)
def test_a_compiler_that_was_asked_for_and_is_not_there_stops_it(
    command: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", command)
    loop = law(tmp_path, TEXT)
    with pytest.raises(HydroservoError, match=f"^{said}$"):
        proven_vectors(loop, Part.CONTROLLER, unit_of(loop))


def test_without_a_compiler_it_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr("shutil.which", lambda _: None)
    loop = law(tmp_path, TEXT)
    proof = proven_vectors(loop, Part.CONTROLLER, unit_of(loop))[1]
    assert proof_line(proof) == "not checked: no C compiler was found; install gcc or clang, or set CC"


@pytest.mark.parametrize("precision", Precision)
def test_a_proof_takes_one_call_of_the_compiler(
    precision: Precision, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    needs("gcc")
    counting = tmp_path / "counting"
    counting.write_text(f'#!/bin/sh\necho call >> "{tmp_path}/calls"\nexec gcc "$@"\n')
    counting.chmod(0o755)
    monkeypatch.setenv("CC", str(counting))
    loop = law(tmp_path, TEXT)
    proof = proven(loop, unit_of(loop, precision=precision))[1]
    assert (tmp_path / "calls").read_text() == "call\n"
    single = precision is Precision.SINGLE
    assert (proof.samples, proof.compiler) == (500 if single else 542, "counting")
    assert ("controller.u [V]" in proof.deviation) is single
