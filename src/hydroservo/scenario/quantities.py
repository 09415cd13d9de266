"""Numbers with units, as text."""

import re
from fractions import Fraction
from functools import lru_cache

from hydroservo.command_scale import CommandScale, command_scale
from hydroservo.scenario.slips import quantity_slip
from hydroservo.scenario.units import case_hint, factor_and_dimension, power_of
from hydroservo.unit_algebra import exchanged, power_in

LONGEST = 64  # characters of a quantity
# An exponent has two digits at most, so that no text costs more than a few microseconds to evaluate.
RATIO = r"[+-]?[0-9]+\s*/\s*[0-9]+"
DECIMAL = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,2}(?![0-9]))?"
QUANTITY = re.compile(rf"({RATIO}|{DECIMAL})\s*(.*)", re.DOTALL)
EXAMPLES = {"m": "30 mm", "m/s": "30 mm/s", "m^2": "4.91 cm^2", "Pa": "40 bar", "s": "10 us", "": "5/7"}


def si_value(text: str, unit: str) -> float:
    """The number in an SI unit that a text such as "40 bar" says, correctly rounded.

    Args:
        text: a number and a unit of the same dimension; a number, or a ratio of two, where ``unit`` is "".
            Where that has V in it, mA or % of command count too as :class:`~.CommandScale` has it.
        unit: the SI unit of the result, as :class:`~hydroservo.field.Field` has it.
    """
    try:
        return value_of(text.strip().replace("\N{MINUS SIGN}", "-"), unit, command_scale())
    except ValueError as error:
        raise ValueError((quantity_slip(text) if len(text) <= LONGEST else "") or str(error)) from None


@lru_cache(maxsize=4096)
def value_of(text: str, unit: str, scale: CommandScale) -> float:
    """The number in an SI unit that a text says, as :func:`si_value` gives it."""
    number, given = number_and_unit(text, unit)
    if unit and not given:
        raise ValueError(f"has no unit; write '{text} {unit}', or the number without quotes")
    try:
        return float(number * scaled_factor(given, unit, scale))
    except ArithmeticError:  # overflow
        raise ValueError("is not a finite number") from None


def number_and_unit(text: str, unit: str = "") -> tuple[Fraction, str]:
    """The two parts of a quantity.

    Args:
        text: such as "0.25 V/mA".
        unit: the SI unit that an example in the message has.
    """
    match = QUANTITY.fullmatch(text.strip()) if len(text) <= LONGEST else None
    if match is None:
        raise ValueError(f"is not a quantity such as '{EXAMPLES.get(unit, f'1.5 {unit}')}'")
    try:
        return Fraction(re.sub(r"\s", "", match[1])), match[2]
    except ArithmeticError:  # division by zero
        raise ValueError("is not a finite number") from None


def unit_factor(text: str, unit: str | None) -> Fraction:
    """How many of an SI unit one of the unit in a text is.

    Args:
        text: the unit; mA and % count as V where commands are in them.
        unit: the SI unit; None for that of the text's own dimension.
    """
    return scaled_factor(text, unit, command_scale())


@lru_cache(maxsize=1024)
def scaled_factor(text: str, unit: str | None, scale: CommandScale) -> Fraction:
    """As :func:`unit_factor`, with commands in a scale."""
    if len(text) > LONGEST:
        raise ValueError(f"has a unit of more than {LONGEST} characters")
    factor, dimension = factor_and_dimension(text)
    if unit is None:
        return factor / Fraction(Fraction(1000) ** dimension.get("gram", Fraction(0)))  # the kilogram is SI's
    factor_si, dimension_si = factor_and_dimension(unit)
    if dimension == dimension_si:
        return factor / factor_si
    volts = power_in(unit, "V")
    if volts and scale.unit != "V" and (found := factor_as(text, unit, scale.unit)):
        return found / scale.per_volt**volts
    problem = f"does not convert to {unit}" if unit else "is not dimensionless"
    raise ValueError(f"{problem}{case_hint(text)}{advice(text, unit, scale) if volts else ''}")


def factor_as(text: str, unit: str, command: str) -> Fraction | None:
    """How many of a unit with that of commands in place of V one of another is; None if it is not of it."""
    own = exchanged(unit, "V", command)
    (factor, dimension), (factor_own, dimension_own) = map(factor_and_dimension, (text, own))
    alike = dimension == dimension_own and power_of("%", text) == power_of("%", own)
    return factor / factor_own if alike else None


def advice(text: str, unit: str, scale: CommandScale) -> str:
    """What lets a command be in the unit of a text, or in which it is; "" where it would be in neither."""
    if scale.unit != "V":
        return f" or {exchanged(unit, 'V', scale.unit)}, as commands are by [command] full_scale"
    known = {"A": "40 mA", "%": "100 %"}
    example = next((known[one] for one in known if factor_as(text, unit, one)), "")
    return example and f'; add [command] full_scale = "{example}", or what else 10 V stand for'
