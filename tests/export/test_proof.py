"""What is held against Python before an export is written, and what stops it."""

import re
import shutil
from pathlib import Path

import pytest

from hydroservo import Loop, LoopError
from hydroservo.errors import HydroservoError
from hydroservo.export.c.project import Proof
from hydroservo.export.c.proof import proven_vectors
from hydroservo.export.c.vectors import Vectors
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.products import proof_line
from hydroservo.export.unit import Part, Precision, Unit
from hydroservo.scenario import load_scenario
from tests.support.export.small_laws import FIRST, NAMED, law
from tests.support.needs import needs

RARE = """\
u = self.gain * y.velocity
if r.second_rate < -1e6:
    u = -u
if s.beside > 200.0 and y.velocity > 0.0:
    u = 2.0 * u
return LawState(u, s.beside + 1.0 if r.value > 0.0 else 0.0)"""
NEVER = """\
u = y.velocity
if self.gain < 0.0:
    u = 1.0
return LawState(u, 0.0)"""


def unit_of(loop: Loop, part: Part = Part.CONTROLLER, **options: Precision) -> Unit:
    return exported_unit(loop, part, **NAMED | options)


def proven(loop: Loop, unit: Unit, part: Part = Part.CONTROLLER) -> tuple[Vectors, Proof]:
    needs("gcc", "gcov")
    return proven_vectors(loop, part, unit)


def test_samples_are_found_that_reach_what_the_closed_loop_does_not(tmp_path: Path) -> None:
    loop = law(tmp_path, RARE)
    vectors, proof = proven(loop, unit_of(loop))
    assert proof.reached == proof.branches > 8
    assert not proof.missed
    assert proof.samples == len(vectors.inputs) > 1000  # beside counts beyond 200
    assert "stretches that reach branches" in vectors.made


def test_what_no_sample_reaches_is_named(tmp_path: Path) -> None:
    loop = law(tmp_path, NEVER)
    unit = unit_of(loop)
    proof = proven(loop, unit)[1]
    assert proof.reached == proof.branches - 1
    (line,) = proof.missed
    assert unit.source.splitlines()[line - 1].strip() == "if (self->gain < 0.0) {"
    said = f"reached, 1 not reached, in line {line} of law.c: Law.step (law.py, line {FIRST - 1})"
    assert said in proof_line(proof, "law")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (r"self->gain \* y->velocity", "self->gain * y->velocity + 1e-300", "controller.u"),
        (r"u = -u", "u = -u - 1.0", "controller.u"),  # which nothing but a search finds
        (r"s->beside \+ 1.0", "s->beside + 2.0", "controller.beside"),
    ],
)
def test_c_that_is_not_what_python_is_is_not_written(tmp_path: Path, old: str, new: str, said: str) -> None:
    loop = law(tmp_path, RARE)
    unit = unit_of(loop)
    source, count = re.subn(old, new, unit.source)
    assert count == 1
    with pytest.raises(LoopError, match=rf"^nothing is written: the C differs from Python: .*{said}"):
        proven(loop, unit._replace(source=source))


def test_c_that_does_not_compile_is_not_written(tmp_path: Path) -> None:
    loop = law(tmp_path, NEVER)
    unit = unit_of(loop)
    with pytest.raises(LoopError, match=r"^nothing is written: the C compiler \S+ fails: .*error"):
        proven(loop, unit._replace(source=unit.source + "\nnp.float64(1.4)\n"))


@pytest.mark.parametrize(("part", "missed"), [(Part.MACHINE, 0), (Part.LOOP, 1)])
def test_machines_and_loops_are_proved_too(part: Part, missed: int, tmp_path: Path) -> None:
    loop = law(tmp_path, NEVER)
    proof = proven(loop, unit_of(loop, part), part)[1]
    assert proof.samples == 500
    assert 0 < proof.reached == proof.branches - missed  # though their load never jumps
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
    assert proof.reached > 0


@pytest.mark.parametrize("prefix", ["nothing", "rows", "count_rows", "replay", "try_compiler", "driver"])
def test_any_name_may_be_the_prefix(prefix: str, tmp_path: Path) -> None:
    loop = law(tmp_path, NEVER)
    unit = exported_unit(loop, Part.CONTROLLER, prefix=prefix, title="a law")
    proof = proven(loop, unit)[1]
    assert (proof.unproved, proof.uncounted) == ("", "")


ENDLESS = """\
u = y.velocity
while u > 1e6:
    u = u + 0.0
if r.second_rate < -1e6:
    u = 1.0
return LawState(u, 0.0)"""


def test_samples_for_which_a_law_does_not_end_are_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hydroservo.export.c.coverage.LONGEST", 0.2)
    monkeypatch.setattr("hydroservo.export.c.vectors.HUGE", 1e5)
    monkeypatch.setattr("hydroservo.export.c.proof.DRAWN", 1)
    loop = law(tmp_path, ENDLESS)
    proof = proven(loop, unit_of(loop))[1]
    assert proof.compiler
    assert proof.uncounted == ""
    assert proof.branches > proof.reached > 0


def test_options_of_the_environment_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "gcc -ffast-math")
    loop = law(tmp_path, NEVER)
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
    loop = law(tmp_path, NEVER)
    with pytest.raises(HydroservoError, match=f"^{said}$"):
        proven_vectors(loop, Part.CONTROLLER, unit_of(loop))


def test_without_a_compiler_it_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr("shutil.which", lambda _: None)
    loop = law(tmp_path, NEVER)
    proof = proven_vectors(loop, Part.CONTROLLER, unit_of(loop))[1]
    said = proof_line(proof, "law")
    assert said.startswith("not checked: no C compiler was found; install gcc or clang, or set CC")


def test_branches_are_counted_beside_clang(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    needs("gcc", "gcov", "clang")
    monkeypatch.setenv("CC", "clang")
    loop = law(tmp_path, NEVER)
    proof = proven_vectors(loop, Part.CONTROLLER, unit_of(loop))[1]
    assert proof.compiler == "clang"
    assert 0 < proof.reached == proof.branches - 1
    found = shutil.which
    monkeypatch.setattr("shutil.which", lambda name: None if name == "gcc" else found(name))
    said = proof_line(proven_vectors(loop, Part.CONTROLLER, unit_of(loop))[1], "law")
    assert said.endswith("; gcov cannot read what clang counts; install gcc beside it")


def test_without_gcov_it_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    needs("gcc")
    found = shutil.which
    monkeypatch.setattr("shutil.which", lambda name: None if name == "gcov" else found(name))
    loop = law(tmp_path, NEVER)
    said = proof_line(proven_vectors(loop, Part.CONTROLLER, unit_of(loop))[1], "law")
    assert re.fullmatch(r"checked with \S+: 542 samples bit for bit; gcov, .*, is not found", said)


def test_single_precision_is_counted_and_not_searched(tmp_path: Path) -> None:
    loop = law(tmp_path, RARE)
    vectors, proof = proven(loop, unit_of(loop, precision=Precision.SINGLE))
    assert (len(vectors.inputs), proof.compiler) == (500, "")
    assert 0 < proof.reached < proof.branches
