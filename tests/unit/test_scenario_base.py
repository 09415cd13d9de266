"""Scenarios that build on others: what lies over what, and which file an error names."""

import os
from pathlib import Path

import numpy as np
import pytest

from hydroservo import ScenarioError, simulate, tune
from hydroservo.control.controllers import DAC, PI, TSMC, Backstepping
from hydroservo.machine.loads import Recorded
from hydroservo.machine.valves import FirstOrderValve, SecondOrderValve, StaticValve
from hydroservo.runs.provenance import scenario_hash
from hydroservo.scenario import datasheet_columns, load_scenario, scenarios
from hydroservo.scenario.scenario_files import builtin_texts
from hydroservo.testing.examples import example
from tests.support.bases import on_base
from tests.support.equality import assert_same_block

MACHINE = on_base(
    """\
title = "A machine"

[plant]
mass = "8 kg"
damping = "60 N s/m"

[valve]
type = "SecondOrderValve"
natural_frequency = "300 rad/s"
slew_limit = "0.5 m/s"
damping_ratio = 0.6
gain = "4e-4 m/V"

[controller]
type = "TSMC"
linear_gain_1 = "2000 1/s"

[uncertainty]
plant.mass = "10 %"
valve.damping_ratio = "20 %"
""",
    law="tsmc",
)


@pytest.fixture
def files(tmp_path: Path):
    """Writes files, by name, and gives the path of the first."""

    def write(**texts: str) -> Path:
        for name, text in texts.items():
            path = tmp_path / f"{name.replace('__', '/')}.toml"
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
        return tmp_path / f"{next(iter(texts)).replace('__', '/')}.toml"

    return write


def refused(path: Path, changes: dict[str, object] | None = None) -> str:
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path, changes)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_what_a_file_gives_lies_over_its_base_key_by_key(files) -> None:
    own = files(
        own='base = "machine.toml"\n[plant]\nmass = "9 kg"\n[uncertainty]\nscale = 0', machine=MACHINE
    )
    loop = load_scenario(own)
    assert (loop.plant.mass, loop.plant.damping) == (9.0, 60.0)
    assert loop.controller.linear_gain_1 == 2000.0


def test_a_base_may_have_a_base(files) -> None:
    own = files(
        own='base = "middle.toml"\nplant.stroke = "70 mm"\nuncertainty.scale = 0',
        middle='base = "machine.toml"\nplant.mass = "7 kg"',
        machine=MACHINE,
    )
    plant = load_scenario(own).plant
    assert (plant.stroke, plant.mass, plant.damping) == (0.07, 7.0, 60.0)


def test_a_base_may_be_built_in(files) -> None:
    own = files(own='base = "rig/1khz-pi-square"\nplant.mass = "7 kg"')
    assert_same_block(load_scenario(own), load_scenario("rig/1khz-pi-square", {"plant.mass": 7.0}))


def test_a_base_without_controller_is_no_scenario(files) -> None:
    assert "rig/1khz" in builtin_texts()
    assert "rig/1khz" not in scenarios()
    with pytest.raises(ScenarioError, match=r"^rig/1khz: controller: a \[controller\] table with a type is"):
        load_scenario("rig/1khz")
    bare = 'base = "rig/1khz"\ncontroller.type = "PI"\n'
    said = refused(files(bare=bare))
    assert ": controller: proportional_gain is missing; it must be a finite number at least 0 [V s/m]" in said
    own = files(own=bare + 'controller.proportional_gain = "2 V s/m"')
    assert_same_block(load_scenario(own).controller, PI(2.0))
    assert_same_block(load_scenario(own).simulation, load_scenario("rig/1khz-pi-sine").simulation)


def test_a_title_is_not_inherited() -> None:
    """Whoever has none is no scenario of the list, whatever the titles below it."""
    untitled = set(builtin_texts()) - set(scenarios())
    assert untitled == {
        *("axis/machine", "axis/press-machine", "cases/axis", "cases/machine", "laws/machine"),
        *("paper/machine", "rig/machine", "rig/excavator", "rig/1khz", "rig/10khz"),
        *("rig/noisy-1khz", "rig/noisy-10khz", "rig/encoder"),
    }


def test_another_type_drops_what_it_does_not_have(files) -> None:
    lagged = 'base = "machine.toml"\nvalve.type = "FirstOrderValve"\nvalve.time_constant = "5 ms"'
    loop = load_scenario(files(own=lagged, machine=MACHINE))
    assert type(loop.valve) is FirstOrderValve
    assert (loop.valve.gain, loop.valve.time_constant) == (4e-4, 5e-3)
    assert loop.plant.mass == 8.0 * 1.1


def test_another_type_drops_only_what_is_below_it(files) -> None:
    """The uncertainty of a file must be one of its own valve."""
    own = files(
        own='base = "machine.toml"\nvalve.type = "FirstOrderValve"\nvalve.time_constant = "5 ms"\n'
        "uncertainty.valve.damping_ratio = 0.1",
        machine=MACHINE,
    )
    assert refused(own).startswith(f"{own}: uncertainty.valve.damping_ratio: unknown key")


def test_the_same_type_drops_nothing(files) -> None:
    own = files(own='base = "machine.toml"\ncontroller.type = "TSMC"', machine=MACHINE)
    assert_same_block(load_scenario(own), load_scenario(own.with_name("machine.toml")))


def test_what_a_type_dropped_does_not_come_back(files) -> None:
    """A file that has a base is as one that holds all that comes of the two."""
    retyped = 'base = "middle.toml"\nuncertainty.scale = 0\nvalve.type = "SecondOrderValve"\n'
    retyped += "valve.slew_limit = 0.5\n"
    own = files(
        own=retyped + 'valve.natural_frequency = "200 rad/s"',
        less=retyped,
        middle='base = "machine.toml"\nvalve.type = "StaticValve"',
        machine=MACHINE,
    )
    assert type(load_scenario(own.with_name("middle.toml")).valve) is StaticValve
    valve = load_scenario(own).valve
    assert (valve.natural_frequency, valve.damping_ratio) == (200.0, example(SecondOrderValve).damping_ratio)
    less = own.with_name("less.toml")
    assert refused(less).startswith(
        f"{less}: valve: natural_frequency is missing; it must be a finite number"
    )


def test_another_law_takes_no_number_of_the_law_below_it(files) -> None:
    """Its gains would be those of another law under the same name."""
    law = 'base = "machine.toml"\ncontroller.type = "Backstepping"\n'
    own = files(
        own=law,
        whole=law + 'controller.velocity_gain = "20 1/s"\ncontroller.force_gain = "10 1/s"\n',
        machine=MACHINE
        + '[controller.saturation]\nlimit = "2 V"\n[controller.derivative]\ntime_constant = "9 ms"',
    )
    assert load_scenario(own.with_name("machine.toml")).controller.saturation.limit == 2.0
    assert "own.toml: controller: velocity_gain is missing" in refused(own)
    whole = load_scenario(own.with_name("whole.toml")).controller
    assert whole._replace(model=None) == Backstepping(20.0, 10.0)._replace(model=None)


LAGGED = """
from typing import NamedTuple

from hydroservo.control.observers import FilteredDerivative


class Lagged(NamedTuple):
    time_constant: float = 1.0
    init, step = FilteredDerivative.init, FilteredDerivative.step
"""


def test_another_block_in_a_law_takes_no_number_of_the_one_below_it(files) -> None:
    below = 'base = "paper/sine-tsmc"\n[controller.derivative]\ntype = "FilteredDerivative"\n'
    retyped = 'base = "below.toml"\ncontroller.derivative.type = '
    own = files(
        own=f'{retyped}"Lagged"',
        same=f'{retyped}"FilteredDerivative"',
        below=below + 'time_constant = "9 ms"',
    )
    plugin = own.with_name("lagged.py")
    plugin.write_text(LAGGED)
    law = load_scenario(own, plugins=[plugin]).controller
    assert (law.derivative.time_constant, law.linear_gain_1) == (1.0, 1e4)
    assert load_scenario(own.with_name("same.toml")).controller.derivative.time_constant == 9e-3


def test_a_law_named_above_its_numbers_takes_them(files) -> None:
    """The file below names no type, and so no other one."""
    own = files(
        own='base = "gains.toml"\ncontroller.type = "PI"',
        gains='base = "rig/1khz"\n[controller]\nproportional_gain = 2',
    )
    assert load_scenario(own).controller == PI(2.0)


def test_a_law_that_overrides_a_file_keeps_what_both_have(files) -> None:
    own = files(own='base = "paper/sine-pi"\ncontroller.saturation.limit = "2 V"')
    changes = {"controller.type": "Backstepping", "controller.velocity_gain": 20, "controller.force_gain": 10}
    assert load_scenario(own, changes).controller.saturation.limit == 2.0


def test_a_search_of_a_base_that_is_for_another_law_is_named(files) -> None:
    search = '[tune]\nscenarios = ["own.toml"]\nweights = [1]\n'
    law = 'base = "rig/1khz-tsmc-square"\n[controller]\ntype = "PI"\nproportional_gain = 2\n'
    own = files(own=law + search)
    with pytest.raises(ScenarioError) as error:
        tune(own)
    assert str(error.value).startswith(
        f"{own}: tune.vary: that of rig/1khz-tsmc-sine, its base, is for another"
    )
    assert 'write [tune.vary] of its own, such as controller.proportional_gain = "LOW..HIGH"' in str(
        error.value
    )


def test_a_law_may_be_wrapped_anew(files) -> None:
    own = files(
        own='base = "machine.toml"\n[controller]\ntype = "DAC"\n'
        'controller = {type = "PI", proportional_gain = 2}',
        machine=MACHINE,
    )
    assert_same_block(load_scenario(own).controller, DAC(controller=PI(2.0)))


def test_changes_lie_on_top(files) -> None:
    own = files(own='base = "machine.toml"\nplant.mass = "9 kg"', machine=MACHINE)
    changes = {"plant.mass": "10 kg", "uncertainty.scale": 0, "valve.type": "StaticValve"}
    loop = load_scenario(own, changes)
    assert (loop.plant.mass, type(loop.valve)) == (10.0, StaticValve)
    exchanged = {"controller.type": "PI", "controller.proportional_gain": 2}
    assert_same_block(load_scenario(own, exchanged).controller, PI(2.0))


def test_a_base_cannot_be_changed(files) -> None:
    own = files(own=MACHINE)
    assert refused(own, {"base": "rig/1khz"}).startswith("overrides: base: cannot be overridden")


def test_files_are_looked_for_beside_the_file_that_names_them(files, tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "log").mkdir()
    (tmp_path / "log" / "force.csv").write_text("t [s],F [N]\n0,0\n1,50\n")
    own = files(
        own='base = "log/middle.toml"\n[simulation]\nduration = "1 s"',
        log__middle='base = "../machine.toml"\n[load]\ntype = "Recorded"\nseries.file = "force.csv"',
        machine=MACHINE,
    )
    monkeypatch.chdir(tmp_path.parent)
    load = load_scenario(own).load
    assert type(load) is Recorded
    assert load.series.value(1.0) == pytest.approx(50.0)
    overriding = {"load.series.file": str(tmp_path / "log" / "force.csv")}
    assert load_scenario(own, overriding).load.series.knots.tolist() == load.series.knots.tolist()


def test_a_column_of_the_same_record_can_be_chosen_above_it(files, tmp_path: Path) -> None:
    (tmp_path / "force.csv").write_text("t [s],F [N],G [N]\n0,0,0\n1,50,70\n")
    own = files(
        own='base = "machine.toml"\nload.series.column = "G"',
        machine=MACHINE + '[load]\ntype = "Recorded"\nseries.file = "force.csv"\n',
    )
    assert load_scenario(own).load.series.value(1.0) == pytest.approx(70.0)


def test_what_constructors_take_may_stand_in_a_base(files) -> None:
    sheet = 'plant.type = "Cylinder.from_diameters"\nplant.bore = "40 mm"\nplant.rod = "22 mm"\n'
    rest = 'plant.stroke = "200 mm"\nplant.mechanism = {type = "Mass", mass = "6 kg"}\n'
    oil = 'plant.oil = {type = "ConstantOil", effective_bulk_modulus = "7000 bar"}\n'
    own = files(own='base = "sheet.toml"\nplant.rod = "25 mm"', sheet=on_base(sheet + rest + oil))
    columns = datasheet_columns(own, {"plant.bore": np.array([0.04, 0.05])})
    assert columns["plant.area_a"][0] == load_scenario(own).plant.area_a
    assert columns["plant.area_a"][1] > columns["plant.area_a"][0]
    assert columns["plant.area_b"][0] == pytest.approx(np.pi / 4 * (0.04**2 - 0.025**2))


CIRCLE = "makes a circle: "


def test_a_circle_is_refused(files) -> None:
    own = files(own='base = "a.toml"', a='base = "b.toml"', b='base = "./a.toml"')
    text = refused(own)
    folder = own.parent
    assert text.startswith(f"{folder / 'b.toml'}: base: './a.toml' {CIRCLE}")
    assert text.endswith(f"{folder / 'a.toml'}, {folder / 'b.toml'}, {folder / 'a.toml'}")


@pytest.mark.skipif(os.name != "posix", reason="links need rights elsewhere")
def test_a_circle_through_a_link_is_refused(files) -> None:
    own = files(own='base = "link.toml"')
    own.with_name("link.toml").symlink_to(own)
    assert CIRCLE in refused(own)


def test_a_file_that_is_its_own_base_is_refused(files) -> None:
    assert CIRCLE in refused(files(own='base = "own.toml"'))


def test_too_long_a_row_is_refused(files) -> None:
    rows = {f"f{i}": f'base = "f{i + 1}.toml"' for i in range(15)}
    path = files(**rows | {"f14": on_base("")})  # whose base is the sixteenth file
    assert_same_block(load_scenario(path).controller, example(PI))
    path = files(**rows, f15='base = "f16.toml"', f16='controller.type = "PI"')
    assert "f15.toml: base: 'f16.toml' is one base too many: no more than 16 files" in refused(path)


@pytest.mark.parametrize(
    ("base", "problem"),
    [
        (
            '"nowhere.toml"',
            "own.toml: base: 'nowhere.toml' is not a built-in name, and there is no such file in ",
        ),
        ('"rig/1kh"', "; did you mean rig/1khz?"),
        ("3", "own.toml: base: 3 must be a string: the name of a built-in scenario, or the path of a file"),
        ('["a", "b"]', "base: ['a', 'b'] must be a string"),
        ('"."', "is a directory, not a file"),
        ('""', "is a directory, not a file"),
        ('"a\\u0000b"', "own.toml: base: 'a\\x00b' is not a built-in name, and there is no such file in "),
        (f'"{"a" * 5000}"', "cannot be read: "),
    ],
)
def test_a_base_that_is_none_is_refused(files, base: str, problem: str) -> None:
    assert problem in refused(files(own=f'base = {base}\ncontroller.type = "PI"'))


@pytest.mark.parametrize(
    ("own", "base", "file", "problem"),
    [
        ('plant.mass = "-1 kg"', "", "own", "plant.mass: '-1 kg' must be"),
        ("", 'plant.mass = "-1 kg"', "base", "plant.mass: '-1 kg' must be"),
        ('plant.mas = "1 kg"', "", "own", "plant.mas: unknown key (value '1 kg'); it must be one of mass"),
        ("", 'plant.mas = "1 kg"', "base", "plant.mas: unknown key"),
        ("plants.mass = 1", "", "own", "plants: unknown key"),
        ("", "plants.mass = 1", "base", "plants: unknown key"),
        ("plant = 3", "", "own", "plant: 3 must be a table: [plant]"),
        ("", "plant = 3", "base", "plant: 3 must be a table: [plant]"),
        ("plant.mass = 8", "plant = 3", "base", "plant: 3 must be a table: [plant]"),
        ('valve.type = "Valve"', "", "own", "valve.type: 'Valve' is not a type here"),
        (
            'sensors.type = "IdealSensors"',
            'sensors = {type = "Sensors", area_a = 1}',
            "own",
            "",
        ),
        (
            'valve.type = "StaticValve"',
            'valve.type = "Valve"',
            "base",
            "valve.type: 'Valve' is not a type here",
        ),
        ("title = 3", "", "own", "title: 3 must be a string"),
        ("", 'uncertainty.plant.mass = "x"', "base", "uncertainty.plant.mass: 'x' is not a quantity"),
        ('plant.start_position = "1 m"', "", "own", "plant: "),
        ("", 'plant.start_position = "1 m"', "base", "plant: "),
        ("controller.observer.type = 1", "", "own", "controller.observer.type: 1 must be"),
        (
            "",
            'load.type = "Recorded"\nload.series.file = "no.csv"',
            "base",
            "load.series.file: 'no.csv' there",
        ),
    ],
)
def test_an_error_names_the_file_in_which_the_value_stands(files, own, base, file, problem) -> None:
    path = files(own=f'base = "base.toml"\n{own}', base=on_base(base, "tsmc"))
    if problem:
        assert refused(path).startswith(f"{path.with_name(f'{file}.toml')}: {problem}")
    else:
        load_scenario(path)


def test_what_is_no_toml_is_said_of_the_base(files) -> None:
    path = files(own='base = "base.toml"', base="[plant")
    assert refused(path).startswith(f"{path.with_name('base.toml')}: is not TOML: ")


def test_a_run_and_its_hash_do_not_know_the_base(files) -> None:
    law = load_scenario("rig/1khz-pi-sine").controller
    gains = f"proportional_gain = {law.proportional_gain!r}\nintegral_gain = {law.integral_gain!r}"
    own = files(
        own='base = "rig/1khz-pi-sine"\nsimulation.duration = "20 ms"',
        whole=f'base = "rig/1khz"\nsimulation.duration = "20 ms"\n[controller]\ntype = "PI"\n{gains}',
    )
    loops = [load_scenario(path) for path in (own, own.with_name("whole.toml"))]
    assert scenario_hash(loops[0]) == scenario_hash(loops[1])
    runs = [simulate(loop, compiled=False) for loop in loops]
    assert runs[0].identical(runs[1])


def test_laws_that_the_base_had_can_be_compared(files) -> None:
    law = 'controller.type = "PI"\ncontroller.proportional_gain = 2'
    own = files(own=f'base = "machine.toml"\n{law}', machine=MACHINE)
    loops = [load_scenario(path) for path in (own, own.with_name("machine.toml"))]
    assert [type(loop.controller) for loop in loops] == [PI, TSMC]
    assert_same_block(*(loop._replace(controller=None) for loop in loops))
