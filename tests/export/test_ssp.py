"""A loop as a system of FMUs, closed as its description says."""

from contextlib import ExitStack
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.ssp.ssd import Connection, read_ssd

from hydroservo import HydroservoError
from hydroservo.export.fmu import PARTS, FmiVersion, write_ssp
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import CModule, Part
from hydroservo.runs.run import simulate
from hydroservo.scenario import load_scenario
from tests.support.export.fmus import Instance
from tests.support.needs import needs
from tests.support.tiers import mostly

pytestmark = pytest.mark.slow  # it builds three FMUs

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SAMPLES = 200
LOOP = load_scenario("rig/1khz-tsmc-sine", {"simulation.record_period": "1 ms", "simulation.duration": "1 s"})


@pytest.fixture(scope="module")
def units() -> dict[Part, CModule]:
    return {part: exported_unit(LOOP, part, prefix=part.value, title=f"a {part}") for part in PARTS}


@pytest.fixture(
    scope="module",
    params=mostly(pytest.mark.nightly, FmiVersion, [FmiVersion.FMI2]),
    ids=lambda version: version.name,
)
def system(
    units: dict[Part, CModule], request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    needs("cc")
    folder = tmp_path_factory.mktemp("system")
    return write_ssp(units, folder / "loop.ssp", stop_time=1.0, version=request.param)


def test_it_names_each_input_and_where_it_comes_from(system: Path) -> None:
    loop = read_ssd(str(system)).system  # which checks it against the standard's schema
    assert [one.name for one in loop.elements] == ["controller", "machine", "demand"]
    inputs = {
        (part.name, one.name) for part in loop.elements for one in part.connectors if one.kind == "input"
    }
    ends = [(one.endElement, one.endConnector) for one in loop.connections]
    assert set(ends) == inputs  # not external.force, which FMPy's player would connect to the command
    assert len(ends) == len(inputs) == 7
    assert ("controller", "demand.value") in inputs
    assert ("machine", "controller.u") in inputs


def test_each_connector_has_the_unit_of_its_variable(system: Path, tmp_path: Path) -> None:
    folders = unpacked(system, tmp_path)
    root = ElementTree.parse(tmp_path / "SystemStructure.ssd").getroot()
    units = {one.name: one for one in read_ssd(str(system)).units}
    assert (units["m/s"].m, units["m/s"].s, units["N"].kg) == (1, -1, 1)
    for component in root.iter(f"{{{SSD}}}Component"):
        description = fmpy.read_model_description(folders[component.attrib["name"]])
        variables = {one.name: one for one in description.modelVariables}
        connectors = list(component.iter(f"{{{SSD}}}Connector"))
        assert connectors
        for connector in connectors:
            unit = connector[0].get("unit")
            assert unit == variables[connector.attrib["name"]].unit
            assert unit is None or unit in units


def in_order(folders: dict[str, Path], connections: list[Connection]) -> list[Connection]:
    """Connections from what depends on no input at once, then those from what does."""
    direct = {
        (name, output.variable.name)
        for name, folder in folders.items()
        for output in fmpy.read_model_description(folder).outputs
        if output.dependencies
    }
    return sorted(connections, key=lambda one: (one.startElement, one.startConnector) in direct)


def unpacked(system: Path, folder: Path) -> dict[str, Path]:
    """The folder of each FMU of a system."""
    fmpy.extract(str(system), unzipdir=str(folder))
    return {
        part: Path(fmpy.extract(str(folder / "resources" / f"{part}.fmu"), unzipdir=str(folder / part)))
        for part in PARTS
    }


def test_asked_in_the_order_of_dependencies_it_is_the_simulation(system: Path, tmp_path: Path) -> None:
    folders, found = unpacked(system, tmp_path), []
    connections = in_order(folders, read_ssd(str(system)).system.connections)
    with ExitStack() as stack:
        parts = {name: stack.enter_context(Instance(folder)).begin() for name, folder in folders.items()}
        for k in range(SAMPLES):
            for one in connections:
                (value,) = parts[one.startElement].get(one.startConnector)
                parts[one.endElement].set({one.endConnector: value})
            found.append(parts["machine"].get("plant.velocity") + parts["controller"].get("controller.u"))
            for part in parts.values():
                assert part.step(k * LOOP.simulation.period) == 0
    direct = simulate(LOOP, strict=True)
    expected = [direct[name].values[:SAMPLES] for name in ("plant.velocity", "controller.u")]
    np.testing.assert_array_equal(np.array(found).T, expected)


def test_stepped_unit_by_unit_as_listed_it_is_the_simulation(system: Path, tmp_path: Path) -> None:
    folders, found = unpacked(system, tmp_path), []
    loop = read_ssd(str(system)).system
    with ExitStack() as stack:
        parts = {one.name: stack.enter_context(Instance(folders[one.name])).begin() for one in loop.elements}
        for k in range(SAMPLES):
            found += parts["machine"].get("plant.velocity")
            for name, part in parts.items():
                for one in loop.connections:
                    if one.endElement == name:
                        (value,) = parts[one.startElement].get(one.startConnector)
                        part.set({one.endConnector: value})
                assert part.step(k * LOOP.simulation.period) == 0
    np.testing.assert_array_equal(found, simulate(LOOP, strict=True)["plant.velocity"].values[:SAMPLES])


def test_equal_exports_give_equal_bytes(units: dict[Part, CModule], tmp_path: Path) -> None:
    needs("cc")
    one, again = (write_ssp(units, tmp_path / f"{name}.ssp", stop_time=1.0) for name in "ab")
    assert one.read_bytes() == again.read_bytes()


def test_its_name_ends_in_ssp(units: dict[Part, CModule], tmp_path: Path) -> None:
    with pytest.raises(HydroservoError, match=r"loop\.fmu: its name must end in \.ssp"):
        write_ssp(units, tmp_path / "loop.fmu", stop_time=1.0)
    assert not list(tmp_path.iterdir())
