"""The folder of an export in C: it builds without a warning, its replay passes, its README is true."""

import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hydroservo.control.loop import Loop
from hydroservo.core.errors import HydroservoError
from hydroservo.export.c.project import c_project, memory_size, proof_of, write_c_project
from hydroservo.export.texts import WIDTH
from hydroservo.export.unit import CModule, Part, Precision, Signal
from hydroservo.export.vectors import Vectors
from tests.support.export.projects import TITLE, check, make, unit
from tests.support.needs import needs
from tools.targets.boards import BOARDS, COMPILER, Board
from tools.targets.sources import FOLDER as TARGET

pytestmark = pytest.mark.slow  # each builds a library or a program

FILES = ["law.h", "law.c", "law_vectors.h", "law_replay.c", "Makefile", "README.md"]
SEMIHOSTING = "-semihosting-config enable=on,target=native"
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]

each_compiler = pytest.mark.parametrize("compiler", ["gcc", "clang"])


@pytest.fixture
def folder(law: tuple[CModule, Vectors], tmp_path: Path) -> Path:
    write_c_project(*law, tmp_path)
    return tmp_path


def passes(folder: Path, line: str, compiler: str = "gcc") -> bool:
    done = check(folder, compiler)
    return (done.returncode, done.stderr) == (0, "") and f"\n{line}\n" in done.stdout


# --- the replay


@each_compiler
def test_the_replay_is_bit_for_bit_and_without_a_warning(folder: Path, compiler: str) -> None:
    assert passes(folder, "law: 542 of 542 samples bit for bit", compiler)


@pytest.mark.parametrize("part", [Part.MACHINE, Part.EQUATIONS, Part.LOOP])
def test_machines_and_loops_are_replayed_too(loop: Loop, tmp_path: Path, part: Part) -> None:
    write_c_project(*unit(loop, part), tmp_path)
    assert "control_interrupt" not in (tmp_path / "README.md").read_text()
    assert passes(tmp_path, "law: 500 of 500 samples bit for bit")


def test_parameters_may_be_inlined(loop: Loop, tmp_path: Path) -> None:
    write_c_project(*unit(loop, inlined=True), tmp_path)
    text = (tmp_path / "README.md").read_text()
    assert "| 24 bytes of state for each instance |" in text
    assert "law_defaults" not in text
    assert "| `controller.integral_gain` | 10.0 | V/m | integral gain k_i |" in text
    assert passes(tmp_path, "law: 542 of 542 samples bit for bit")


@each_compiler
@pytest.mark.parametrize(("row", "column", "name"), [(17, 1, "integral"), (541, 2, "unlimited")])
def test_one_bit_of_one_number_is_found(
    law: tuple[CModule, Vectors], tmp_path: Path, compiler: str, row: int, column: int, name: str
) -> None:
    made, vectors = law
    true = vectors.expected[row, column]
    wrong = vectors.expected.copy()
    wrong[row, column] = np.nextafter(true, 1.0)
    write_c_project(made, vectors._replace(expected=wrong), tmp_path)
    done = check(tmp_path, compiler)
    assert done.returncode != 0
    assert f"law: sample {row + 1} of 542: controller.{name} [V]\n" in done.stdout
    assert f"= {true:.17g}\n" in done.stdout
    assert f"= {wrong[row, column]:.17g}\n" in done.stdout
    assert "bit for bit" not in done.stdout


@pytest.mark.parametrize(("found", "expected"), [("0.0", "-0x0.0p+0"), ("0.0", "NAN"), ("NAN", "0x0.0p+0")])
def test_signs_of_zeros_and_nan_count(folder: Path, found: str, expected: str) -> None:
    change(folder / "law_vectors.h", r"(law_start.* = \{)[^,]*", rf"\g<1>{expected}")
    change(folder / "law.c", r"(pi_init.*\n.*\.u = )0\.0", rf"\g<1>{found}")
    done = check(folder)
    assert done.returncode != 0
    assert "law: sample 0 of 542: controller.u [V]\n" in done.stdout


def test_what_step_returns_is_the_states_command(folder: Path) -> None:
    change(folder / "law.c", r"return state->u;", "return state->u + 1.0;")
    done = check(folder)
    assert done.returncode != 0
    assert "law: sample 1: what step returned is not the state's command" in done.stdout


def change(file: Path, old: str, new: str) -> None:
    text, count = re.subn(old, new, file.read_text())
    assert count == 1
    file.write_text(text)


@pytest.mark.nightly
def test_a_cross_compiler_builds_the_code(folder: Path) -> None:
    needs("make", "arm-none-eabi-gcc")
    lines = re.findall(r"^make law\.o CC=(\S+) CFLAGS='(.*)'$", (folder / "README.md").read_text(), re.M)
    assert len(lines) == 2
    for compiler, flags in lines:
        done = make(folder, "law.o", f"CC={compiler}", f"CFLAGS={flags} -Werror")
        assert (done.returncode, done.stderr) == (0, "")
        words = [compiler, *flags.split(), *STRICT, "-c", "law_replay.c"]
        subprocess.run(words, cwd=folder, check=True)


@pytest.mark.nightly
@pytest.mark.parametrize("board", BOARDS, ids=lambda board: board.name)
def test_the_replay_runs_on_an_emulated_target(folder: Path, board: Board) -> None:
    needs("make", COMPILER, "qemu-system-arm")
    flags = [*board.flags, "--specs=rdimon.specs"]
    subprocess.run(
        [COMPILER, *flags, "-O2", "-c", TARGET / "startup.c", "-o", folder / "start.o"], check=True
    )
    done = make(
        folder,
        "check",
        f"CC={COMPILER}",
        f"CFLAGS=-O2 -Werror {' '.join(flags)}",
        f"LDFLAGS=-nostartfiles -Wl,--script={TARGET / 'target.ld'}",
        "LDLIBS=start.o -lm",
        f"RUN=qemu-system-arm -M {board.machine} -nographic {SEMIHOSTING} -kernel",
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "\nlaw: 542 of 542 samples bit for bit\n" in done.stdout


# --- single precision


@each_compiler
def test_single_precision_states_its_deviation(
    single: tuple[CModule, Vectors], tmp_path: Path, compiler: str
) -> None:
    needs("make", compiler)
    write_c_project(*single, tmp_path, proof_of(*single))
    done = check(tmp_path, compiler)
    assert (done.returncode, done.stderr) == (0, "")
    said = done.stdout[done.stdout.index("law: 500 samples") : done.stdout.index("make: Leaving")]
    text = (tmp_path / "README.md").read_text()
    assert said in text
    assert "\n\n\n" not in text
    relative = {line.split()[2]: float(line.split()[1]) for line in said.splitlines()[2:-1]}
    assert list(relative) == [signal.path for signal in single[0].states]
    assert all(0.0 < value < 1e-4 for value in relative.values())
    beyond = make(tmp_path, "check", "CFLAGS=-DLAW_TOLERANCE=1e-9")
    assert beyond.returncode != 0
    assert "law: 0 of 3 numbers within 1e-09 of their largest value" in beyond.stdout


@pytest.mark.parametrize(
    ("compiler", "why"),
    [
        ("false", "the C compiler false fails: exit status 1"),
        ("true", "the C compiler true writes no file"),
    ],
)
def test_a_compiler_that_does_not_work_measures_nothing_and_the_readme_says_why(
    compiler: str, why: str, single: tuple[CModule, Vectors], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", compiler)
    text = " ".join(c_project(*single, proof_of(*single))["README.md"].split())
    assert f"It was not measured when this folder was written: {why}. `make check` does it." in text


@pytest.mark.nightly
def test_a_program_for_another_machine_measures_nothing(
    single: tuple[CModule, Vectors], monkeypatch: pytest.MonkeyPatch
) -> None:
    needs("arm-none-eabi-gcc")
    monkeypatch.setenv("CC", "arm-none-eabi-gcc --specs=nosys.specs -mcpu=cortex-m7")
    text = " ".join(c_project(*single, proof_of(*single))["README.md"].split())
    assert "when this folder was written: try-compiler cannot be run: Exec format error." in text


# --- the folder


def test_no_line_of_c_is_long(folder: Path) -> None:
    for name in FILES:
        if name.endswith((".c", ".h")):
            assert max(map(len, (folder / name).read_text().splitlines())) <= WIDTH, name


def test_the_same_export_gives_the_same_bytes(loop: Loop, folder: Path) -> None:
    assert {name: (folder / name).read_text() for name in FILES} == c_project(*unit(loop))


def test_other_files_stay_and_strangers_are_not_replaced(
    law: tuple[CModule, Vectors], tmp_path: Path
) -> None:
    (tmp_path / "main.c").write_text("mine")
    assert write_c_project(*law, tmp_path) == [tmp_path / name for name in FILES]
    assert write_c_project(*law, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*FILES, "main.c"])
    assert (tmp_path / "main.c").read_text() == "mine"
    (tmp_path / "Makefile").write_text("all: mine\n")
    (tmp_path / "law.c").unlink()
    with pytest.raises(HydroservoError, match="Makefile: not written by hydroservo"):
        write_c_project(*law, tmp_path)
    assert not (tmp_path / "law.c").exists()


# --- the README


def test_the_readme_tells_what_is_exported(law: tuple[CModule, Vectors], folder: Path) -> None:
    made, text = law[0], (folder / "README.md").read_text()
    assert text.startswith(f"# {TITLE}\n")
    assert "| 24 bytes of state for each instance; 40 bytes of parameters" in text
    for fact in (made.hash, made.version, "| 1e-05 s |", made.scenario):
        assert fact in text
    for signal in made.parameters:
        assert f"| `{signal.place}` | {signal.value!r} | {signal.unit} | {signal.meaning}" in text
    for signal in (*made.states, *(one for argument in made.arguments for one in argument.signals)):
        assert f"| `{signal.place}` | {signal.unit} | {signal.meaning} |" in text
    assert "sample period; set before init |" in text
    assert not re.search(r" \n|\n\n\n", text)


def test_markdown_of_a_meaning_is_escaped(law: tuple[CModule, Vectors]) -> None:
    limit = Signal("controller.limit", "limit", "", "of |s|^a * 2", 1.0)
    text = c_project(law[0]._replace(parameters=(limit,)), law[1])["README.md"]
    assert r"| `limit` | 1.0 | - | of \|s\|^a \* 2 |" in text


@pytest.mark.parametrize("reads_command", [True, False])
@pytest.mark.parametrize("options", [{}, {"inlined": True}, {"precision": Precision.SINGLE}])
def test_the_readmes_example_compiles(
    loop: Loop, tmp_path: Path, reads_command: bool, options: dict[str, Any]
) -> None:
    needs("gcc")
    made, vectors = unit(loop, **options)
    if not reads_command:
        measurement, demand = made.arguments
        made = made._replace(arguments=(measurement._replace(signals=measurement.signals[:1]), demand))
    write_c_project(made, vectors, tmp_path)
    (example,) = re.findall(r"```c\n(.*?)```", (tmp_path / "README.md").read_text(), re.DOTALL)
    assert ("measurement.command = applied;" in example) is reads_command
    (tmp_path / "interrupt.c").write_text(example)
    subprocess.run(["gcc", *STRICT, "-fsyntax-only", tmp_path / "interrupt.c"], check=True)


def test_memory_counts_the_numbers(law: tuple[CModule, Vectors], single: tuple[CModule, Vectors]) -> None:
    assert memory_size(law[0]) == (24, 40)
    assert memory_size(single[0]) == (12, 20)
    assert memory_size(law[0]._replace(inlined=True)) == (24, 0)
