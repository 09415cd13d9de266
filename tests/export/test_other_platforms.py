"""Binaries of cross compilers, run by emulators: they give the bits of this machine and of plain Python."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import fmpy
import numpy as np
import pytest

from hydroservo.export.c.project import write_c_project
from hydroservo.export.compilers import Platform, this_platform
from hydroservo.export.fmu import FmiVersion, write_fmu
from hydroservo.export.fmu.contents import Files, fmu_files
from hydroservo.export.fmu.variables import VariableKind, variables_of
from hydroservo.export.fmu.write import library_place
from hydroservo.export.unit import Part
from hydroservo.export.vectors import Vectors
from tests.support.export import DRIVERS
from tests.support.export.agreement import same_bits
from tests.support.export.cases import Case, rows_of, unit_of, vectors_of
from tests.support.export.emulators import EMULATED, Emulated, run, wine_surroundings
from tests.support.export.exchanges import equations
from tests.support.export.fmus import mass
from tests.support.export.toy import toy
from tests.support.needs import needs
from tools.targets.sources import Rows

pytestmark = pytest.mark.nightly

FMUS = (
    (Case("rig/excavator-link"), FmiVersion.FMI2),
    (Case("rig/excavator-link", Part.MACHINE), FmiVersion.FMI3),
    (Case("rig/excavator-link", Part.LOOP), FmiVersion.FMI2),
    (Case("rig/noisy-1khz-tsmc-sine", Part.LOOP), FmiVersion.FMI3),
)
REPLAYED = Case("rig/noisy-1khz-tsmc-sine", Part.LOOP)
SAMPLES = 500
WRONG = "a step of .* s is not a whole multiple of the sample period of .* s"
SYSTEM = re.compile(
    r"(KERNEL32|msvcrt|ucrtbase|api-ms-win-crt-[\w-]+)\.dll|(libc|libm)\.so\.6|ld-linux-aarch64\.so\.1"
)

each_fmu = pytest.mark.parametrize(
    "fmu", FMUS, indirect=True, ids=lambda one: f"{one[0].scenario}-{one[0].part}-FMI{one[1]}"
)
each_emulated = pytest.mark.parametrize("emulated", EMULATED, ids=lambda one: one.platform.value)


@pytest.fixture(scope="module", autouse=True)
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Where all that is compiled here is run."""
    folder = tmp_path_factory.mktemp("platforms")
    with pytest.MonkeyPatch.context() as patch:
        for name, value in wine_surroundings(folder / "wine").items():
            patch.setenv(name, value)
        yield folder


class Built(NamedTuple):
    """An FMU for this platform and all that are emulated, unpacked; and what its binary for this one does."""

    case: Case
    version: FmiVersion
    folder: Path
    lines: list[str]


@pytest.fixture(scope="module")
def fmu(request: pytest.FixtureRequest, place: Path) -> Built:
    case, version = request.param
    needs("gcc", *(one.compiler for one in EMULATED))
    file = place / f"{request.param_index}.fmu"
    here = this_platform()
    platforms = [here, *(one.platform for one in EMULATED)]
    write_fmu(unit_of(case), file, stop_time=1.0, version=version, platforms=platforms)
    folder = Path(fmpy.extract(str(file), unzipdir=str(file.with_suffix(""))))
    built = Built(case, version, folder, [])
    return built._replace(lines=stepped(built, here, "gcc"))


def stepped(fmu: Built, platform: Platform, compiler: str, *emulator: str) -> list[str]:
    """What the runner prints of the FMU's binary for a platform, line by line."""
    place = fmu.folder.parent
    program = runner(place, fmu, platform, compiler)
    token = fmpy.read_model_description(fmu.folder).guid
    library = f"./{fmu.folder.name}/{library_place(fmu.version, 'unit', platform)}"
    return run(place, *emulator, program, library, token, given=rows(fmu)).splitlines()


def runner(place: Path, fmu: Built, platform: Platform, compiler: str) -> str:
    """The program that steps FMUs of a version on a platform."""
    program = f"./runner{fmu.version}-{platform}.exe"
    if not (place / program).exists():
        headers = fmu.folder / "sources" / "include"
        options = [] if platform is Platform.X86_64_WINDOWS else ["-ldl"]
        words = [f"-DFMI={fmu.version}", f"-I{headers}", str(DRIVERS / "fmu_runner.c"), "-o", program]
        run(place, compiler, "-std=gnu99", *words, *options)
    return program


def rows(fmu: Built) -> str:
    """What the runner reads."""
    unit = unit_of(fmu.case)
    inputs = rows_of(unit, SAMPLES)
    variables = variables_of(unit)
    given = [one.reference for one in variables if one.kind is VariableKind.INPUT]
    asked = [one.reference for one in variables if one.kind in (VariableKind.OUTPUT, VariableKind.LOCAL)]
    words = [np.float64(unit.period).view(np.uint64), len(given), len(asked), len(inputs), *given, *asked]
    return "\n".join(f"{int(one):x}" for one in [*words, *inputs.view(np.uint64).ravel()])


def numbers(lines: Sequence[str]) -> Rows:
    return np.array([[int(word, 16) for word in line.split()] for line in lines], np.uint64).view(np.float64)


@each_emulated
@each_fmu
def test_fmus_give_the_bits_of_this_machine(fmu: Built, emulated: Emulated) -> None:
    emulated.need()
    *lines, message, status = stepped(fmu, emulated.platform, emulated.compiler, *emulated.emulator)
    assert len(lines) == 2 * SAMPLES
    assert same_bits(numbers(lines), numbers(fmu.lines[:-2])).all()
    assert [message, status] == fmu.lines[-2:]
    assert re.fullmatch(f"one: 3 logStatusError {WRONG}", message)


@each_emulated
@pytest.mark.parametrize("version", FmiVersion, ids=lambda version: version.name)
def test_steps_saved_states_and_errors(emulated: Emulated, version: FmiVersion, tmp_path: Path) -> None:
    files = fmu_files(mass(), 1.0, version)
    assert driven(emulated, files, f"fmi{version}_driver.c", tmp_path) == ["2 instances, 1000 samples"]


@each_emulated
@pytest.mark.parametrize("version", FmiVersion, ids=lambda version: version.name)
def test_equations(emulated: Emulated, version: FmiVersion, tmp_path: Path) -> None:
    files = fmu_files(equations(), 1.0, version)
    (said,) = driven(emulated, files, f"fmi{version}_exchange_driver.c", tmp_path)
    assert said.startswith("1 instance, 1000 steps, ")


@each_emulated
def test_random_calls_of_a_clock(emulated: Emulated, tmp_path: Path) -> None:
    files = fmu_files(toy(), 1.0, FmiVersion.FMI3, clocked=True)
    assert driven(emulated, files, "clock_driver.c", tmp_path) == ["300000 calls"]


@each_emulated
def test_random_calls_of_equations(emulated: Emulated, tmp_path: Path) -> None:
    files = fmu_files(equations(), 1.0, FmiVersion.FMI3)
    assert driven(emulated, files, "equations_driver.c", tmp_path) == ["300000 calls"]


def driven(emulated: Emulated, files: Files, driver: str, folder: Path) -> list[str]:
    """What a driver prints that is linked with the sources of an FMU."""
    emulated.need()
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    sources = sorted(str(one) for one in (folder / "sources").glob("*.c"))
    words = ("-Isources", "-Isources/include", str(DRIVERS / driver), *sources)
    run(folder, emulated.compiler, "-std=c99", "-O1", *words, "-o", "driver.exe", "-lm")
    return run(folder, *emulated.emulator, "./driver.exe").splitlines()


@each_emulated
@each_fmu
def test_a_library_needs_the_system_alone_and_shows_fmi_alone(fmu: Built, emulated: Emulated) -> None:
    prefix = emulated.compiler.removesuffix("gcc")
    needs(f"{prefix}objdump", f"{prefix}nm")
    library = library_place(fmu.version, "unit", emulated.platform)
    said = run(fmu.folder, f"{prefix}objdump", "-p", library)
    needed = re.findall(r"(?:DLL Name:|NEEDED) +(\S+)", said)
    assert needed
    assert all(SYSTEM.fullmatch(name) for name in needed), needed
    if emulated.platform is Platform.X86_64_WINDOWS:
        shown = set(
            re.findall(r"^\t\[ *\d+\] (\S+)", said.partition("[Ordinal/Name Pointer]")[2], re.MULTILINE)
        )
        assert re.search(r"^Time/Date\t+Thu Jan  1 .*1970", said, re.MULTILINE)
    else:
        lines = run(fmu.folder, f"{prefix}nm", "-D", "--defined-only", library).splitlines()
        shown = {line.split()[-1] for line in lines}
    assert f"fmi{fmu.version}DoStep" in shown
    assert all(name.startswith(f"fmi{fmu.version}") for name in shown)


def replayed(emulated: Emulated, vectors: Vectors, folder: Path) -> str:
    """What the replay prints that is exported beside the code."""
    needs("make")
    emulated.need()
    write_c_project(unit_of(REPLAYED), vectors, folder)
    words = (f"CC={emulated.compiler}", f"RUN={' '.join(emulated.emulator)}", "CFLAGS=-O2 -Werror")
    return run(folder, "make", "check", *words)


@each_emulated
def test_the_replay_passes(emulated: Emulated, tmp_path: Path) -> None:
    vectors = vectors_of(REPLAYED)
    count = len(vectors.expected)
    assert f"unit: {count} of {count} samples bit for bit" in replayed(emulated, vectors, tmp_path)


@each_emulated
def test_a_replay_finds_a_wrong_vector(emulated: Emulated, tmp_path: Path) -> None:
    vectors = vectors_of(REPLAYED)
    wrong = vectors.expected.copy()
    wrong[40, 3] = np.nextafter(wrong[40, 3], np.inf)
    with pytest.raises(AssertionError, match="sample 41 of"):
        replayed(emulated, vectors._replace(expected=wrong), tmp_path)


def test_equal_exports_give_equal_bytes(tmp_path: Path) -> None:
    needs("gcc", *(one.compiler for one in EMULATED))
    platforms = [one.platform for one in EMULATED]
    one, again = (
        write_fmu(mass(), tmp_path / f"{name}.fmu", stop_time=1.0, platforms=platforms) for name in "ab"
    )
    assert one.read_bytes() == again.read_bytes()
