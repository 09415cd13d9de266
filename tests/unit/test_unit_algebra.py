"""Units in which one name is exchanged for another unit."""

import pytest

from hydroservo import Field
from hydroservo.core.field import exchanged
from hydroservo.scenario.units import factor_and_dimension


@pytest.mark.parametrize(
    ("unit", "other", "found"),
    [
        ("y", "m", "m"),
        ("y/s", "m/s", "m/s^2"),
        ("y/s^2", "N", "N/s^2"),
        ("V/y", "m/s", "V s/m"),
        ("V/(y s)", "m/s", "V/m"),
        ("V/(y s)", "Pa", "V/(Pa s)"),
        ("V s/y", "m", "V s/m"),
        ("y^2 s", "m/s", "m^2/s"),
        ("V/y", "V", ""),
        ("1/s", "m", "1/s"),
        ("m^(2/7)/s^(9/7)", "m", "m^(2/7)/s^(9/7)"),
        ("", "m", ""),
    ],
)
def test_exchanged(unit: str, other: str, found: str) -> None:
    assert exchanged(unit, "y", other) == found


@pytest.mark.parametrize("unit", ["y", "y/s", "y/s^2", "V/y", "V s/y", "V/(y s)", "y^2 s", "y s^2"])
@pytest.mark.parametrize("other", ["m/s", "m", "N", "Pa", "V"])
def test_it_is_the_unit_that_pint_makes_of_it(unit: str, other: str) -> None:
    """With the other unit in brackets, by pint's own algebra."""
    import pint

    registry = pint.UnitRegistry()
    wanted = registry.parse_units(unit.replace("y", f"({other})").replace(" ", "*"))
    found = registry.parse_units(exchanged(unit, "y", other).replace(" ", "*"))
    assert wanted == found
    factor_and_dimension(exchanged(unit, "y", other))  # and scenarios can read it


def test_a_field_follows_the_signal() -> None:
    field = Field("V/y", "gain on the {y} error", above=0)
    assert field.of(Field("m", "position")) == Field("V/m", "gain on the position error", above=0)
    assert field.of(Field("y", "{y}")) == field
