"""Numbers, units and columns as they are read."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.core.formatting import (
    MINUS,
    NONE,
    TIMES,
    Scale,
    column,
    common_unit,
    number,
    quantity,
    readable_unit,
    scales_of,
)


@pytest.mark.parametrize(
    ("unit", "largest", "shown"),
    [
        ("m/s", 0.03, ("mm/s", 1e3)),
        ("m", 0.078, ("mm", 1e3)),
        ("V", 0.029, ("mV", 1e3)),
        ("V", 1.0, ("V", 1.0)),
        ("N/s", 9999.0, ("N/s", 1.0)),
        ("N/s", 1e5, ("kN/s", 1e-3)),
        ("N/s", 1e7, ("MN/s", 1e-6)),
        ("m/s^2", 16.7, ("m/s²", 1.0)),
        ("s", 1.0, ("s", 1.0)),
        ("s", 0.04, ("ms", 1e3)),
        ("s", 1e-5, ("µs", 1e6)),
        ("s", 0.0, ("s", 1.0)),
        ("Pa", 4e6, ("bar", 1e-5)),
        ("Pa", 100.0, ("bar", 1e-5)),
        ("m^2", 4.91e-4, ("cm²", 1e4)),
        ("m^3", 4e-5, ("cm³", 1e6)),
        ("m^3/s", 3e-4, ("L/min", 6e4)),
        ("m/V", 1e-4, ("mm/V", 1e3)),
        ("", 1.0, ("", 1.0)),
    ],
)
def test_units_are_those_an_engineer_reads(unit, largest, shown):
    assert readable_unit(unit, largest) == shown


@pytest.mark.parametrize(
    ("unit", "largest"),
    [
        ("m/s", 0.1),
        ("m", 0.1),
        ("V", 0.1),
        ("N/s", 1e5),
        ("Pa", 1e6),
        ("s", 0.1),
        ("s", 1e-5),
        ("m^2", 1e-3),
        ("m^3", 1e-5),
        ("m^3/s", 1e-4),
        ("m/V", 1e-4),
    ],
)
def test_factors_agree_with_the_units_library(unit, largest):
    import pint

    shown, factor = readable_unit(unit, largest)
    assert pint.Quantity(1.0, unit).to(shown).magnitude == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(
    ("values", "unit"),
    [([0.5, -1.2], ("V", 1.0)), ([0.5, math.inf], ("mV", 1e3)), ([math.nan], ("mV", 1e3)), ([], ("mV", 1e3))],
)
def test_a_common_unit_suits_the_largest_finite_number(values, unit):
    assert common_unit(values, "V") == unit


def test_a_column_has_one_unit_and_a_dash_where_there_is_no_number():
    assert column(iter([0.04, 2e-5, math.nan]), "s") == ("ms", ["40.0", "0.0200", NONE])


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (0.24, "0.240"),
        (27.96, "28.0"),
        (9.996, "10.0"),
        (9654.1, "9650"),
        (-16.716, f"{MINUS}16.7"),
        (99999.0, f"1.00 {TIMES} 10⁵"),
        (6.2796e-4, f"6.28 {TIMES} 10⁻⁴"),
        (-1.7e-12, f"{MINUS}1.70 {TIMES} 10⁻¹²"),
        (math.inf, "∞"),
        (-math.inf, f"{MINUS}∞"),
        (math.nan, "no number"),
    ],
)
def test_numbers_are_read_with_three_digits(value, text):
    assert number(value) == text


@given(st.floats(-1e300, 1e300))
def test_a_number_as_read_is_within_half_a_unit_of_its_last_digit(value):
    text = number(value).replace(MINUS, "-").translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    read = float(text.replace(f" {TIMES} 10", "e"))
    assert read == pytest.approx(value, rel=5.001e-3, abs=1e-320)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.00026589, "m/s", "0.266 mm/s"),
        (0.0268, "V", "26.8 mV"),
        (5.986, "V", "5.99 V"),
        (171024.3, "N/s", "171 kN/s"),
        (466.0, "N/s", "466 N/s"),
        (0.00696, "s", "6.96 ms"),
        (1e-5, "s", "10.0 µs"),
        (2.0, "s", "2.00 s"),
        (0.0, "s", "0 s"),
        (3.0, "m/s^2", "3.00 m/s²"),
        (math.inf, "m", "∞"),
        (0.5, "", "0.500"),
    ],
)
def test_quantities_have_the_unit_an_engineer_reads(value, unit, text):
    assert quantity(value, unit) == text


def test_rows_of_one_quantity_have_one_unit():
    rows = [("V", [0.2, -0.3]), ("V", [2.0]), ("m^3", [1e-4]), ("s", [0.01]), ("s", [math.nan])]
    cubic = Scale("ml", 1e6)
    assert scales_of(rows) == {"V": ("V", 1.0, 0.0), "m^3": ("cm³", 1e6, 0.0), "s": ("ms", 1e3, 0.0)}
    assert scales_of(rows, {"m^3": cubic, "Pa": Scale("psi", 1.0)})["m^3"] == cubic


def test_temperatures_are_read_in_degrees_celsius():
    assert quantity(313.15, "K") == "40.0 degC"
    assert column([293.15, 353.15], "K") == ("degC", ["20.0", "80.0"])
