"""The C sources of FMUs: strict compilers, sanitizers, and what a binary shows and needs."""

import re
import subprocess
from pathlib import Path

import pytest

from hydroservo.export.compilers import BITS
from hydroservo.export.fmu import FmiVersion
from hydroservo.export.fmu.contents import fmu_files
from hydroservo.export.fmu.write import AS_LIBRARY
from tests.support.export import DRIVERS
from tests.support.export.exchanges import equations
from tests.support.export.fmus import mass
from tests.support.export.toy import toy
from tests.support.needs import needs

pytestmark = pytest.mark.slow  # several compilers for each

FLAGS = ("-std=c99", "-O2", *BITS, *AS_LIBRARY)
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Wstrict-prototypes", "-Werror")
CLOCKED = "clocked"
SANITIZED = ("-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
UNNEEDED = {  # of FMI 2.0, by what an FMU is for
    "toy": "Functions for FMI2 for Model Exchange.*?Functions for FMI2 for Co-Simulation",
    "axis": "Functions for FMI2 for Co-Simulation.*?#ifdef __cplusplus",
}
LIBRARY = re.compile(r"(mem(cpy|set|cmp)|bcmp|str(cmp|len)|calloc|free|sqrt|__\w+_chk|__stack_chk_fail)\b")


@pytest.fixture(scope="module", params=[*FmiVersion, CLOCKED], ids=["FMI2", "FMI3", CLOCKED])
def sources(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The folder of each export's sources; of the controller with a clock, where that is asked for."""
    clocked = request.param == CLOCKED
    version = FmiVersion.FMI3 if clocked else request.param
    found = {}
    for one in (toy(), mass(), equations()):
        folder = tmp_path_factory.mktemp(one.prefix)
        for name, text in fmu_files(one, 1.0, version, clocked and one.command).items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text)
        found[one.prefix] = folder / "sources"
    return found


def tool(name: str) -> str:
    needs(name)
    return name


def run(folder: Path, *command: str) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:4000]
    return done.stdout


def c_files(folder: Path) -> list[str]:
    return sorted(one.name for one in folder.glob("*.c"))


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("prefix", ["toy", "mass", "axis"])
def test_strict_compilers_find_nothing(sources: dict[str, Path], prefix: str, compiler: str) -> None:
    # FMI's own headers are not of this project: -isystem.
    folder = sources[prefix]
    run(folder, tool(compiler), *FLAGS, *STRICT, "-isystem", "include", *c_files(folder), "-o", "strict.so")


@pytest.mark.parametrize("prefix", ["toy", "axis"])
def test_a_binary_shows_fmi_alone_and_needs_little(sources: dict[str, Path], prefix: str) -> None:
    folder = sources[prefix]
    plain = [f"-DFMI{version}_OVERRIDE_FUNCTION_PREFIX" for version in FmiVersion]
    run(folder, tool("gcc"), *FLAGS, *plain, "-Iinclude", *c_files(folder), "-o", "shown.so", "-lm")
    symbols = [line.split()[-2:] for line in run(folder, tool("nm"), "-D", "shown.so").splitlines()]
    shown = {name for kind, name in symbols if kind.isupper() and kind not in "UW"}
    needed = {name for kind, name in symbols if kind == "U"}
    header = next((folder / "include").glob("fmi?Functions.h")).read_text()
    header = re.sub(UNNEEDED[prefix], "", header, flags=re.DOTALL)
    declared = set(re.findall(r"^#define (fmi\d[A-Z]\w+) +fmi\dFullName", header, re.MULTILINE))
    assert shown == declared
    assert all(LIBRARY.match(name) or "snprintf" in name for name in needed), needed


@pytest.mark.nightly
@pytest.mark.parametrize(("prefix", "said"), [("mass", "2 instances, 1000 samples"), ("axis", "1 instance")])
def test_sanitizers_find_nothing(sources: dict[str, Path], prefix: str, said: str, tmp_path: Path) -> None:
    words = ("-O1", *SANITIZED)
    objects = [*compiled(sources[prefix], tmp_path, *words), driver(sources[prefix], tmp_path, *words)]
    run(tmp_path, "gcc", *words, *objects, "-o", "driver", "-lm")
    assert run(tmp_path, "./driver").startswith(said)


def test_two_fmus_fit_into_one_program(sources: dict[str, Path], tmp_path: Path) -> None:
    objects = []
    for prefix, folder in sources.items():
        own = compiled(folder, tmp_path)
        lines = run(tmp_path, tool("nm"), "-g", "--defined-only", *own).splitlines()
        shared = {line.split()[-1] for line in lines if line and not line.endswith(":")}
        assert f"{prefix}_{'equations_update' if prefix == 'axis' else 'steps_take'}" in shared
        assert all(name.startswith(f"{prefix}_") for name in shared), shared
        objects += own
    run(tmp_path, "gcc", *objects, driver(sources["mass"], tmp_path), "-o", "both", "-lm")
    assert run(tmp_path, "./both") == "2 instances, 1000 samples\n"


@pytest.mark.nightly
@pytest.mark.parametrize("sources", [CLOCKED], indirect=True)
def test_random_calls_of_a_clock_are_answered_as_fmi_has_them(
    sources: dict[str, Path], tmp_path: Path
) -> None:
    assert random_calls(sources["toy"], "clock_driver.c", tmp_path) == "300000 calls\n"


@pytest.mark.nightly
@pytest.mark.parametrize("sources", FmiVersion, indirect=True)
def test_random_calls_of_equations_are_answered_as_fmi_has_them(
    sources: dict[str, Path], tmp_path: Path
) -> None:
    assert random_calls(sources["axis"], "equations_driver.c", tmp_path) == "300000 calls\n"


def random_calls(folder: Path, program: str, out: Path) -> str:
    words = ("-O1", *SANITIZED)
    calls = one_object(folder, DRIVERS / program, out / "calls.o", *words)
    run(out, "gcc", *words, *compiled(folder, out, *words), calls, "-o", "calls", "-lm")
    return run(out, "./calls")


def compiled(folder: Path, out: Path, *words: str) -> list[str]:
    """The objects of an FMU's sources."""
    return [
        one_object(folder, folder / name, out / f"{folder.parent.name}_{name}.o", *words)
        for name in c_files(folder)
    ]


def driver(folder: Path, out: Path, *words: str) -> str:
    """The object of the program that runs the machine of the tests, or integrates equations."""
    version = 2 if (folder / "fmi2.c").exists() else 3
    kind = "exchange_driver" if (folder / "equations.c").exists() else "driver"
    return one_object(folder, DRIVERS / f"fmi{version}_{kind}.c", out / "driver.o", *words)


def one_object(folder: Path, source: Path, made: Path, *words: str) -> str:
    run(folder, tool("gcc"), "-std=c99", *words, "-I.", "-Iinclude", "-c", str(source), "-o", str(made))
    return str(made)
