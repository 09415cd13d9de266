"""FMUs of the built-in scenarios: valid descriptions, and runs that equal a strict simulation bit for bit."""

from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest
import xarray as xr

from hydroservo import simulate
from hydroservo.control.loop import Loop
from hydroservo.export.fmu import FmiVersion, write_fmu
from hydroservo.export.fmu.contents import fmu_files
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import CModule, Part, Signal
from hydroservo.scenario import load_scenario
from tests.support.export.fmus import Instance, parts_make_the_run
from tests.support.scenarios import MACHINES
from tests.support.tiers import mostly

pytestmark = pytest.mark.slow

RUN = ("paper/sine-tsmc", "rig/encoder-tsmc-square", "rig/excavator-link", "axis/position")
SAMPLES = 1000


@pytest.mark.parametrize("name", mostly(pytest.mark.nightly, MACHINES, ["axis/position"]))
def test_descriptions_are_valid(name: str, tmp_path: Path) -> None:
    loop = load_scenario(name)
    for part in Part:
        unit = exported_unit(loop, part, prefix="unit", title=f"{part} of scenario {name}")
        for version in FmiVersion:
            text = fmu_files(unit, loop.simulation.duration, version)["modelDescription.xml"]
            (tmp_path / "modelDescription.xml").write_text(text)
            # Raises what it finds. FMPy's check of names takes a hundred times as long: other tests do it.
            description = fmpy.read_model_description(tmp_path, validate=True, validate_model_structure=True)
            numbers = (
                sum(len(one.signals) for one in unit.arguments) + len(unit.parameters) + len(unit.states)
            )
            unseen = len(hidden(unit)) if part is Part.EQUATIONS else 0
            assert len(description.modelVariables) == 1 + numbers - unseen


def hidden(unit: CModule) -> list[Signal]:
    """Numbers of equations that the FMU keeps to itself."""
    given = [one for argument in unit.arguments for one in argument.signals]
    return [one for one in (*given, *unit.states) if one.path.startswith(("instant.", "start.", "jump"))]


def test_what_is_integrated_is_of_the_machine() -> None:
    loop = load_scenario("rig/excavator-link")
    for part in Part:
        states = exported_unit(loop, part, prefix="unit", title="a unit").states
        found = {one.path for one in states if one.integrated}
        wanted = ("plant.", "valve.", "supply.")
        assert found == {one.path for one in states if one.path.startswith(wanted)}
        assert bool(found) is (part in (Part.MACHINE, Part.LOOP))


@cache
def short(name: str) -> Loop:
    """A loop of few samples, each of which is recorded."""
    loop = load_scenario(name)
    period = loop.simulation.period
    brief = loop.simulation._replace(duration=SAMPLES * period, record_period=period)
    return loop._replace(simulation=brief)


@cache
def simulated(name: str) -> xr.Dataset:
    return simulate(short(name), metrics=(), strict=True)


@pytest.fixture(scope="module", params=FmiVersion, ids=lambda version: version.name)
def version(request: pytest.FixtureRequest) -> FmiVersion:
    return request.param


@pytest.fixture(scope="module", params=mostly(pytest.mark.nightly, RUN, RUN[:1]))
def folders(
    request: pytest.FixtureRequest, version: FmiVersion, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, dict[Part, Path]]:
    """A scenario, and the unpacked FMU of each of its parts."""
    found = {}
    for part in Part:
        folder = tmp_path_factory.mktemp(part)
        unit = exported_unit(
            load_scenario(request.param), part, prefix="unit", title=f"{part} of {request.param}"
        )
        path = write_fmu(unit, folder / "unit.fmu", stop_time=1.0, version=version)
        found[part] = Path(fmpy.extract(str(path), unzipdir=str(folder / "unpacked")))
    return request.param, found


def test_a_whole_loop_equals_its_simulation(folders: tuple[str, dict[Part, Path]]) -> None:
    name, parts = folders
    data, period = simulated(name), short(name).simulation.period
    with Instance(parts[Part.LOOP]) as loop:
        names = [one for one in loop.references if one in data.variables]
        assert set(names) == {str(one) for one, values in data.variables.items() if values.dims}
        loop.begin()
        rows = [loop.get(*names)]
        for k in range(SAMPLES):
            assert loop.step(k * period) == 0
            rows.append(loop.get(*names))
    times = {"time": np.arange(SAMPLES + 1) * period}  # an FMU's time is its importer's
    for one, values in zip(names, np.array(rows).T, strict=True):
        np.testing.assert_array_equal(values, times.get(one, data[one].values), err_msg=one)


def test_a_controller_and_a_machine_make_the_loop(folders: tuple[str, dict[Part, Path]]) -> None:
    name, parts = folders
    parts_make_the_run(short(name), simulated(name), parts[Part.CONTROLLER], parts[Part.MACHINE])
