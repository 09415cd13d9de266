"""Parts that a scenario takes by name: what lies over what, errors in their files, and their data sheets."""

import math

import numpy as np
import pytest

import hydroservo as hs
from hydroservo import ParameterError, ScenarioError
from hydroservo.app.source import Home, page_source
from hydroservo.scenario.part_files import part_texts
from hydroservo.scenario.part_sheets import part_sources

SERVO = """
title = "A valve of ours"
source = "data sheet 12, p. 3"
type = "SecondOrderValve.from_response"
frequency_90 = "100 Hz"
frequency_3db = "90 Hz"
gain = "0.1 mm/V"
max_opening = "1 mm"

[orifice]
part = "edges/4wrpeh-6-12"
lap = "20 um"

[sources]
frequency_90 = "data sheet 12, p. 5, at 5 % of the stroke"
"""

SLOWER = 0.9  # than its nominal one is the valve in the uncertainty of axis/position


@pytest.fixture
def folder(tmp_path):
    """A folder of one's own with a part in it."""
    (tmp_path / "ours").mkdir()
    (tmp_path / "ours" / "valve.toml").write_text(SERVO)
    return tmp_path


def loaded(folder, text, **changes):
    """The loop of a scenario in a folder, which builds on the built-in axis."""
    file = folder / "mine.toml"
    file.write_text(f'base = "axis/position"\n{text}')
    return hs.load_scenario(file, changes)


def refused(folder, text, name="ours/valve.toml"):
    """What is wrong with a text of a part that a scenario takes as its valve."""
    (folder / name).write_text(text)
    with pytest.raises(ScenarioError) as caught:
        loaded(folder, f'valve = {{ part = "{name}" }}')
    said = str(caught.value)
    assert "\n" not in said
    return said


@pytest.mark.parametrize("name", part_texts())
def test_each_part_builds_and_draws(name):
    found = hs.part(name)
    assert found.title
    assert found.source
    assert found.finding().pictures[0].draw().axes
    assert found.sheet.results
    for panel in found.sheet.panels:
        assert all(np.isfinite(one.x).all() and np.isfinite(one.y).all() for one in panel.curves)


def test_a_scenario_takes_a_part_and_changes_single_numbers(folder):
    valve = loaded(folder, 'valve = { part = "ours/valve.toml", hysteresis = "2 um" }').valve
    assert math.isclose(valve.natural_frequency, SLOWER * 2.0 * math.pi * 100.0)
    assert valve.hysteresis == 2e-6
    assert valve.orifice.lap == 20e-6
    assert math.isclose(valve.orifice.flow(1e-3, 70e5, 0.0), 12.0 / 60000.0)


def test_a_part_leaves_no_number_of_the_device_below_it(folder):
    base, mine = (
        hs.load_scenario("axis/position").valve,
        loaded(folder, 'valve.part = "ours/valve.toml"').valve,
    )
    assert (base.hysteresis, base.orifice.area_ratio_b, base.slew_limit) == (4e-6, 0.5, 0.1)
    assert (mine.hysteresis, mine.orifice.area_ratio_b) == (0.0, 1.0)
    assert mine.slew_limit > 1e3


def test_what_the_part_does_not_give_stays_the_machines(folder):
    base = hs.load_scenario("axis/position").plant
    mine = loaded(folder, 'plant = { part = "cylinder/iso-6020-2-80-56", stroke = "200 mm" }').plant
    assert math.isclose(mine.area_a, 0.25 * math.pi * 0.08**2)
    assert (mine.stroke, mine.internal_leakage) == (0.2, 0.0)
    assert (mine.oil, mine.friction, mine.mechanism) == (base.oil, base.friction, base.mechanism)
    wanted = r"plant: stroke is missing; .*; give it beside part cylinder/iso-6020-2-80-56$"
    with pytest.raises(ScenarioError, match=wanted):
        loaded(folder, 'plant.part = "cylinder/iso-6020-2-80-56"')


def test_the_upper_part_counts(folder):
    text = 'valve = { part = "ours/valve.toml", hysteresis = "2 um" }'
    (folder / "other.toml").write_text(SERVO.replace('lap = "20 um"', 'lap = "0 um"'))
    valve = loaded(folder, text, **{"valve.part": str(folder / "other.toml")}).valve
    assert (valve.hysteresis, valve.orifice.lap) == (0.0, 0.0)
    (folder / "above.toml").write_text('base = "mine.toml"\nvalve.orifice.part = "edges/4wrpeh-6-40"\n')
    above = hs.load_scenario(folder / "above.toml").valve
    assert math.isclose(above.orifice.flow(1e-3, 70e5, 0.0), 40.0 / 60000.0)
    assert (above.hysteresis, above.orifice.lap) == (2e-6, 0.0)


def test_a_part_builds_on_another(folder):
    (folder / "ours" / "wide.toml").write_text('part = "valve.toml"\nmax_opening = "2 mm"\n')
    valve = loaded(folder, 'valve.part = "ours/wide.toml"').valve
    assert valve.max_opening == 2e-3
    assert math.isclose(valve.natural_frequency, SLOWER * 2.0 * math.pi * 100.0)


def test_a_curve_of_the_device_below_goes(folder):
    curve = '[valve.orifice]\nrated_flow = "auto"\nlap = 0.0\n'
    curve += 'flow_curve = {points = [["0 %", "0 L/min"], ["10 %", "1 L/min"], ["100 %", "40 L/min"]]}\n'
    loaded(folder, curve.replace('"0 %"', "0.0").replace('"10 %"', "0.1").replace('"100 %"', "1.0"))
    (folder / "above.toml").write_text('base = "mine.toml"\nvalve.orifice.part = "edges/4wrpeh-6-12"\n')
    edges = hs.load_scenario(folder / "above.toml").valve.orifice
    assert math.isclose(edges.flow(0.5e-3, 70e5, 0.0), 6.0 / 60000.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            SERVO.replace('frequency_90 = "100 Hz"\n', "").partition("[sources]")[0],
            "valve.toml: valve: frequency_90 is missing; it must be",
        ),
        (SERVO.replace("frequency_90 =", "frequenzy_90 ="), "valve.toml: valve.frequenzy_90: unknown key"),
        (SERVO.replace('"100 Hz"', '"100 kg"'), "valve.toml: valve.frequency_90: '100 kg'"),
        (
            'type = "AeratedOil"',
            "valve.toml: valve.type: 'AeratedOil' cannot be a Valve: it says that its role is Oil",
        ),
        ("gain = ", "valve.toml: is not TOML: Invalid value"),
        ('gain = "0.1 mm/V"', "valve.toml: type: is missing: a part says which block it is"),
        ('part = "valve.toml"', "valve.part: 'valve.toml' makes a circle: "),
        (
            f'{SERVO}[orifice.shape]\npart = "valve.toml"',
            "valve.orifice.shape.part: 'valve.toml' makes a circle: ",
        ),
        (f"{SERVO}mass = 'p. 3'", "valve.toml: sources.mass: unknown key"),
        (
            f"title = 3\n{SERVO.partition(chr(10))[2].partition(chr(10))[2]}",
            "valve.toml: title: 3 must be a string",
        ),
        (f"sources = 3\n{SERVO.partition('[sources]')[0]}", "valve.toml: sources: 3 must be a table"),
    ],
)
def test_what_is_wrong_with_a_part_is_one_line_with_its_file(folder, text, said):
    assert said in refused(folder, text)


def test_a_name_that_no_part_has(folder):
    with pytest.raises(ScenarioError, match=r"mine.toml: valve.part: .* did you mean edges/4wrpeh-6-12\?$"):
        loaded(folder, 'valve.part = "edges/4wrpeh-6-1z"')
    with pytest.raises(ScenarioError, match=r"`hydroservo parts` lists the built-in ones$"):
        loaded(folder, 'valve.part = "something else"')
    with pytest.raises(ScenarioError, match=r"valve.part: 3 must be a string"):
        loaded(folder, "valve.part = 3")
    with pytest.raises(ScenarioError, match=r"mine.toml: part: unknown key"):
        loaded(folder, 'part = "edges/4wrpeh-6-40"')
    (folder / "oil.toml").write_text('type = "AratedOil"')
    with pytest.raises(ScenarioError, match="is not a type of a block; did you mean AeratedOil"):
        hs.part(folder / "oil.toml")


def test_the_forces_of_a_cylinder_are_those_that_another_data_sheet_lists():
    """RE 17051, edition 2022-10, lists the forces of CDT3 cylinders to ISO 6020-2 at 160 bar [kN]."""
    listed = {"63-45": (49.9, 24.4), "100-70": (125.7, 64.1)}
    for size, forces in listed.items():
        results = {one.meaning: one.value for one in hs.part(f"cylinder/iso-6020-2-{size}").sheet.results}
        found = (results["force out at 100 bar"], results["force in at 100 bar"])
        assert [round(1.6e-3 * one, 1) for one in found] == [*forces]


def test_the_flow_of_a_pump_falls_in_proportion_to_the_pressure(tmp_path):
    """55.65 L/min without pressure, of which 84.6 % come at the rated 240 bar."""
    (tmp_path / "pump.toml").write_text(
        'type = "PumpSupply.from_datasheet"\ndisplacement = "37.1 cm^3/rev"\nrated_speed = "1500 rpm"\n'
        'rated_pressure = "240 bar"\nvolumetric_efficiency = 0.846\n'
    )
    (curve,) = hs.part(tmp_path / "pump.toml").sheet.panels[0].curves
    for share in (0.0, 0.5, 1.0):
        flow = 6e4 * np.interp(share * 240e5, curve.x, curve.y)
        assert math.isclose(flow, 55.65 * (1.0 - 0.154 * share), rel_tol=1e-3)


def test_the_oil_of_an_accumulator_is_that_of_the_gas_law(tmp_path):
    (tmp_path / "accumulator.toml").write_text('type = "GasAccumulator"\ngas_volume = "9.3 L"\n')
    gas, first, last = 9.3e-3, 100e5 + 101325.0, 200e5 + 101325.0
    (result,) = hs.part(tmp_path / "accumulator.toml").sheet.results
    assert math.isclose(result.value, gas * (1.0 - (first / last) ** (1.0 / 1.2)), rel_tol=1e-4)


def test_the_response_of_a_valve_passes_its_two_frequencies(folder):
    found = hs.part(folder / "ours" / "valve.toml")
    _, amplitude, phase = (panel.curves[0] for panel in found.sheet.panels)
    assert abs(np.interp(90.0, amplitude.x, amplitude.y) + 10.0 * math.log10(2.0)) < 0.01
    assert abs(np.interp(100.0, phase.x, phase.y) + 90.0) < 0.1


def test_a_valve_of_the_first_order_and_a_static_one_have_sheets_too(tmp_path):
    edges = '[orifice]\npart = "edges/4wrpeh-6-40"\n'
    numbers = 'gain = "0.1 mm/V"\nmax_opening = "1 mm"\n'
    (tmp_path / "slow.toml").write_text(f'type = "FirstOrderValve"\ntime_constant = "2 ms"\n{numbers}{edges}')
    (tmp_path / "static.toml").write_text(f'type = "StaticValve"\n{numbers}{edges}')
    _, amplitude, _ = hs.part(tmp_path / "slow.toml").sheet.panels
    corner = 1.0 / (2.0 * math.pi * 2e-3)
    curve = amplitude.curves[0]
    assert abs(np.interp(corner, curve.x, curve.y) + 10.0 * math.log10(2.0)) < 0.01
    assert len(hs.part(tmp_path / "static.toml").sheet.panels) == 1


def test_a_block_without_a_data_sheet_has_its_numbers_alone(tmp_path):
    (tmp_path / "encoder.toml").write_text('type = "Encoder"\nresolution = "1 um"\n')
    found = hs.part(tmp_path / "encoder.toml")
    assert [one[:2] for one in found.numbers] == [("type", "Encoder"), ("resolution", "1 um")]
    with pytest.raises(ParameterError, match="nothing that a picture shows"):
        hs.plot(found)


def test_numbers_come_with_their_own_source_and_that_of_the_part_within(folder):
    found = hs.part(folder / "ours" / "valve.toml")
    sources = {one.key: one.source for one in found.numbers}
    assert found.source == "data sheet 12, p. 3"
    assert (sources["gain"], sources["orifice.lap"]) == ("", "")
    assert "p. 5" in sources["frequency_90"]
    assert "RE 29121" in sources["orifice.rated_flow"]


def test_parts_lists_a_folder_of_ones_own_too(folder):
    path = str(folder / "ours" / "valve.toml")
    assert path not in hs.parts()
    assert hs.parts(folder)[path] == "A valve of ours"
    assert part_sources(folder)[path].source == "data sheet 12, p. 3"
    with pytest.raises(ParameterError, match="must be a folder"):
        hs.parts(folder / "nowhere")


def test_a_page_may_name_built_in_parts_alone(tmp_path):
    home = Home("axis/position", (), tmp_path)
    assert page_source({"changes": {"valve.orifice.part": "edges/4wrpeh-6-40"}}, home).assemble()
    for request in (
        {"changes": {"valve.part": "secret.toml"}},
        {"text": 'base = "axis/position"\nvalve.part = "secret.toml"'},
    ):
        with pytest.raises(ScenarioError, match="names a file, which a page may not read"):
            page_source(request, home)
