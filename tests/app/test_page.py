"""The page in a real browser: a mistake is said where it is made. What else users do is in the journeys."""

import pytest

from tests.support.browser import MASS, answered, enter, field, in_full_contrast, numbers_shown, problem

pytestmark = pytest.mark.slow


def test_a_wrong_unit_is_said_at_its_field_and_undone(page):
    enter(page, MASS, "80 bar")
    problem(page, MASS).wait_for()
    assert "does not convert to kg" in problem(page, MASS).inner_text()
    assert field(page, MASS).get_attribute("aria-invalid") == "true"
    assert in_full_contrast(problem(page, MASS))
    assert numbers_shown(page) == []
    page.keyboard.press("Control+z")
    answered(page)
    assert not problem(page, MASS).is_visible()
    assert field(page, MASS).input_value() == "160 kg"
