"""Many runs with other numbers of a datasheet: --vary of what a constructor takes, and the same from Python."""

import math
import time

import numpy as np
import pytest
from test_batch_replay import replayed
from test_cli import failed, succeeded

from hydroservo import ParameterError, ScenarioError, simulate, simulate_batch
from hydroservo.block import replace
from hydroservo.cli.replay import Origin, command
from hydroservo.cli.variations import drawn_runs, variations
from hydroservo.plants import Cylinder
from hydroservo.provenance import scenario_hash
from hydroservo.scenario import datasheet_columns, load_scenario, plugins
from hydroservo.scenario.datasheets import columns_of
from hydroservo.valves import FirstOrderValve, Orifice

TEXT = """
[simulation]
duration = "20 ms"

[controller]
type = "Backstepping"

[plant]
type = "Cylinder.from_diameters"
bore = "63 mm"
rod = "45 mm"
stroke = "200 mm"
internal_leakage = "1e-12 m^3/s/Pa"

[plant.mechanism]
mass = "40 kg"

[valve]
type = "FirstOrderValve.from_corner"
corner_frequency = "60 Hz"

[valve.orifice]
type = "Orifice.rated"
rated_flow = "40 L/min"
rated_drop = "70 bar"
rated_opening = "5 mm"

[supply]
supply_pressure = "100 bar"

[uncertainty.plant]
area_b = 0.02
rod = -0.001
"""
BORE, FLOW, CORNER = "plant.bore=62.9..63.1 mm", "valve.orifice.rated_flow=-5%..+5%", "valve.corner_frequency=50..70"
OF_BLOCKS = ("plant.mechanism.mass=30..50 kg", "plant.stroke=-1%..1%", "controller.model.plant.mass=-10%..10%")


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(TEXT, encoding="utf-8")
    return str(path)


def drawn(file, *ranges, changes=(), runs=20, more=()):
    """The loop that all runs start from, and what they do not share."""
    origin = Origin(file, changes, more)
    assembly = origin.assembled({})
    varied = variations(ranges, assembly.loop, origin.nominal(), assembly.arguments)
    found = drawn_runs(assembly.loop, varied, 0, runs, seeds=False, arguments=assembly.arguments)
    return assembly.loop, found.constructed(lambda values: columns_of(assembly, values))


def cylinder(bore, rod=45e-3 * 0.999):
    parts = {"stroke": 0.2, "internal_leakage": 1e-12}
    made = Cylinder.from_diameters(bore, rod, **parts)
    return made._replace(area_b=made.area_b * 1.02, mechanism=made.mechanism._replace(mass=40.0))


def test_the_numbers_of_each_run_are_what_the_constructor_makes(file):
    loop, found = drawn(file, BORE, FLOW, CORNER)
    assert set(found.parameters) == {
        *("plant.area_a", "plant.area_b", "valve.orifice.area_gradient", "valve.time_constant")
    }
    for i in range(20):
        own = replace(loop, found.of_run(i)[1])
        bore, flow, corner = (found.arguments[text.partition("=")[0]][i].item() for text in (BORE, FLOW, CORNER))
        assert own.plant == cylinder(bore)
        assert own.valve == FirstOrderValve.from_corner(
            corner, orifice=Orifice.rated(flow, 70e5, 5e-3)
        )
        assert own.nominal is loop.nominal
        assert own.controller is loop.controller


def test_the_controller_and_the_sensors_go_on_believing_in_the_datasheet(file):
    changes = {"sensors.type": "PressureSensors"} if False else {}
    columns = datasheet_columns(file, {"plant.bore": [62e-3, 64e-3]}, changes)
    assert set(columns) == {"plant.area_a", "plant.area_b"}


@pytest.mark.parametrize("law", ["Backstepping", "PI", "TSMC"])
@pytest.mark.parametrize(
    "changes",
    [
        [],
        ["uncertainty.scale=0"],
        ["uncertainty.scale='-50 %'", "plant.bore=64 mm"],
        ["uncertainty.scale=3", "uncertainty.plant.bore=0.001", "uncertainty.valve.corner_frequency=0.1"],
        ["uncertainty.plant.area_a=0.05", "uncertainty.plant.mechanism.mass=0.25"],
    ],
)
def test_a_run_is_replayed_to_the_bit(file, law, changes):
    changes = [*changes, f"controller.type={law}"]
    ranges = [BORE, FLOW, CORNER, *OF_BLOCKS[: 2 if law == "PI" else 3]]
    loop, found = drawn(file, *ranges, changes=changes, runs=5)
    for i in range(5):
        settings, parameters = found.of_run(i)
        again = replayed(command(Origin(file, changes, ()), settings, parameters))
        assert scenario_hash(again) == scenario_hash(replace(loop, parameters))
