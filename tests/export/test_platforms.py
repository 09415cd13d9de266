"""The platforms that binaries are for: their names and folders, and what is said where none can be built."""

import zipfile
from pathlib import Path

import pytest

from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.export import compilers
from hydroservo.export.compilers import TOOLCHAINS, platforms_named, this_platform
from hydroservo.export.fmu import FmiVersion, Platform, check_tools, write_fmu
from hydroservo.export.fmu.write import library_place
from tests.support.export.toy import toy
from tests.support.needs import needs

LINUX, ARM, WINDOWS, MAC = (
    Platform.X86_64_LINUX,
    Platform.AARCH64_LINUX,
    Platform.X86_64_WINDOWS,
    Platform.AARCH64_DARWIN,
)


@pytest.mark.parametrize(
    ("system", "machine", "expected"),
    [
        ("linux", "x86_64", LINUX),
        ("linux", "aarch64", ARM),
        ("linux", "i686", Platform.X86_LINUX),
        ("darwin", "arm64", MAC),
        ("darwin", "x86_64", Platform.X86_64_DARWIN),
        ("win32", "AMD64", WINDOWS),
        ("win32", "ARM64", Platform.AARCH64_WINDOWS),
    ],
)
def test_a_machine_has_its_name(
    monkeypatch: pytest.MonkeyPatch, system: str, machine: str, expected: Platform
) -> None:
    monkeypatch.setattr(compilers.sys, "platform", system)
    monkeypatch.setattr(compilers.platform, "machine", lambda: machine)
    assert this_platform() is expected
    assert platforms_named([]) == [expected]


def test_a_machine_without_a_name_builds_for_others_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compilers.platform, "machine", lambda: "vax")
    monkeypatch.setattr(compilers.sys, "platform", "linux")
    with pytest.raises(HydroservoError, match="FMI has no name for this machine, 'vax-linux'"):
        platforms_named([])
    assert platforms_named(["aarch64-linux"]) == [ARM]


def test_each_platform_is_there_once() -> None:
    assert list(TOOLCHAINS) == list(Platform)
    assert platforms_named(["x86_64-windows", "aarch64-linux", "x86_64-windows"]) == [WINDOWS, ARM]


@pytest.mark.parametrize(
    ("platform", "places"),
    [
        (LINUX, ("linux64/law.so", "x86_64-linux/law.so")),
        (WINDOWS, ("win64/law.dll", "x86_64-windows/law.dll")),
        (Platform.X86_64_DARWIN, ("darwin64/law.dylib", "x86_64-darwin/law.dylib")),
        (Platform.X86_LINUX, ("linux32/law.so", "x86-linux/law.so")),
        (Platform.X86_WINDOWS, ("win32/law.dll", "x86-windows/law.dll")),
        # FMI 2.0.4: the names above stand for x86, and others are those of FMI 3.0.
        (ARM, ("aarch64-linux/law.so",) * 2),
        (MAC, ("aarch64-darwin/law.dylib",) * 2),
        (Platform.AARCH64_WINDOWS, ("aarch64-windows/law.dll",) * 2),
    ],
)
def test_binaries_are_where_the_standard_wants_them(platform: Platform, places: tuple[str, str]) -> None:
    assert tuple(library_place(version, "law", platform) for version in FmiVersion) == tuple(
        f"binaries/{place}" for place in places
    )


@pytest.mark.nightly
def test_an_fmu_holds_a_binary_for_each_platform(tmp_path: Path) -> None:
    needs("cc", TOOLCHAINS[ARM].cross, TOOLCHAINS[WINDOWS].cross)
    chosen = (LINUX, ARM, WINDOWS)
    file = write_fmu(toy(), tmp_path / "one.fmu", stop_time=1.0, platforms=chosen)
    with zipfile.ZipFile(file) as archive:
        names = archive.namelist()
        starts = [archive.read(library_place(FmiVersion.FMI2, "toy", one))[:20] for one in chosen]
        licence = archive.read("documentation/licenses/mingw-w64.txt")
    assert len([name for name in names if name.startswith("binaries/")]) == len(chosen)
    assert [starts[0][:4], starts[0][18]] == [b"\x7fELF", 0x3E]  # x86-64
    assert [starts[1][:4], starts[1][18]] == [b"\x7fELF", 0xB7]  # AArch64
    assert starts[2][:2] == b"MZ"
    assert b"w64" in licence.lower()


def elsewhere(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    """This is an x86-64 Linux whose programs are those of a folder."""
    monkeypatch.setattr(compilers.platform, "machine", lambda: "x86_64")
    monkeypatch.setattr(compilers.sys, "platform", "linux")
    monkeypatch.setenv("PATH", str(folder))


@pytest.mark.parametrize(
    ("platform", "said"),
    [
        (
            "aarch64-linux",
            "the C compiler aarch64-linux-gnu-gcc is not found; "
            "for aarch64-linux, on Debian: apt-get install gcc-aarch64-linux-gnu libc6-dev-arm64-cross",
        ),
        (
            "x86_64-windows",
            "the C compiler x86_64-w64-mingw32-gcc is not found; "
            "for x86_64-windows, on Debian: apt-get install gcc-mingw-w64-x86-64",
        ),
        ("aarch64-darwin", "a binary for aarch64-darwin can only be built on such a machine"),
        ("x86-linux", "a binary for x86-linux can only be built on such a machine"),
    ],
)
def test_what_is_missing_is_said_in_a_line(
    platform: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    elsewhere(monkeypatch, tmp_path)
    with pytest.raises(HydroservoError) as caught:
        check_tools([platform])
    assert str(caught.value) == said
    with pytest.raises(HydroservoError) as caught:
        write_fmu(toy(), tmp_path / "one.fmu", stop_time=1.0, platforms=[platform])
    assert str(caught.value) == said
    assert list(tmp_path.iterdir()) == []


def test_a_cross_compiler_without_its_c_library_is_found_out_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tool = tmp_path / "aarch64-linux-gnu-gcc"
    tool.write_text(
        "#!/bin/sh\necho 'trial.c:1:10: fatal error: math.h: No such file or directory' >&2\nexit 1\n"
    )
    tool.chmod(0o755)
    elsewhere(monkeypatch, tmp_path)
    with pytest.raises(HydroservoError, match=r"fails: .*math\.h.*; for aarch64-linux, .* libc6-dev-arm64"):
        check_tools(["aarch64-linux"])


def test_a_name_of_no_platform_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="platforms = 'win64': must be one of x86_64-linux, aarch64-lin"):
        write_fmu(toy(), tmp_path / "one.fmu", stop_time=1.0, platforms=["win64"])
