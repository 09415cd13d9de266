"""What was refused, or is not entered yet, has no number of another loop beside it, in a real browser."""

import pytest

from hydroservo.core.formatting import NONE
from tests.support.browser import MASS, answered, enter, field, in_full_contrast, numbers_shown, problem

pytestmark = pytest.mark.nightly

MARGIN = f"#margins dd:not(:text-is('{NONE}'))"


def test_undo_and_redo_lead_to_what_ran_alone(page):
    enter(page, MASS, "90 kg")
    answered(page)
    enter(page, MASS, "80 bar")
    problem(page, MASS).wait_for()
    enter(page, MASS, "-3 kg")
    problem(page, MASS).get_by_text("above 0").wait_for()
    seen = []
    for key in ("z", "z", "Shift+Z"):
        page.keyboard.press(f"Control+{key}")
        answered(page)
        seen.append(field(page, MASS).input_value())
    assert seen == ["90 kg", "160 kg", "90 kg"]
    assert page.locator("#redo").is_disabled()


def test_a_bare_number_is_asked_for_in_the_unit_that_the_field_shows(page):
    shown = {"plant.stroke": "63 mm?", "sensors.area_a": "63 cm²?", "load.final": "63 kN?"}
    for path, advice in shown.items():
        enter(page, path, "63")
        problem(page, path).get_by_text(advice).wait_for()
        page.get_by_role("button", name="Go back").click()
        answered(page)


def test_what_is_typed_and_not_entered_has_no_numbers(page):
    enter(page, "load.final", "2 kN")  # the answers to which come while one types
    field(page, MASS).fill("90")
    assert numbers_shown(page) == []
    page.wait_for_timeout(1500)
    assert numbers_shown(page) == []
    assert field(page, MASS).input_value() == "90"
    field(page, MASS).fill("160 kg")
    answered(page)
    assert len(numbers_shown(page)) > 10


def test_margins_wait_for_a_slider_that_undo_takes_back_whole(page):
    page.wait_for_selector(MARGIN)
    page.locator(f"[id='slider-{MASS}']").focus()
    for _ in range(4):
        page.keyboard.press("ArrowRight")
        page.wait_for_timeout(60)
    assert page.locator(MARGIN).count() == 0
    assert page.locator("#pin").is_disabled()
    page.wait_for_selector(MARGIN)
    page.wait_for_selector("#pin:enabled")
    page.keyboard.press("Control+z")
    answered(page)
    assert field(page, MASS).input_value() == "160 kg"


def test_a_refused_curve_takes_its_margins_away(page):
    page.wait_for_selector(MARGIN)
    law = "controller.controller.controller"
    enter(page, f"{law}.proportional_gain", "0 V/m")
    answered(page)
    enter(page, f"{law}.integral_gain", "0 V/(m s)")
    page.locator("#bode-problem", has_text="does not settle").wait_for()
    assert page.locator("#margins dd").count() == 0
    assert not page.locator("#bode").is_visible()
    page.keyboard.press("Control+z")
    page.wait_for_selector(MARGIN)


def test_a_refused_type_stays_with_its_message(page):
    page.locator("[id='type-load']").select_option("Recorded")
    problem(page, "load").get_by_text("a file is needed").wait_for()
    page.wait_for_timeout(1000)
    assert page.locator("[id='type-load']").input_value() == "Recorded"
    assert in_full_contrast(problem(page, "load"))
    assert not field(page, "load.final").is_visible()
    assert numbers_shown(page) == []
    page.keyboard.press("Control+z")
    answered(page)
    assert page.locator("[id='type-load']").input_value() == "Step"
    assert field(page, "load.final").is_visible()
    page.locator("[id='type-reference']").select_option("Ramp")
    page.locator("[id='needed-reference.initial']").fill("63")
    page.get_by_role("button", name="Take it").click()
    page.locator("[id='asked-reference.initial']", has_text="63 has no unit: 63 mm?").wait_for()
    assert page.locator("[id='type-reference']").input_value() == "Ramp"
    assert numbers_shown(page) == []


def test_a_refused_file_leaves_no_numbers(page, tmp_path):
    wrong = tmp_path / "wrong.toml"
    wrong.write_text("base = 5")
    page.locator("#open").set_input_files(wrong)
    page.locator("#problem", has_text="wrong.toml").wait_for()
    assert numbers_shown(page) == []
    page.get_by_role("button", name="Go back").click()
    answered(page)
    assert page.locator("#scenario").input_value() == "axis/position"
