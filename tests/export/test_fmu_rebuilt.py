"""FMUs whose binary FMPy builds anew from their sources."""

import zipfile
from pathlib import Path
from xml.etree import ElementTree as ET

import fmpy
import numpy as np
import pytest
from fmpy.build import build_platform_binary
from fmus import Instance
from toy import toy

from hydroservo.export.fmu import FmiVersion, write_fmu
from needs import needs

READ = ("controller.u", "controller.integral")


def run(folder: Path) -> list[list[float]]:
    """What the law makes of some samples."""
    draws = np.random.default_rng(5)
    rows = []
    with Instance(folder) as one:
        one.begin()
        for k in range(200):
            velocity, demand = draws.uniform(-0.3, 0.3, 2)
            one.set({"measurement.velocity": velocity, "demand.value": demand})
            assert one.step(k * one.period) == 0
            rows.append(one.get(*READ))
    return rows


@pytest.mark.parametrize("version", FmiVersion, ids=lambda version: version.name)
def test_a_binary_of_fmpys_own_has_the_same_bits(version: FmiVersion, tmp_path: Path) -> None:
    needs("cc", "cmake", "make")
    file = write_fmu(toy(), tmp_path / "one.fmu", stop_time=1.0, version=version)
    ours, theirs = (
        Path(fmpy.extract(str(file), unzipdir=str(tmp_path / name))) for name in ("ours", "theirs")
    )
    (binary,) = (path for path in (theirs / "binaries").rglob("*") if path.is_file())
    binary.unlink()
    build = tmp_path / "build"
    build.mkdir()
    build_platform_binary(theirs, build, generator="Unix Makefiles")
    assert binary.exists()
    assert run(theirs) == run(ours)


def test_the_build_description_says_what_the_bits_need(tmp_path: Path) -> None:
    file = write_fmu(toy(), tmp_path / "one.fmu", stop_time=1.0, version=FmiVersion.FMI3)
    with zipfile.ZipFile(file) as archive:
        (sources,) = ET.fromstring(archive.read("sources/buildDescription.xml")).iter("SourceFileSet")
        there = {name.removeprefix("sources/") for name in archive.namelist() if name.endswith(".c")}
    assert sources.get("language") == "C99"
    assert "-ffp-contract=off" in str(sources.get("compilerOptions")).split()
    assert {one.get("name") for one in sources.iter("SourceFile")} == there
    (unprefixed,) = sources.iter("PreprocessorDefinition")
    assert (unprefixed.get("name"), unprefixed.get("optional")) == ("FMI3_OVERRIDE_FUNCTION_PREFIX", "true")
