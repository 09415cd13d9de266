"""FMUs as files: what is in them, that they are valid, and that they run as simulated."""

import math
import re
import zipfile
from importlib import metadata
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from hydroservo.core.errors import HydroservoError
from hydroservo.export import compilers
from hydroservo.export.compilers import this_platform
from hydroservo.export.fmu import FmiVersion, contents, write, write_fmu
from hydroservo.export.fmu.variables import base_unit
from hydroservo.export.fmu.write import library_place
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part, Signal
from hydroservo.scenario import load_scenario
from tests.support.export.fmus import mass
from tests.support.export.toy import toy

EXPORTS = {"pi": toy(), "mass": mass()}


@pytest.fixture(scope="module", params=FmiVersion, ids=lambda version: version.name)
def version(request: pytest.FixtureRequest) -> FmiVersion:
    return request.param


@pytest.fixture(scope="module")
def fmus(version: FmiVersion, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp(version.name)
    return {
        name: write_fmu(one, folder / f"{name}.fmu", stop_time=0.01, version=version)
        for name, one in EXPORTS.items()
    }


def variables(path: Path) -> dict[str, Any]:
    return {one.name: one for one in fmpy.read_model_description(str(path)).modelVariables}


@pytest.mark.parametrize("name", EXPORTS)
def test_fmus_are_valid(fmus: dict[str, Path], name: str) -> None:
    assert validate_fmu(str(fmus[name])) == []
    description = fmpy.read_model_description(str(fmus[name]))
    assert description.modelName == EXPORTS[name].title
    assert EXPORTS[name].hash in description.description
    assert all(one.description for one in description.modelVariables)
    assert float(description.defaultExperiment.stepSize) == EXPORTS[name].period
    assert float(description.defaultExperiment.stopTime) == 0.01


def test_declared_bounds_belong_to_their_ranges(version: FmiVersion, tmp_path: Path) -> None:
    loop = load_scenario("paper/sine-tsmc")
    unit = exported_unit(loop, Part.MACHINE, prefix="machine", title="a machine")
    found = variables(write_fmu(unit, tmp_path / "machine.fmu", stop_time=1.0, version=version))
    bounds = {one.path: (found[one.path].min, found[one.path].max) for one in unit.parameters}
    for one in unit.parameters:
        least, most = bounds[one.path]
        assert least is None or one.least <= float(least)
        assert most is None or float(most) <= one.most
    assert bounds["plant.mass"] == (None, None)  # above 0, which is no bound that can be set
    assert bounds["load.amplitude"] == (None, None)
    assert bounds["plant.damping"] == ("0.0", None)


def test_variables_are_what_may_be_done_with_them(fmus: dict[str, Path]) -> None:
    pi, machine = variables(fmus["pi"]), variables(fmus["mass"])
    kinds = {name: (one.causality, one.variability, one.start) for name, one in (pi | machine).items()}
    assert kinds["controller.integral_gain"] == ("parameter", "tunable", "10.0")
    assert kinds["plant.first"] == ("parameter", "fixed", "0.25")
    assert kinds["period"] == ("local", "constant", "1e-05")
    assert kinds["simulation.period"] == ("local", "constant", "0.001")
    assert kinds["demand.value"] == ("input", "discrete", "0.0")
    assert kinds["controller.u"] == ("output", "discrete", None)
    assert kinds["controller.unlimited"] == ("local", "discrete", None)
    assert kinds["plant.velocity"] == ("output", "continuous", None)
    assert kinds["sensors.before"] == ("output", "discrete", None)
    assert kinds["time"] == ("independent", "continuous", None)
    assert machine["plant.growth"].description == "factor < 1 & from sample to sample"
    assert (machine["plant.growth"].unit, machine["plant.first"].unit) == (None, "m/s")


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ("m/s", {"m": 1, "s": -1}),
        ("Pa", {"kg": 1, "m": -1, "s": -2}),
        ("m^3/(s Pa)", {"kg": -1, "m": 4, "s": 1}),
        ("V s/m", {"kg": 1, "m": 1, "s": -2, "A": -1}),
        ("rad/s", {"rad": 1, "s": -1}),
        ("Hz", {"rad": 1, "s": -1, "factor": 2.0 * math.pi}),
        ("mm", {"m": 1, "factor": 0.001}),
        ("m^(2/7)/s^(9/7)", None),
        ("furlongs per", None),
    ],
)
def test_units_in_base_units(unit: str, expected: dict[str, float] | None) -> None:
    found = base_unit(unit)
    assert found == (pytest.approx(expected, rel=1e-15) if expected else None)


def test_a_command_depends_on_all_inputs_at_once(fmus: dict[str, Path]) -> None:
    description = fmpy.read_model_description(str(fmus["pi"]))
    inputs = ["measurement.velocity", "demand.value"]
    (output,), (initial,) = description.outputs, description.initialUnknowns
    assert output.variable.name == initial.variable.name == "controller.u"
    assert [known.name for known in output.dependencies] == inputs
    assert [known.name for known in initial.dependencies][-2:] == inputs


def test_outputs_of_a_machine_depend_on_no_input_at_once(fmus: dict[str, Path]) -> None:
    description = fmpy.read_model_description(str(fmus["mass"]))
    assert [one.dependencies for one in description.outputs] == [[], [], []]
    for one in description.initialUnknowns:
        assert [known.name for known in one.dependencies] == ["plant.growth", "plant.first"]


def test_a_simulation_equals_python_bit_for_bit(fmus: dict[str, Path]) -> None:
    draws = np.random.default_rng(3)
    names = ["time", "measurement.velocity", "demand.value"]
    rows = [(k * 1e-5, *draws.uniform(-0.3, 0.3, 2)) for k in range(501)]
    signals = np.array(rows, dtype=[(name, float) for name in names])
    result = fmpy.simulate_fmu(
        str(fmus["pi"]),
        stop_time=5e-3,
        start_values={"controller.proportional_gain": 40.0, "controller.saturation.limit": 5.0},
        input=signals,
        output=["controller.u", "controller.integral"],
    )
    integral, expected = 0.0, []
    for _, velocity, demand in rows[:-1]:
        error = demand - velocity
        integral = integral + 1e-5 * (10.0 * error)
        expected.append((max(-5.0, min(5.0, 40.0 * error + integral)), integral))
    assert 5.0 in {abs(u) for u, _ in expected}
    found = list(zip(result["controller.u"], result["controller.integral"], strict=True))
    assert found == expected[:1] + expected  # the first inputs are answered in the initialization already


def test_a_file_holds_all_that_it_needs(fmus: dict[str, Path], version: FmiVersion) -> None:
    with zipfile.ZipFile(fmus["pi"]) as archive:
        names = set(archive.namelist())
        page = archive.read("documentation/index.html").decode()
        licences = archive.read("documentation/licenses/license.txt").decode()
        licences += archive.read("documentation/licenses/fmpy.txt").decode()
        scenario = archive.read("documentation/scenario.toml").decode()
        assert archive.testzip() is None
    headers = {name for name in names if name.startswith("sources/include/")}
    assert headers == {
        f"sources/include/{name}" for name in contents.interface_of(version, Part.MACHINE).headers
    }
    assert {"sources/toy.c", "sources/toy.h", "sources/model.c", f"sources/fmi{version}.c"} < names
    assert [name for name in names if name.startswith("binaries/")] == [
        library_place(version, "toy", this_platform())
    ]
    assert all(name in page for name in variables(fmus["pi"]))
    assert "hydroservo developers" in licences
    assert "Modelica Association" in licences
    assert scenario == toy().scenario


def test_what_a_page_shows_is_escaped(fmus: dict[str, Path]) -> None:
    with zipfile.ZipFile(fmus["mass"]) as archive:
        page = archive.read("documentation/index.html").decode()
    assert "a &lt; b &amp; c" in page
    assert "&lt;Loop&gt;" in page


def test_equal_exports_give_equal_bytes_and_others_other_tokens(tmp_path: Path) -> None:
    one, again = (write_fmu(toy(), tmp_path / f"{i}.fmu", stop_time=1.0) for i in "ab")
    assert one.read_bytes() == again.read_bytes()
    source = toy().source.replace("10.0", "11.0")
    other = write_fmu(toy()._replace(source=source), tmp_path / "c.fmu", stop_time=1.0)
    tokens = {fmpy.read_model_description(str(path)).guid for path in (one, again, other)}
    assert len(tokens) == 2


@pytest.mark.parametrize(
    ("changes", "file", "stop", "said"),
    [
        ({}, "one.zip", 1.0, "its name must end in .fmu"),
        ({"real": "float"}, "one.fmu", 1.0, "precision = 'float': an FMU is in double precision"),
        ({"inlined": True}, "one.fmu", 1.0, "an FMU has its parameters as variables"),
        ({}, "one.fmu", math.inf, "stop_time = inf: must be positive and finite"),
        ({"states": toy().states * 2}, "one.fmu", 1.0, "'controller.u': is the name of 2 variables"),
        ({"states": (Signal("a b", "u", "", "m", 0.0),)}, "one.fmu", 1.0, "'a b': cannot be the name"),
        ({"source": "int x = y;"}, "one.fmu", 1.0, "the C compiler"),
    ],
)
def test_what_cannot_be_an_fmu_is_said_in_a_line(
    tmp_path: Path, changes: dict[str, Any], file: str, stop: float, said: str
) -> None:
    with pytest.raises(HydroservoError, match=re.escape(said)) as caught:
        write_fmu(toy()._replace(**changes), tmp_path / file, stop_time=stop)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("wrong", "said"),
    [("false", "false fails: exit status 1"), ("true", "true writes no file"), ("'", "CC = ': No closing")],
)
def test_a_compiler_that_does_not_work_is_said_in_a_line(
    wrong: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", wrong)
    with pytest.raises(HydroservoError, match=said):
        write_fmu(toy(), tmp_path / "one.fmu", stop_time=1.0)
    assert list(tmp_path.iterdir()) == []


def test_a_missing_compiler_is_said_in_a_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(HydroservoError, match="CC names the C compiler no-such-compiler, which is not found"):
        write_fmu(toy(), tmp_path / "one.fmu", stop_time=1.0)
    monkeypatch.delenv("CC")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(HydroservoError, match="no C compiler was found; install gcc or clang, or set CC"):
        write_fmu(toy(), tmp_path / "one.fmu", stop_time=1.0)


def test_a_missing_package_is_said_in_a_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(name: str) -> None:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "distribution", nothing)
    with pytest.raises(HydroservoError, match=re.escape("pip install '.[fmu]'")):
        write_fmu(toy(), tmp_path / "one.fmu", stop_time=1.0)


def test_an_interrupt_leaves_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "one.fmu"
    path.write_text("before")

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    for module, name in ((write, "pack"), (compilers.subprocess, "run")):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, lambda *_, **__: interrupt())
            with pytest.raises(KeyboardInterrupt):
                write_fmu(toy(), path, stop_time=1.0)
        assert [one.name for one in tmp_path.iterdir()] == ["one.fmu"]
        assert path.read_text() == "before"
