"""FMUs whose binary FMPy builds anew from their sources."""

import re
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.build import build_platform_binary

from hydroservo.export.fmu import FmiVersion, write_fmu
from tests.support.export.fmus import Instance
from tests.support.export.toy import toy
from tests.support.needs import needs

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


@pytest.mark.nightly
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
        text = archive.read("sources/buildDescription.xml").decode()
    assert re.search(r'<SourceFileSet language="C99" compilerOptions="[^"]*-ffp-contract=off[^"]*">', text)
    (macro,) = re.findall(r"<PreprocessorDefinition (.*)/>", text)
    assert macro.startswith('name="FMI3_OVERRIDE_FUNCTION_PREFIX" value="" optional="true"')
