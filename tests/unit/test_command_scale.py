"""Commands in mA and in per cent: the same loop as in volts, read and written in another unit."""

import re
from collections.abc import Mapping

import numpy as np
import pytest

from hydroservo import replace, simulate
from hydroservo.core.block import leaves
from hydroservo.core.command_scale import VOLTS, CommandScale, command_scale, commands_in, in_command_unit
from hydroservo.core.errors import ScenarioError
from hydroservo.core.formatting import quantity, readable_unit
from hydroservo.core.signals import Demand
from hydroservo.export.parts import Command, ControllerUnit, ExternalForce, MachineUnit, block_of
from hydroservo.export.unit import Part
from hydroservo.identification.log import read_log
from hydroservo.runs.provenance import scenario_hash
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario import assemble, load_scenario
from hydroservo.scenario.parameter_draws import draws
from hydroservo.scenario.quantities import si_value

CURRENT, SHARE = CommandScale(current=0.04), CommandScale(share=1.0)
IN_VOLTS = {
    "valve.gain": "0.5 mm/V",
    "controller.proportional_gain": "0.004 V s/mm",
    "controller.integral_gain": "600 V/m",
    "controller.saturation.limit": "7.5 V",
    "simulation.duration": "0.2 s",
}
IN_MA = {
    "command.full_scale": "40 mA",
    "valve.gain": "125 um/mA",
    "controller.proportional_gain": "0.016 mA s/mm",
    "controller.integral_gain": "2.4 A/m",
    "controller.saturation.limit": "30 mA",
    "simulation.duration": "0.2 s",
}
IN_PERCENT = {
    "command.full_scale": "100 %",
    "valve.gain": "0.05 mm/%",
    "controller.proportional_gain": "0.04 %/(mm/s)",
    "controller.integral_gain": "6 %/mm",
    "controller.saturation.limit": "75 %",
    "simulation.duration": "0.2 s",
}


def loop_with(changes: Mapping[str, str]):
    return load_scenario("rig/1khz-pi-sine", changes)


@pytest.mark.parametrize("changes", [IN_MA, IN_PERCENT])
def test_one_machine_in_three_units_is_one_loop(changes):
    volts, other = loop_with(IN_VOLTS), loop_with(changes)
    numbers = dict(leaves(volts))
    assert {path: one for path, one in leaves(other) if not path.startswith("command.")} == {
        path: one for path, one in numbers.items() if not path.startswith("command.")
    }
    assert numbers["controller.proportional_gain"] == 4.0
    assert scenario_hash(volts) == scenario_hash(other)
    runs = [simulate(one) for one in (volts, other)]
    assert np.array_equal(runs[0]["controller.u"], runs[1]["controller.u"])
    assert runs[1]["controller.u"].attrs["units"] == "V"


def test_plain_numbers_and_volts_are_still_volts():
    loop = loop_with(IN_MA | {"controller.saturation.limit": 5.0, "controller.integral_gain": "700 V/m"})
    assert loop.controller.saturation.limit == 5.0
    assert loop.controller.integral_gain == 700.0


@pytest.mark.parametrize(
    ("scale", "unit", "shown"),
    [
        (VOLTS, "V", "1.00 V"),
        (CURRENT, "V", "4.00 mA"),
        (SHARE, "V", "10.0 %"),
        (CommandScale(current=2.5), "V", "0.250 A"),
        (CURRENT, "m/V", "250 mm/mA"),
        (CURRENT, "m^3/(s V)", "15000 L/(min mA)"),
        (CURRENT, "V s/m", "4.00 mA s/m"),
        (SHARE, "V^2 s", "100 %² s"),
        (CURRENT, "N", "1.00 N"),
    ],
)
def test_a_size_of_one_is_read_in_the_unit_of_commands(scale, unit, shown):
    with commands_in(scale):
        assert quantity(1.0, unit) == shown


def test_a_small_command_keeps_the_unit_of_its_valve():
    with commands_in(CURRENT):
        assert readable_unit("V", 1e-6) == ("mA", 4.0)
    assert readable_unit("V", 1e-6) == ("mV", 1e3)


@pytest.mark.parametrize("scale", [CURRENT, SHARE, VOLTS])
@pytest.mark.parametrize("unit", ["V", "m/V", "V/m", "V s^2/m", "m^3/(s V)", "rad/(s V)", "V^2 s"])
def test_what_is_written_is_what_is_read(scale, unit):
    with commands_in(scale):
        label, factor = in_command_unit(unit)
        assert si_value(f"{factor!r} {label}", unit) == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize(
    ("scale", "text", "unit", "said"),
    [
        (VOLTS, "40 mA", "V", 'does not convert to V; add [command] full_scale = "40 mA", or what else 10 V'),
        (VOLTS, "1 %/mm", "V/m", 'does not convert to V/m; add [command] full_scale = "100 %"'),
        (VOLTS, "40 bar", "V", "does not convert to V"),
        (CURRENT, "40 %", "V", "does not convert to V or mA, as commands are by [command] full_scale"),
        (SHARE, "40 mA", "V", "does not convert to V or %, as commands are by [command] full_scale"),
        (SHARE, "5 m", "m/V", "does not convert to m/V"),  # which is not m/%
        (SHARE, "0.5", "V", "has no unit"),
        (CURRENT, "40 mA", "Pa", "does not convert to Pa"),
    ],
)
def test_another_unit_is_refused_with_what_to_write(scale, text, unit, said):
    with commands_in(scale), pytest.raises(ValueError, match=f"^{re.escape(said)}"):
        si_value(text, unit)


@pytest.mark.parametrize(
    "text", ["40 bar", "0 mA", "-40 mA", "0 %", "-1 %", "20 V", "forty", "1", 40, True, ""]
)
def test_a_full_scale_that_is_none_is_one_line(text):
    with pytest.raises(ScenarioError) as error:
        load_scenario("rig/1khz-pi-sine", {"command.full_scale": text})
    assert error.value.key == "command.full_scale"
    assert "must be" in str(error.value)
    assert "\n" not in str(error.value)


def test_command_has_no_other_key():
    with pytest.raises(ScenarioError, match="unknown key"):
        load_scenario("rig/1khz-pi-sine", {"command.fullscale": "40 mA"})


def test_a_percentage_of_a_number_without_unit_is_a_hundredth():
    with commands_in(SHARE):
        assert si_value("5 %", "") == 0.05


def test_loading_changes_no_unit_in_python():
    loop_with(IN_MA)
    assert command_scale() == VOLTS


def test_who_follows_scenarios_reads_volts_where_these_differ():
    with commands_in(None):
        assert command_scale() == VOLTS
        loop_with(IN_MA)
        loop_with(IN_MA)
        assert command_scale() == CURRENT
        loop_with(IN_PERCENT)
        assert command_scale() == VOLTS


def test_a_column_in_ma_needs_no_scale(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text(
        "time [s],command [mA],position [mm]\n" + "".join(f"{t / 100},{4 * (t % 2)},{t}\n" for t in range(20))
    )
    with commands_in(CURRENT):
        assert set(read_log(log, {}).signals["command"].tolist()) == {0.0, 1.0}
    with pytest.raises(ScenarioError, match=r"\[command\] full_scale"):
        read_log(log, {})


def test_a_controller_is_exported_with_its_command_in_ma():
    volts, ma = (block_of(runnable_loop(loop_with(one)), Part.CONTROLLER) for one in (IN_VOLTS, IN_MA))
    assert isinstance(volts, ControllerUnit)
    measured = block_of(runnable_loop(loop_with(IN_VOLTS)), Part.MACHINE).init().measurement
    before, after = volts.init(), ma.init()
    for _ in range(5):
        before = volts.step(before, measured.with_command(before.u), Demand(0.25, 0.0, 0.0))
        after = ma.step(after, measured.with_command(after.u), Demand(0.25, 0.0, 0.0))
    assert 1.0 < before.u < 7.5
    assert after.u == 4.0 * before.u
    assert after.controller == before


@pytest.mark.parametrize("hold", ["ZeroOrderHold", "DelayedHold"])
def test_a_machine_is_exported_with_its_command_in_ma(hold):
    held = {"hold.type": hold} | ({"hold.delay": "0.5 ms"} if hold == "DelayedHold" else {})
    volts, ma = (block_of(runnable_loop(loop_with(one | held)), Part.MACHINE) for one in (IN_VOLTS, IN_MA))
    assert isinstance(volts, MachineUnit)
    before, after = volts.init(), ma.init()
    for command in (1.0, 2.0, -3.0):
        before = volts.step(before, Command(command), ExternalForce(0.0))
        after = ma.step(after, Command(4.0 * command), ExternalForce(0.0))
    assert after.plant == before.plant
    assert after.measurement.command == 4.0 * before.measurement.command != 0.0


def test_a_loop_says_its_scale_where_it_is_not_volts():
    loop = loop_with(IN_MA)
    assert "CommandScale: current 0.04 A" in repr(loop)
    assert "CommandScale" not in repr(replace(loop, {"command": VOLTS}))


def test_ranges_in_python_are_in_the_unit_of_the_scenario():
    loop = loop_with(IN_MA)
    drawn = draws(loop, {"controller.saturation.limit": "4..8 mA"}, runs=3)
    assert drawn.ranges["controller.saturation.limit"] == (1.0, 2.0)
    searched = {**IN_MA, "tune.vary.controller.proportional_gain": "8..16 mA s/m"}
    found = assemble("rig/1khz-pi-sine", searched).search.ranges["controller.proportional_gain"]
    assert found[:2] == (2.0, 4.0)
