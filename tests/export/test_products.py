"""What leads from a loop to a folder of C, an FMU or a system of them, in one call."""

import re
import zipfile
from pathlib import Path

import pytest

from hydroservo.control.loop import Loop
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.outputs import OutputError
from hydroservo.export import products
from hydroservo.export.products import export_c, export_fmu, export_ssp
from hydroservo.export.unit import Proof
from hydroservo.scenario import load_scenario
from tests.support.needs import needs

pytestmark = pytest.mark.slow  # each builds a library or a program

PROOF = Proof(1, "cc")


@pytest.fixture
def loop() -> Loop:
    return load_scenario("rig/1khz-tsmc-sine", {"simulation.duration": "20 ms"})


def test_a_loop_becomes_c_in_one_call(loop: Loop, tmp_path: Path) -> None:
    needs("cc")
    reports: list[float] = []
    export = export_c(loop, tmp_path / "law", progress=lambda done, _: reports.append(done))
    assert [file.name for file in export.files] == [
        *(f"tsmc_in_valveinversion{end}" for end in (".h", ".c", "_vectors.h", "_replay.c")),
        "Makefile",
        "README.md",
    ]
    assert all(file.is_file() for file in export.files)
    assert export.proof.compiler
    assert reports == sorted(reports)
    title, proof, written = repr(export).splitlines()
    assert title == "TSMC in ValveInversion"
    assert proof.startswith("checked with ")
    assert written.startswith(f"written to {tmp_path / 'law'}: tsmc_in_valveinversion.h, ")


def test_a_name_gives_the_title_and_the_prefix(loop: Loop, tmp_path: Path) -> None:
    unit = export_c(loop, tmp_path, part="demand", name="rig/mine").unit
    assert (unit.title, unit.prefix) == ("Demand of scenario rig/mine", "demand_mine")


def test_a_loop_becomes_an_fmu_in_one_call(loop: Loop, tmp_path: Path) -> None:
    needs("cc")
    export = export_fmu(loop, tmp_path / "axis.fmu", part="machine", version="3")
    assert export.files == (tmp_path / "axis.fmu",)
    with zipfile.ZipFile(tmp_path / "axis.fmu") as archive:
        text = archive.read("modelDescription.xml").decode()
    assert 'fmiVersion="3.0"' in text
    assert re.search(r'stopTime="0\.02"', text)


def test_a_loop_becomes_a_system_in_one_call(loop: Loop, tmp_path: Path) -> None:
    needs("cc")
    exports = export_ssp(loop, tmp_path / "axis.ssp")
    assert [export.unit.part for export in exports] == ["controller", "machine", "demand"]
    assert {export.files for export in exports} == {(tmp_path / "axis.ssp",)}


@pytest.mark.parametrize(
    ("argument", "value", "allowed"),
    [
        ("part", "controler", "must be one of controller, machine, .*; did you mean controller?"),
        ("precision", "half", "must be one of double, single"),
    ],
)
def test_a_word_that_means_nothing(loop, tmp_path, argument, value, allowed):
    with pytest.raises(ParameterError, match=f"{argument} = '{value}': {allowed}"):
        export_c(loop, tmp_path / "law", **{argument: value})
    assert not list(tmp_path.iterdir())


def test_a_version_that_is_none(loop, tmp_path):
    with pytest.raises(ParameterError, match="version = '4': must be one of 2, 3"):
        export_fmu(loop, tmp_path / "law.fmu", version="4")


def test_what_cannot_be_written_is_kept(loop, tmp_path, monkeypatch):
    def full(unit, vectors, folder, proof):
        if folder == tmp_path / "law":
            raise OutputError(f"{folder}: no space left")
        (folder / "law.c").write_text("")
        return [folder / "law.c"]

    monkeypatch.setattr(products, "write_c_project", full)
    monkeypatch.setattr(products, "proven_vectors", lambda *_: (None, PROOF))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with pytest.raises(HydroservoError, match=r"no space left; kept in .*hydroservo-.* instead"):
        export_c(loop, tmp_path / "law")
    assert [file.name for file in tmp_path.glob("hydroservo-*/*")] == ["law.c"]
