"""Quantities as an engineer writes them, and text that is none."""

import math
import re
import runpy
import time
from contextlib import suppress
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.scenario.quantities import si_value, unit_factor
from hydroservo.scenario.units import check_si, unit_names, unit_of_name

QUANTITIES = [
    ("40 bar", "Pa", 40e5),
    ("0 bar", "Pa", 0.0),
    ("4.91 cm^2", "m^2", 4.91e-4),
    ("4.91 cm2", "m^2", 4.91e-4),
    ("4.91 cm²", "m^2", 4.91e-4),
    ("4.91cm**2", "m^2", 4.91e-4),
    ("30 mm/s", "m/s", 0.03),
    ("-30 mm/s", "m/s", -0.03),
    ("+.5e2 mm s-1", "m/s", 0.05),
    ("10 us", "s", 1e-5),
    ("10 µs", "s", 1e-5),
    ("0.1 ms", "s", 1e-4),
    ("60 L/min", "m^3/s", 1e-3),
    ("1 gpm", "m^3/s", 3.785411784e-3 / 60.0),
    ("60 l/min", "m^3/s", 1e-3),
    ("60 lpm", "m^3/s", 1e-3),
    ("60 LPM", "m^3/s", 1e-3),
    ("6 lpm/bar", "m^3/(s Pa)", 1e-9),
    ("2.5e-11 m^3/(s Pa)", "m^3/(s Pa)", 2.5e-11),
    ("2.5e-11 m³/(s·Pa)", "m^3/(s Pa)", 2.5e-11),
    ("2.5 cm^3/(s bar)", "m^3/(s Pa)", 2.5e-11),
    ("10 %", "", 0.1),
    ("10%", "", 0.1),
    ("5e-4 m/V", "m/V", 5e-4),
    ("100 V s/m", "V s/m", 100.0),
    ("1000/s", "1/s", 1000.0),
    ("1000 1/s", "1/s", 1000.0),
    ("50 N*s/m", "N s/m", 50.0),
    ("0.25 Hz", "Hz", 0.25),
    ("15 rpm", "Hz", 0.25),
    ("2 kHz", "Hz", 2000.0),
    ("90 deg", "rad", math.pi / 2),
    ("90°", "rad", math.pi / 2),
    ("5/7", "", 5 / 7),
    ("5 / 9", "", 5 / 9),
    ("1 m^(2/7)/s^(9/7)", "m^(2/7)/s^(9/7)", 1.0),
    ("10 N^(2/7)/s", "N^(2/7)/s", 10.0),
    ("100 kgf", "N", 980.665),
    ("100 kp", "N", 980.665),
    ("20 Nm", "N m", 20.0),
    ("20 N.m", "N m", 20.0),
    ("20 Ncm", "N m", 0.2),
    ("8 kNs/m", "N s/m", 8000.0),
    ("2 Nms/rad", "N m s/rad", 2.0),
    ("3 kgm2", "kg m^2", 3.0),
    ("32 mPas", "Pa s", 0.032),
    ("0.4 Vs/m", "V s/m", 0.4),
    ("0.4 V/(mm/s)", "V s/m", 400.0),
    ("4 V.(s/m)", "V s/m", 4.0),
    ("4 V/(m/s)^2", "V s^2/m^2", 4.0),
    ("6 (L/min)/bar", "m^3/(s Pa)", 1e-9),
    ("6 (L/min)/(bar)", "m^3/(s Pa)", 1e-9),
    ("1 ((m))", "m", 1.0),
    ("100 lbm", "kg", 45.359237),
    ("207 barg", "Pa", 207e5),
    ("1 psig", "Pa", 8896443230521 / 1290320000),
]

WRONG = [
    ("40 bar", "m", "does not convert to m"),
    ("40 mm", "", "is not dimensionless"),
    ("40", "Pa", "has no unit; write '40 Pa'"),
    ("40 ()", "", "has a unit that cannot be read"),
    ("40 Bar", "Pa", "unknown unit Bar; did you mean bar?"),
    ("80 Kg", "kg", "unknown unit Kg; did you mean kg?"),
    ("80 furlings", "m", "unknown unit furlings; did you mean furlong?"),
    ("1,5 mm", "m", "has a decimal comma; write '1.5 mm'"),
    ("-1.140,5 kg", "kg", "has a decimal comma; write '-1140.5 kg'"),
    ("1,140 kg", "kg", "has a comma; write '1.140 kg' or '1140 kg'"),
    ("1 140 kg", "kg", "separates thousands; write '1140 kg'"),
    ("1'140.5 kg", "kg", "separates thousands; write '1140.5 kg'"),
    ("12,000,000 Pa", "Pa", "separates thousands; write '12000000 Pa'"),
    ("2*100 mm", "m", "cannot be read"),
    ("3*105 Pa", "Pa", "cannot be read"),
    ("3·10⁵ Pa", "Pa", "write '3e5 Pa'"),
    ("100..140 kg", "kg", "is a range; give one number here"),
    ("100 kg..140 kg", "kg", "is a range; give one number here"),
    ("100 to 140 kg", "kg", "is a range; give one number here"),
    ("100-140 kg", "kg", "is a range; give one number here"),
    ("1.4*10^2 kg", "kg", "is a product; write '1.4e2 kg'"),
    ("1.4\N{MULTIPLICATION SIGN}10⁻² kg", "kg", "is a product; write '1.4e-2 kg'"),
    ("140 [kg]", "kg", "has brackets around its unit; write '140 kg'"),
    ("15 Mpa", "Pa", "unknown unit Mpa; did you mean MPa?"),
    ("5 khz", "Hz", "unknown unit khz; did you mean kHz?"),
    ("24 L/Min", "m^3/s", "does not convert to m^3/s; did you mean min?"),
    (
        "207 bara",
        "Pa",
        "has the unit bara, of absolute pressures; give the pressure above the atmosphere's, in bar",
    ),
    ("5e-4 foo", "m", "unknown unit foo"),
    ("bar", "Pa", "is not a quantity such as '40 bar'"),
    ("", "Pa", "is not a quantity"),
    ("nan Pa", "Pa", "is not a quantity"),
    ("inf Pa", "Pa", "is not a quantity"),
    ("5/0", "", "is not a finite number"),
    ("1e99 Ym^99", "m^99", "is not a finite number"),
    ("9**9**9 m", "m", "cannot be read"),
    ("1e999 m", "m", "cannot be read"),
    ("1 m^999", "m", "cannot be read"),
    ("1 m^(9^9)", "m", "cannot be read"),
    ("1 m^99^99", "m", "cannot be read"),
    ("1 m^(1/0)", "m", "out of range"),
    ("1 ((((m)))", "m", "cannot be read"),
    ("1 m)(", "m", "cannot be read"),
    ("1 (m", "m", "cannot be read"),
    ("1 m/", "m", "cannot be read"),
    ("1 m/s Pa", "m", "ambiguous after the stroke; write /(s Pa)"),
    ("1 __import__('os')", "m", "cannot be read"),
    ("0x10 m", "m", "unknown unit x"),
    ("1_0 m", "m", "cannot be read"),
    ("20 degC", "K", "offset"),
    ("3 dB", "", "logarithm"),
    ("3 mdB", "", "cannot be read"),
    ("9" * 65 + " m", "m", "is not a quantity"),
    ("1 " + "m " * 40, "m", "is not a quantity"),
]


@pytest.mark.parametrize(("text", "unit", "value"), QUANTITIES)
def test_quantity(text: str, unit: str, value: float) -> None:
    assert si_value(text, unit) == value  # to the last bit: "10 us" is the number 1e-5


@pytest.mark.parametrize(("text", "unit", "problem"), WRONG)
def test_wrong_quantity(text: str, unit: str, problem: str) -> None:
    start = time.perf_counter()
    with pytest.raises(ValueError, match=re.escape(problem)):
        si_value(text, unit)
    assert time.perf_counter() - start < 0.1


def test_a_cycle_is_not_a_radian() -> None:
    assert si_value("1 rad/s", "Hz") == pytest.approx(1 / (2 * math.pi), rel=1e-15)
    with pytest.raises(ValueError, match="does not convert to 1/s"):
        si_value("2 Hz", "1/s")  # of a gain: by a factor of 2 pi or not?


def test_unit_factor_is_exact() -> None:
    assert unit_factor("us", "s").denominator == 10**6


@given(
    st.floats(1e-30, 1e30, allow_nan=False),
    st.sampled_from([("mm", "m", 3), ("us", "s", 6), ("MPa", "Pa", -6)]),
)
def test_conversion_is_correctly_rounded(number: float, unit: tuple[str, str, int]) -> None:
    name, si, places = unit
    mantissa, _, exponent = f"{number:.16e}".partition("e")
    assert si_value(f"{mantissa}e{exponent} {name}", si) == float(f"{mantissa}e{int(exponent) - places}")


@given(st.text(max_size=80), st.sampled_from(["m", "", "Hz", "m^3/(s Pa)"]))
def test_any_text_is_a_number_or_a_value_error(text: str, unit: str) -> None:
    for candidate in (text, f"1 {text}"):
        try:
            value = si_value(candidate, unit)
        except ValueError:
            continue
        assert math.isfinite(value)


UNIT_PIECES = st.lists(
    st.sampled_from(
        [
            "m",
            "s",
            "kg",
            "Pa",
            "bar",
            "dB",
            "degC",
            "Hz",
            "1",
            "/",
            "*",
            "^",
            "(",
            ")",
            " ",
            "9",
            "-",
            ".5",
            "%",
        ]
    ),
    max_size=14,
)


@given(UNIT_PIECES)
def test_any_unit_is_a_unit_or_a_value_error(pieces: list[str]) -> None:
    with suppress(ValueError):
        assert unit_factor("".join(pieces), "m") > 0


@pytest.mark.parametrize(
    "unit", ["", "1/s", "m", "kg", "rad", "rad/s", "Hz", "V s/m", "N m", "m^3/(s Pa)", "m^(2/7)/s^(9/7)", "K"]
)
def test_coherent_units(unit: str) -> None:
    check_si(unit)


@pytest.mark.parametrize(
    ("unit", "instead"),
    [
        ("mm", "m"),
        ("g", "kg"),
        ("bar", "Pa"),
        ("deg", "rad"),
        ("rpm", "rad/s"),
        ("%", ""),
        ("L/min", "m^3/s"),
        ("mm/V", "m/V"),
        ("N mm", "N m"),
        ("cm2/kN", "m2/N"),
    ],
)
def test_what_to_write_for_a_unit_that_is_not_coherent(unit: str, instead: str) -> None:
    with pytest.raises(
        ValueError, match=f"^is not SI: declare it in {re.escape(repr(instead))}; scenarios may"
    ):
        check_si(unit)


@pytest.mark.parametrize("unit", ["L/bar", "°C", "V-s", "xyz"])
def test_units_for_which_there_is_no_simple_one(unit: str) -> None:
    with pytest.raises(ValueError, match=r"is not SI: declare it in units without|has "):
        check_si(unit)


def test_the_table_of_units_is_what_pint_says_of_them() -> None:
    root = Path(__file__).parents[2]
    written = runpy.run_path(str(root / "scripts/unit_names"))["written"]()
    assert (root / "src/hydroservo/scenario/unit_names.json").read_text("utf-8") == written


PINT: Any = pint.UnitRegistry(non_int_type=Fraction)
EACH = ("m", "meter", "bar", "psi", "t", "in", "inch", "gal", "N", "lbf", "min", "dB", "degC", "x")


def read_by_pint(name: str) -> tuple[Fraction, dict[str, Fraction]] | None:
    """A unit as a factor times base units; None where it is no unit, or more than a factor."""
    try:
        unit = PINT.parse_units(name)
    except (pint.UndefinedUnitError, pint.OffsetUnitCalculusError):
        return None
    factor, bases = PINT.get_root_units(unit)
    return (factor, dict(bases._units)) if PINT.Quantity(1, unit)._is_multiplicative else None


def test_prefixes_and_plurals_are_read_as_pint_reads_them() -> None:
    for prefix, unit, end in product(unit_names()["prefixes"], EACH, ("", "s")):
        name = f"{prefix}{unit}{end}"
        if expected := read_by_pint(name):
            assert unit_of_name(name) == expected, name
        else:
            with pytest.raises(ValueError, match="has the"):
                unit_of_name(name)
