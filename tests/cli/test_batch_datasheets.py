"""Many runs with other numbers of a datasheet, by --vary and from Python."""

import math
import time

import numpy as np
import pytest

from hydroservo import ParameterError, ScenarioError, simulate, simulate_batch
from hydroservo.core.block import replace
from hydroservo.machine.mechanics import Mass
from hydroservo.machine.oils import ConstantOil
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.valves import FirstOrderValve, Orifice
from hydroservo.runs.provenance import scenario_hash
from hydroservo.scenario import datasheet_columns, load_plugin, load_scenario, parse_override
from tests.support.bases import on_base
from tests.support.commands import batches
from tests.support.commands.batches import again, alone
from tests.support.commands.runner import failed, succeeded
from tests.support.equality import assert_same_block

pytestmark = pytest.mark.nightly  # tests.regression runs each command

TEXT = """
[simulation]
duration = "20 ms"

[plant]
type = "Cylinder.from_diameters"
bore = "63 mm"
rod = "45 mm"
stroke = "200 mm"
start_position = "100 mm"
internal_leakage = "1e-12 m^3/s/Pa"

[plant.mechanism]
type = "Mass"
mass = "40 kg"

[plant.oil]
type = "ConstantOil"
effective_bulk_modulus = "7000 bar"

[valve]
type = "FirstOrderValve.from_corner"
corner_frequency = "60 Hz"

[valve.orifice]
type = "Orifice.rated"
rated_flow = "40 L/min"
rated_drop = "70 bar"
rated_opening = "5 mm"

[supply]
type = "IdealSupply"
supply_pressure = "100 bar"

[uncertainty.plant]
area_b = 0.02
rod = -0.001
"""
BORE, FLOW, CORNER = (
    "plant.bore=62.9..63.1 mm",
    "valve.orifice.rated_flow=-5%..+5%",
    "valve.corner_frequency=50..70",
)
OF_BLOCKS = (
    "plant.mechanism.mass=30..50 kg",
    "plant.stroke=-1%..1%",
    "controller.model.plant.mass=-10%..10%",
)


OIL, MASS = ConstantOil(7e8), Mass(40.0)


@pytest.fixture
def file(tmp_path):
    return written(tmp_path, "backstepping")


def written(folder, law):
    """The path of the scenario with a law."""
    path = folder / "my.toml"
    path.write_text(on_base(TEXT, law), encoding="utf-8")
    return str(path)


def drawn(file, *ranges, changes=(), runs=20):
    """The loop that all runs start from, and what they do not share."""
    return batches.drawn(*ranges, changes=changes, runs=runs, name=file)


def cylinder(bore, rod=45e-3 * 0.999):
    made = Cylinder.from_diameters(bore, rod, 0.2, OIL, MASS, start_position=0.1, internal_leakage=1e-12)
    return made._replace(area_b=made.area_b * 1.02)


def test_the_numbers_of_each_run_are_what_the_constructor_makes(file):
    loop, found = drawn(file, BORE, FLOW, CORNER)
    assert set(found.parameters) == {
        *("plant.area_a", "plant.area_b", "valve.orifice.area_gradient", "valve.time_constant")
    }
    for i in range(20):
        own = alone(loop, found, i)
        bore, flow, corner = (found.values[text.partition("=")[0]][i].item() for text in (BORE, FLOW, CORNER))
        assert own.plant == cylinder(bore)
        orifice = Orifice.rated(flow, 70e5, 5e-3)
        assert own.valve == FirstOrderValve.from_corner(corner, 5e-4, 5e-3, orifice)
        assert own.controller is loop.controller


def test_the_controller_and_the_sensors_go_on_believing_in_the_datasheet(file):
    changes = ["sensors.type=RigSensors", "sensors.position.type=IdealPosition"]
    loop, found = drawn(file, BORE, changes=changes)
    assert set(found.parameters) == {"plant.area_a", "plant.area_b"}
    assert loop.sensors.area_a == pytest.approx(0.25 * math.pi * 63e-3**2)
    assert list(found.changes(0)) == ["truth.plant.bore"]


@pytest.mark.parametrize("law", ["backstepping", "pi", "tsmc"])
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
def test_a_run_is_replayed_to_the_bit(tmp_path, law, changes):
    file = written(tmp_path, law)
    ranges = [BORE, FLOW, CORNER, *OF_BLOCKS[: 2 if law == "pi" else 3]]
    loop, found = drawn(file, *ranges, changes=changes, runs=5)
    for i in range(5):
        assert scenario_hash(again(file, changes, found, i)) == scenario_hash(alone(loop, found, i))


@pytest.mark.parametrize("text", ["null_leakage=0.1..1 L/min", "lap=1..10 um"])
def test_what_is_0_in_the_scenario_is_set_and_the_belief_kept(file, text):
    changes = ["valve.orifice.type=FourEdges.rated", "valve.orifice.supply_pressure=100 bar"]
    loop, found = drawn(file, f"valve.orifice.{text}", changes=changes, runs=3)
    assert list(found.changes(0)) == [f"truth.valve.orifice.{text.partition('=')[0]}"]
    for i in range(3):
        replayed = again(file, changes, found, i)
        assert scenario_hash(replayed) == scenario_hash(alone(loop, found, i))
        assert_same_block(replayed.controller, loop.controller)


def test_each_run_starts_at_its_own_rest_and_is_its_single_run(file):
    changes = {"plant.mechanism.mass": "60 kg", "load.offset": "500 N"}
    columns = datasheet_columns(file, {"plant.bore": [60e-3, 63e-3, 66e-3]}, changes)
    loop = load_scenario(file, changes)
    table = simulate_batch(loop, columns, strict=True)
    for i in range(3):
        own = {path: float(values[i]) for path, values in columns.items()}
        single = simulate(replace(loop, own), record=(), strict=True)
        assert float(single["rms_error"]) == float(table["rms_error"][i])
        assert loop.plant.start_pressure_a == math.inf


def test_ten_thousand_runs_are_made_within_seconds(file):
    bore = np.linspace(62e-3, 64e-3, 10_000)
    start = time.monotonic()
    columns = datasheet_columns(file, {"plant.bore": bore, "valve.corner_frequency": 60.0 + bore})
    assert time.monotonic() - start < 20.0  # 2 s on an idle core; a scenario read for each run takes minutes
    assert columns["plant.area_a"][-1] == cylinder(bore[-1]).area_a


PLUGIN = """
from typing import Annotated, NamedTuple
from hydroservo.core.block import Field
from hydroservo.core.signals import Demand

class Fixed(NamedTuple):
    value: Annotated[float, Field("m/s", "value")] = 0.0
    stages: int = 1

    @classmethod
    def walking(
        cls,
        stride: Annotated[float, Field("m", "stride", above=0)],
        value: Annotated[float, Field("m/s", "value at a stride of 1 m")] = 0.01,
        idle: Annotated[float, Field("s", "what nothing follows from")] = 1.0,
    ) -> "Fixed":
        return cls(stride * value, 1 + int(stride > 1.0))

    def at(self, t):
        return Demand(self.value, 0.0, 0.0)
"""


@pytest.fixture
def plugin(tmp_path, forgotten):
    path = tmp_path / "mine.py"
    path.write_text(PLUGIN, encoding="utf-8")
    return path


WALKING = ["reference.type=Fixed.walking", "reference.stride=0.7"]


def test_outside_the_machine_the_value_itself_varies(file, plugin):
    ranges = "reference.stride=0.5..0.9 m", "reference.value=10..20 mm/s"
    load_plugin(plugin)
    loop, found = drawn(file, *ranges, changes=WALKING, runs=5)
    assert list(found.changes(0)) == ["reference.stride", "reference.value"]
    product = found.values["reference.stride"] * found.values["reference.value"]
    np.testing.assert_array_equal(found.parameters["reference.value"], product)
    for i in range(5):
        assert scenario_hash(again(file, WALKING, found, i)) == scenario_hash(alone(loop, found, i))


def test_the_model_of_a_law_varies_by_its_datasheet(file):
    rated = ["rated_flow=7e-4", "rated_drop=70e5", "rated_opening=5e-3", "type=Orifice.rated"]
    changes = [f"controller.model.orifice.{one}" for one in rated]
    loop, found = drawn(file, "controller.model.orifice.rated_flow=-5%..5%", changes=changes, runs=3)
    assert list(found.parameters) == ["controller.model.orifice.area_gradient"]
    assert scenario_hash(again(file, changes, found, 1)) == scenario_hash(alone(loop, found, 1))


@pytest.mark.parametrize(
    ("texts", "problem"),
    [
        (
            ["plant.bor=1..2"],
            "--vary: plant.bor: must be one of plant.bore, plant.rod, plant.line_volume_a, ",
        ),
        (["valve.corner_freq=1..2"], "; did you mean valve.corner_frequency?"),
        (["plnt.bore=1..2"], "is not a number that can vary; did you mean plant.bore?"),
        (
            ["plant.bore=0..63mm"],
            "--vary: plant.bore: '0..63mm' reaches 0; it must be a finite number above 0 [m]",
        ),
        (["plant.bore=1..2 bar"], "plant.bore: '1 bar' does not convert to m"),
        (["plant.bore=40..63 mm", "plant.rod=40..50 mm"], "plant: rod = 0.04"),
        (["plant.rods=1..2"], "--vary: plant.rods: must be one of plant.bore"),
        (
            ["plant.bore=-1%..1%", "plant.area_a=29..31 cm^2"],
            "--vary: plant.area_a: follows from plant.bore, which varies too",
        ),
    ],
)
def test_what_is_wrong_is_one_line(file, texts, problem):
    words = [word for text in texts for word in ("--vary", text)]
    message = failed("batch", file, "--runs", "200", *words)
    assert problem in message
    assert message.rstrip("\n").isprintable()


def test_a_contradiction_names_its_run(file):
    with pytest.raises(
        ScenarioError, match=r"my.toml: plant: rod = .*: must be below the bore, 0.04 \[m\], in run 2"
    ):
        datasheet_columns(file, {"plant.bore": [63e-3, 64e-3, 40e-3]})
    with pytest.raises(
        ParameterError, match=r"plant.bore = -1.0: must be a finite number above 0 \[m\], in run 1"
    ):
        datasheet_columns(file, {"plant.bore": [63e-3, -1.0]})
    with pytest.raises(
        ScenarioError, match=r"uncertainty.plant.area_b: .* makes plant.area_b inf; .*, in run 1"
    ):
        datasheet_columns(file, {"plant.bore": [63e-3, 1e154]}, {"uncertainty.plant.area_b": 10})


@pytest.mark.parametrize(
    ("values", "error", "problem"),
    [
        (
            {"plant.bor": [1.0]},
            ScenarioError,
            "plant.bor: is not a number that a constructor takes; did you mean plant.bore",
        ),
        ({"plant.bore": [0.06], "plant.rod": [0.04, 0.05]}, ParameterError, "must be arrays of one length"),
        ({"plant.bore": [[0.06]]}, ParameterError, r"must be an array of shape \(runs,\)"),
        ({"plant.bore": ["wide"]}, ParameterError, "must be an array of numbers"),
    ],
)
def test_wrong_arrays_are_refused(file, values, error, problem):
    with pytest.raises(error, match=problem):
        datasheet_columns(file, values)


def test_what_makes_another_block_or_changes_nothing_is_refused(file, plugin):
    args = [word for change in WALKING for word in ("--set", change)]
    message = failed(
        "batch", file, *args, "--plugin", plugin, "--runs", "9", "--vary", "reference.stride=0.5..2 m"
    )
    assert (
        "reference: is a different block from the scenario's, not the same one with other numbers, in run "
        in message
    )
    message = failed(
        "batch", file, *args, "--plugin", plugin, "--runs", "9", "--vary", "reference.idle=1..2 s"
    )
    assert "--vary: reference.idle: changes nothing" in message


def test_no_search_asks_a_constructor(file, plugin):
    assert "plant.bore: must be in the controller or sensors" in failed("tune", file, "--vary", BORE)
    rated = ["rated_flow=7e-4", "rated_drop=70e5", "rated_opening=5e-3", "type=Orifice.rated"]
    args = [word for one in rated for word in ("--set", f"controller.model.orifice.{one}")]
    message = failed("tune", file, *args, "--vary", "controller.model.orifice.rated_flow=-5%..5%")
    assert (
        "controller.model.orifice.rated_flow: is what a constructor takes; a search sets numbers of "
        in message
    )


def test_uncertainty_of_an_argument_is_the_truth_s_alone(file):
    loop = load_scenario(file, {"uncertainty.plant.bore": 0.01, "uncertainty.scale": 2})
    usual = load_scenario(file, {"uncertainty.scale": 2})
    made = Cylinder.from_diameters(63e-3 * 1.02, 45e-3 * 0.998, 0.2, OIL, MASS)
    assert (loop.plant.area_a, loop.plant.area_b) == (made.area_a, made.area_b * 1.04)
    assert_same_block(loop.controller, usual.controller)
    areas = {"plant.area_a": 31e-4, "plant.area_b": 15e-4}
    volumes = {"plant.dead_volume_a": 3e-5, "plant.dead_volume_b": 3e-5}
    without = load_scenario(file, {"plant.type": "Cylinder", **areas, **volumes})
    assert without.plant.area_b == pytest.approx(15e-4 * 1.02)
    for changes, problem in (
        ({"uncertainty.plant.bore": -0.3}, "uncertainty: leads to plant: rod = .*: must be below the bore"),
        (
            {"uncertainty.plant.bore": -2},
            "uncertainty.plant.bore: -2 with scale 1 makes plant.bore -0.063; it must",
        ),
        ({"uncertainty.plant.bor": 1}, "did you mean plant.bore"),
        ({"uncertainty.plant.rods": 1}, "unknown key"),
    ):
        with pytest.raises(ScenarioError, match=problem):
            load_scenario(file, changes)


def test_only_of_the_machine_is_there_a_truth_besides_what_the_scenario_says(file, plugin):
    changes = dict(map(parse_override, WALKING))
    for table in ("uncertainty", "truth"):
        with pytest.raises(ScenarioError, match=rf"{table}\.reference\.stride: unknown key"):
            load_scenario(file, {**changes, f"{table}.reference.stride": 0.1}, [plugin])


def test_the_table_has_the_number_of_the_datasheet_with_its_unit(file, tmp_path):
    out = tmp_path / "runs.csv"
    text = succeeded(
        "batch", file, "--runs", "3", "--vary", BORE, "--vary", "plant.mechanism.mass=30..50kg", "--out", out
    )
    assert "bore of the barrel" in text
    assert "--set truth.plant.bore=" in text
    header = out.read_text(encoding="utf-8").splitlines()[0].split(",")
    assert header[1:5] == [
        *("plant.bore [m]", "plant.mechanism.mass [kg]"),
        *("uncertainty.plant.bore", "uncertainty.plant.mechanism.mass"),
    ]
    assert not any("area" in name for name in header)
