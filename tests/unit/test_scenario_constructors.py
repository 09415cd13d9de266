"""A ``type`` may name a constructor: a classmethod whose arguments are declared as a block's fields."""

from pathlib import Path

import pytest

from hydroservo import ScenarioError
from hydroservo.control.wiring import believed
from hydroservo.core.block import values
from hydroservo.machine.supplies import GasAccumulator, ReliefValve
from hydroservo.machine.valves import FirstOrderValve, FourEdges, Orifice, SecondOrderValve, StaticValve
from hydroservo.scenario import load_plugin, load_scenario
from hydroservo.testing.examples import example
from tests.support.bases import on_base
from tests.support.equality import assert_same_block

NOMINAL = {"uncertainty.scale": 0}
BASE = example(StaticValve)  # that of the scenarios on which those here build
RESPONSE = {
    **NOMINAL,
    "valve.type": "SecondOrderValve.from_response",
    "valve.frequency_90": "120 Hz",
    "valve.frequency_3db": "100 Hz",
    "valve.slew_limit": "500 mm/s",
}
RATED = {"type": "Orifice.rated", "rated_flow": 1e-3, "rated_drop": 70e5, "rated_opening": 1e-3}
LINE = {
    "supply.speed_gain": 1.0,
    "supply.inertia": "0.002 kg m^2",
    "supply.volume": "0.2 L",
    "supply.bulk_modulus": "7000 bar",
}
LITRE_PER_MINUTE = 1e-3 / 60.0


def text(*lines: str) -> str:
    return on_base("\n".join(lines))


def loaded(folder: Path, *lines: str, **changes: object) -> object:
    path = folder / "my.toml"
    path.write_text(text(*lines), encoding="utf-8")
    return load_scenario(path, {name.replace("__", "."): value for name, value in changes.items()}).valve


def refused(changes: dict[str, object]) -> str:
    with pytest.raises(ScenarioError) as caught:
        load_scenario("paper/sine-pi", changes)
    message = str(caught.value)
    assert message.isprintable()
    return message


def test_arguments_have_units_and_defaults() -> None:
    valve = load_scenario("paper/sine-pi", {**RESPONSE, "valve.slew_limit": "300 mm/s"}).valve
    assert valve == SecondOrderValve.from_response(120.0, 100.0, *BASE, slew_limit=0.3)


def test_arguments_may_be_blocks_from_constructors_too(tmp_path: Path) -> None:
    valve = loaded(
        tmp_path,
        "[valve]",
        'type = "SecondOrderValve.from_response"',
        'frequency_90 = "120 Hz"',
        "frequency_3db = 100",
        "slew_limit = 0.5",
        "[valve.orifice]",
        'type = "FourEdges.rated"',
        'rated_flow = "40 L/min"',
        'rated_drop = "70 bar"',
        'rated_opening = "0.5 mm"',
        'null_leakage = "1 L/min"',
        'supply_pressure = "210 bar"',
    )
    edges = FourEdges.rated(
        40 * LITRE_PER_MINUTE, 70e5, 5e-4, null_leakage=LITRE_PER_MINUTE, supply_pressure=210e5
    )
    assert values(valve.orifice) == pytest.approx(values(edges), rel=1e-14)
    base = BASE._replace(orifice=valve.orifice)
    assert_same_block(valve, SecondOrderValve.from_response(120.0, 100.0, *base, slew_limit=0.5))


def test_a_block_inside_a_default_block_may_come_from_a_constructor() -> None:
    valve = load_scenario("paper/sine-pi", {**NOMINAL, "valve.orifice": RATED}).valve
    assert valve.orifice == Orifice.rated(1e-3, 70e5, 1e-3)


def test_edges_may_be_rated_at_the_end_of_the_travel_in_any_unit() -> None:
    for travel, rated in (("0.3 mm", "300 um"), ("300 um", "0.3 mm"), ("1 mm", "0.3 mm")):
        orifice = {**RATED, "rated_opening": rated}
        load_scenario("paper/sine-pi", {**NOMINAL, "valve.max_opening": travel, "valve.orifice": orifice})


def test_a_block_of_one_class_may_come_from_its_constructor() -> None:
    loop = load_scenario("paper/sine-tsmc", {"controller.model.orifice": RATED})
    assert_same_block(loop.controller.model.orifice, Orifice.rated(1e-3, 70e5, 1e-3))
    with pytest.raises(ScenarioError) as caught:
        load_scenario("paper/sine-tsmc", {"controller.model.orifice.type": "Orifice.rate"})
    message = str(caught.value)
    assert message.isprintable()
    assert "controller.model.orifice.type: 'Orifice.rate' must be Orifice or Orifice.rated" in message


def test_another_type_keeps_only_the_keys_that_it_has_too(tmp_path: Path) -> None:
    lines = (
        "[valve]",
        'type = "SecondOrderValve.from_response"',
        "frequency_90 = 120",
        "frequency_3db = 100",
        "slew_limit = 0.5",
        "gain = 4e-4",
    )
    lag = {"valve__type": "FirstOrderValve", "valve__time_constant": "10 ms"}
    assert_same_block(loaded(tmp_path, *lines, **lag), example(FirstOrderValve, gain=4e-4))
    second = {"valve__type": "SecondOrderValve", "valve__natural_frequency": "300 rad/s"}
    assert_same_block(loaded(tmp_path, *lines, **second), example(SecondOrderValve, gain=4e-4))
    assert loaded(tmp_path, *lines, valve__gain=3e-4).gain == 3e-4


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        (
            {"valve.frequency_9": 1},
            "valve.frequency_9: unknown key (value 1); it must be one of frequency_90, frequency_3db, gain, ",
        ),
        ({"valve.natural_frequency": 1}, "valve.natural_frequency: unknown key (value 1)"),
        ({"valve.frequency_90": 0}, "valve.frequency_90: 0 must be a finite number above 0 [Hz]"),
        ({"valve.frequency_90": "1 m"}, "valve.frequency_90: '1 m' does not convert to Hz"),
        ({"valve.frequency_3db": "160 kHz"}, "valve: frequency_3db = 160000.0: must be below 1.55 times"),
        ({"valve.frequency_90": 1e308}, "valve: natural_frequency = inf: must be a finite number above 0"),
        ({"valve.orifice": {**RATED, "rated_opening": 1e-320, "rated_drop": 1e-320}}, "valve.orifice: "),
        ({"valve.orifice": {**RATED, "rated_flow": 1e308}}, "valve.orifice: area_gradient = inf: must be"),
        (
            {"valve.max_opening": "0.9 mm", "valve.orifice": RATED},
            "valve: orifice.rated_opening = 0.001: must be at most max_opening, 0.0009 [m]",
        ),
        ({"valve.type": "SecondOrderValve.from_responses"}, "; did you mean SecondOrderValve.from_response?"),
        ({"valve.type": "SecondOrderValve.init"}, "'SecondOrderValve.init' is not a type here"),
        ({"valve.type": "SecondOrderValve._make"}, "'SecondOrderValve._make' is not a type here"),
        ({"valve.type": "SecondOrderValve."}, "'SecondOrderValve.' is not a type here"),
        (
            {"controller.type": "SecondOrderValve.from_response"},
            "cannot be a Controller: it says that its role is Valve",
        ),
    ],
)
def test_errors_are_those_of_a_block(changes: dict[str, object], problem: str) -> None:
    assert problem in refused({**RESPONSE, **changes})


@pytest.mark.parametrize("missing", ["valve.frequency_90", "valve.frequency_3db"])
def test_what_has_no_default_must_be_given(missing: str) -> None:
    given = {key: value for key, value in RESPONSE.items() if key != missing}
    assert refused(given).endswith(
        f"valve: {missing.removeprefix('valve.')} is missing; it must be a finite number above 0 [Hz]"
    )


@pytest.mark.usefixtures("forgotten")
def test_a_plugin_s_constructor(tmp_path: Path) -> None:
    plugin = tmp_path / "mine.py"
    plugin.write_text("""
from typing import Annotated, NamedTuple
from hydroservo.core.block import Field
from hydroservo.control.references import Sine
from hydroservo.core.signals import Demand

class Fixed(NamedTuple):
    value: Annotated[float, Field("m/s", "value")] = 0.0

    @classmethod
    def walking(cls, stride: Annotated[float, Field("m", "stride", above=0)], rate: float = 2) -> "Fixed":
        return cls(stride * rate)

    @classmethod
    def undeclared(cls, stride) -> "Fixed":
        return cls(stride)

    def at(self, t):
        return Demand(self.value, 0.0, 0.0)
""")
    load_plugin(plugin)
    reference = load_scenario(
        "paper/sine-pi", {"reference.type": "Fixed.walking", "reference.stride": "70 cm"}
    ).reference
    assert reference.value == pytest.approx(1.4)
    message = refused({"reference.type": "Fixed.undeclared", "reference.stride": 1})
    assert "reference.stride: 1 cannot be a block's parameter" in message


def test_a_pump_and_its_relief_valve_from_constructors() -> None:
    changes = {
        "supply.type": "PumpSupply.from_datasheet",
        "supply.displacement": "2 cm^3/rev",
        "supply.rated_speed": "1500 rpm",
        "supply.volumetric_efficiency": 0.92,
        "supply.rated_pressure": "60 bar",
        "supply.max_torque": "4 N m",
        **LINE,
        "supply.relief.type": "ReliefValve.from_override",
        "supply.relief.cracking_pressure": "63 bar",
        "supply.relief.override": "4 bar",
        "supply.relief.flow": "3 L/min",
        "supply.accumulator": {"type": "GasAccumulator", "precharge": "30 bar", "gas_volume": "0.5 L"},
        "valve.type": "FirstOrderValve.from_corner",
        "valve.corner_frequency": "40 Hz",
    }
    loop = load_scenario("paper/sine-pi", {**NOMINAL, **changes})
    leaked = loop.supply.leakage * 60e5
    assert leaked == pytest.approx(0.08 * 3.0 * LITRE_PER_MINUTE, rel=1e-12)
    assert loop.supply.relief == pytest.approx(ReliefValve(63e5, 0.75 * LITRE_PER_MINUTE / 1e5), rel=1e-14)
    assert_same_block(loop.supply.accumulator, GasAccumulator(precharge=30e5, gas_volume=5e-4))
    assert_same_block(loop.valve, FirstOrderValve.from_corner(40.0, *BASE))
    assert believed(loop).supply.supply_pressure == 63e5


def test_a_pump_that_gives_no_pressure_is_the_supply_s_fault() -> None:
    pump = {"type": "PumpSupply", "displacement": "2 cm^3/rev", "demanded_speed": 0, "max_torque": "5 N m"}
    message = refused(
        {"supply": pump, "supply.relief": {"cracking_pressure": "40 bar", "gradient": 2.5e-10}, **LINE}
    )
    assert "supply: pressure = 0.0: must be above return_pressure, 0 [Pa]" in message


def test_a_pump_as_its_datasheet_has_it() -> None:
    changes = {
        "supply.type": "PumpSupply",
        "supply.displacement": "2 cm^3/rev",
        "supply.demanded_speed": "1500 rpm",
        "supply.max_torque": "5 N m",
        **LINE,
        "supply.relief.cracking_pressure": "40 bar",
        "supply.relief.gradient": "1.5 L/min/bar",
        "supply.accumulator.type": "GasAccumulator",
        "supply.accumulator.precharge": "28 bar",
        "supply.accumulator.gas_volume": "0.5 L",
    }
    supply = load_scenario("paper/sine-pi", {**NOMINAL, **changes}).supply
    assert supply.displacement * supply.demanded_speed == pytest.approx(3.0 * LITRE_PER_MINUTE, rel=1e-14)
    assert supply.relief.gradient == pytest.approx(1.5 * LITRE_PER_MINUTE / 1e5, rel=1e-14)
    assert_same_block(supply.accumulator, GasAccumulator(precharge=28e5, gas_volume=5e-4))
