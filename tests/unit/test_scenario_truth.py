"""``[truth]``: what the machine is, whatever its nominal values and their deviations say."""

from pathlib import Path

import pytest

from hydroservo import ScenarioError
from hydroservo.core.block import leaves
from hydroservo.machine.mechanics import Mass
from hydroservo.machine.oils import ConstantOil
from hydroservo.machine.plants import Cylinder
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example
from tests.support.bases import on_base
from tests.support.equality import assert_same_block

NAME = "paper/sine-tsmc"  # whose law has a model, and whose machine has uncertainty
DATASHEET = on_base(
    """
[sensors]
type = "RigSensors"
position = {type = "Encoder", resolution = "1 um"}

[plant]
type = "Cylinder.from_diameters"
bore = "63 mm"
rod = "45 mm"
stroke = "200 mm"
start_position = "auto"
oil = {type = "ConstantOil", effective_bulk_modulus = "7000 bar"}
mechanism = {type = "Mass", mass = "6 kg"}

[supply]
supply_pressure = "100 bar"
""",
    law="backstepping",
)
CYLINDER = """
[plant]
type = "Cylinder"
area_a = "4.91 cm^2"
area_b = "4.91 cm^2"
dead_volume_a = "24.551 cm^3"
dead_volume_b = "24.551 cm^3"
oil = {type = "ConstantOil", effective_bulk_modulus = "7000 bar"}
mechanism = {type = "Mass", mass = "6 kg"}
internal_leakage = "2.5e-11 m^3/(s Pa)"
friction = {type = "Viscous", coefficient = "50 N s/m"}
"""


@pytest.fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "my.toml"
    path.write_text(DATASHEET, encoding="utf-8")
    return str(path)


def differing(changes: dict[str, object], source: str = NAME) -> dict[str, object]:
    """The numbers of the loop that some changes change."""
    before = dict(leaves(load_scenario(source)))
    return {path: value for path, value in leaves(load_scenario(source, changes)) if value != before[path]}


@pytest.mark.parametrize("value", ["6.5 kg", "6500 g", 6.5])
def test_only_the_machine_s_own_number_changes(value: object) -> None:
    assert differing({"truth.plant.mass": value}) == {"plant.mass": 6.5}


@pytest.mark.parametrize(
    "more",
    [
        {"uncertainty.scale": -3},
        {"uncertainty.plant.mass": 0.25},
        {"uncertainty.plant.mass": -7},  # alone out of range
        {"plant.mass": "9 kg"},
    ],
)
def test_it_holds_whatever_the_nominal_value_and_its_deviation(more: dict[str, object]) -> None:
    assert load_scenario(NAME, {"truth.plant.mass": 6.5, **more}).plant.mass == 6.5


def test_the_law_believes_in_the_nominal_machine() -> None:
    changes = {"truth.plant.mass": 6.5, "plant.mass": "9 kg"}
    assert load_scenario(NAME, changes).controller.model.plant.mass == 9.0


def test_doubles_are_taken_to_the_bit() -> None:
    value = 0.1 + 0.2
    assert load_scenario(NAME, {"truth.load.amplitude": value}).load.amplitude == value


def test_of_a_datasheet_what_the_constructor_takes_is_true(file: str) -> None:
    loop, usual = load_scenario(file, {"truth.plant.bore": "64 mm"}), load_scenario(file)
    bought = Cylinder.from_diameters(0.064, 0.045, 0.2, ConstantOil(7e8), Mass(6.0))
    assert_same_block(loop.plant, bought)
    assert_same_block(loop.controller, usual.controller)
    assert_same_block(loop.sensors, usual.sensors)
    changes = {"truth.plant.bore": "64 mm", "truth.plant.area_a": "31 cm^2", "uncertainty.plant.area_b": 0.5}
    both = load_scenario(file, changes).plant
    assert (both.area_a, both.area_b) == (pytest.approx(31e-4), 1.5 * loop.plant.area_b)


def test_where_the_machine_starts_may_be_known(file: str) -> None:
    changes = {"truth.plant.start_pressure_a": "30 bar", "truth.plant.start_pressure_b": "auto"}
    assert load_scenario(file, changes).plant.start_pressure_a == pytest.approx(30e5)


def test_it_is_layered_as_all_is(tmp_path: Path) -> None:
    base, own = tmp_path / "machine.toml", tmp_path / "own.toml"
    base.write_text(on_base('[truth.plant]\nmass = "7 kg"\ndamping = 70\n'), encoding="utf-8")
    own.write_text('base = "machine.toml"\ntruth.plant.mass = "8 kg"\n', encoding="utf-8")
    loop = load_scenario(own, {"truth.plant.damping": 80})
    assert (loop.plant.mass, loop.plant.damping) == (8.0, 80.0)
    typed = f'base = "machine.toml"\n{CYLINDER}'
    own.write_text(typed, encoding="utf-8")  # whose mass is its mechanism's
    assert_same_block(load_scenario(own).plant, example(Cylinder))
    own.write_text(f"{typed}[truth]\nplant.mass = 8\n", encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"own.toml: truth.plant.mass: unknown key"):
        load_scenario(own)


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"truth.plant.mss": 1}, "truth.plant.mss: unknown key .*; did you mean plant.mass"),
        ({"truth.scale": 1}, "truth.scale: unknown key"),
        ({"truth.controller.model.plant.mass": 1}, "truth.controller.model.plant.mass: unknown key"),
        ({"truth.plant": 1}, "truth.plant: unknown key"),
        ({"truth": 1}, "truth: 1 must be a table"),
        ({"truth.plant.mass": "-1 kg"}, r"truth.plant.mass: '-1 kg' must be a finite number above 0 \[kg\]"),
        ({"truth.plant.mass": "1 bar"}, "truth.plant.mass: '1 bar' does not convert to kg"),
        ({"truth.plant.mass": True}, "truth.plant.mass: .* must be a finite number"),
        ({"truth.supply.return_pressure": "1 kbar"}, "truth: and uncertainty lead to supply[.: ]"),
    ],
)
def test_what_is_wrong_is_one_line(changes: dict[str, object], problem: str) -> None:
    with pytest.raises(ScenarioError, match=problem) as caught:
        load_scenario(NAME, changes)
    assert "\n" not in str(caught.value)


def test_numbers_that_do_not_go_together_are_refused(file: str) -> None:
    with pytest.raises(ScenarioError, match=r"truth: leads to plant: rod = .*: must be below the bore"):
        load_scenario(file, {"truth.plant.bore": "40 mm"})
    with pytest.raises(ScenarioError, match=r"truth.plant.bor: unknown key .*; did you mean plant.bore"):
        load_scenario(file, {"truth.plant.bor": "40 mm"})
