"""Units as text: a strict grammar here, the meaning of each name from a table that pint made."""

import json
import re
from collections.abc import Iterator
from fractions import Fraction
from functools import cache, lru_cache
from importlib.resources import files
from itertools import accumulate
from typing import Any

from hydroservo.core.errors import nearest, short
from hydroservo.core.field import CONTROLLED


class OffsetUnitError(ValueError):
    """A unit with an offset or a logarithm, such as °C or dB, whose numbers a factor does not convert."""


Dimension = dict[str, Fraction]  # exponent of each base unit, the radian among them

NAME = r"%|°[CF]?|[A-Za-zµμΩ](?:[A-Za-zµμΩ_]|[0-9]+(?=[A-Za-z]))*"  # digits inside a name: inH2O
FACTOR = re.compile(
    rf"(?P<name>{NAME})"
    r"(?:\^\((?P<ratio>[+-]?[0-9]{1,2}(?:/[0-9]{1,2})?)\)"  # m^(2/7)
    r"|\^(?P<decimal>[+-]?[0-9]{1,2}(?:\.[0-9]{1,17})?)"  # m^2, m^0.5
    r"|(?P<digits>[+-]?[0-9]{1,2}))?"  # cm2, s-1
)
POWER_SIGN = re.compile(r"\s*(?:\^|\*\*)\s*")
BRACKETED = re.compile(r"\((?P<inner>.+)\)(?:\^?(?P<power>[+-]?[0-9]{1,2}))?")  # (m/s), (m/s)^2
DIVISION = re.compile(r"\s*/\s*")
PRODUCT = re.compile(
    r"\s*[*·]\s*|\s+|\.(?=[A-Za-zµμΩ_])"
)  # _: a bracket, as split_outside_brackets leaves it
JOINED = re.compile(
    r"([kMm]?(?:N|Pa|V|A|W))([cm]?m)?(s)?|(kg)([cm]?m)"
)  # Nm, Vs, kgm2: names that are not spaced
SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
# Coherent units that stand in for others: of one name each, and of several.
NAMED = ("m", "kg", "s", "A", "K", "rad", "N", "Pa", "J", "W", "C", "V", "ohm", "F")
COMPOUND = ("", "m^2", "m^3", "m/s", "rad/s", "m^3/s", "m^3/(s Pa)")
ABSOLUTE = {"bara": "bar", "psia": "psi"}


@lru_cache(maxsize=1024)
def factor_and_dimension(text: str) -> tuple[Fraction, Dimension]:
    """A unit as a factor times base units.

    The grammar is that of "V s/m", "m^3/(s Pa)", "V/(m/s)", "cm2", "Nm", "m^(2/7)/s^(9/7)"; after a stroke,
    more than one name needs brackets. Angles are a dimension of their own, so that 1 Hz, a cycle per second,
    is 2 pi rad/s.
    """
    factor, dimension = Fraction(1), dict[str, Fraction]()
    try:
        for name, exponent in unit_powers(text):
            one, bases = unit_of_name(name)
            factor *= Fraction(one**exponent)
            for base, power in bases.items():
                dimension[base] = dimension.get(base, Fraction(0)) + power * exponent
    except ArithmeticError:
        raise ValueError("has a unit that is out of range") from None
    return factor, {base: power for base, power in dimension.items() if power}


def power_of(name: str, text: str) -> Fraction:
    """The power of a name in a unit, 0 where it is not in it."""
    return sum((power for one, power in unit_powers(text) if one == name), Fraction(0))


def unit_powers(text: str) -> Iterator[tuple[str, Fraction]]:
    """The names in a unit with their exponents."""
    return parse_quotient(POWER_SIGN.sub("^", text.translate(SUPERSCRIPTS)).strip())


def parse_quotient(text: str) -> Iterator[tuple[str, Fraction]]:
    numerator, *denominators = split_outside_brackets(DIVISION, text)
    if numerator not in ("", "1"):
        yield from parse_product(numerator)
    for denominator in denominators:
        if len(split_outside_brackets(PRODUCT, denominator)) > 1:
            raise ValueError(f"is ambiguous after the stroke; write /({denominator})")
        for name, exponent in parse_product(denominator):
            yield name, -exponent


def parse_product(text: str) -> Iterator[tuple[str, Fraction]]:
    for part in split_outside_brackets(PRODUCT, text):
        if bracketed := BRACKETED.fullmatch(part):
            power = int(bracketed["power"] or 1)
            yield from (
                (name, power * exponent) for name, exponent in parse_quotient(bracketed["inner"].strip())
            )
            continue
        factor = FACTOR.fullmatch(part)
        if factor is None:
            raise ValueError(f"has a unit that cannot be read at {short(part)}")
        *others, name = joined_names(factor["name"])
        yield from ((other, Fraction(1)) for other in others)
        yield name, Fraction(factor["ratio"] or factor["decimal"] or factor["digits"] or "1")


def split_outside_brackets(separator: re.Pattern[str], text: str) -> list[str]:
    """The parts of a text between separators that stand in no brackets."""
    depths = accumulate((sign == "(") - (sign == ")") for sign in text)
    flat = "".join("_" if depth or sign == ")" else sign for sign, depth in zip(text, depths, strict=True))
    spans = [found.span() for found in separator.finditer(flat)]
    starts, ends = [0, *(end for _, end in spans)], [*(start for start, _ in spans), len(text)]
    return [text[start:end] for start, end in zip(starts, ends, strict=True)]


def joined_names(name: str) -> list[str]:
    """The names that are written as one, as datasheets write N m: Nm."""
    joined = JOINED.fullmatch(name)
    return [part for part in joined.groups() if part] if joined else [name]


@lru_cache(maxsize=1024)
def unit_of_name(name: str) -> tuple[Fraction, Dimension]:
    """One unit name as a factor times base units."""
    if name in ABSOLUTE:
        problem = f"has the unit {name}, of absolute pressures; give the pressure above the atmosphere's"
        raise ValueError(f"{problem}, in {ABSOLUTE[name]}")
    reading = next(readings(name), None)
    if reading is None:
        lower = f"; did you mean {name.lower()}?" if any(readings(name.lower())) else ""
        near = case_hint(name) or lower or nearest(name, unit_names()["units"])
        raise ValueError(f"has the unknown unit {name}{near}")
    prefix, (factor, bases) = reading
    if not factor and prefix != "1":
        raise ValueError(f"has the unit {name}, which cannot be read")
    if not factor:
        raise OffsetUnitError(f"has the unit {name}, which has an offset or a logarithm")
    return Fraction(prefix) * Fraction(factor), {base: Fraction(power) for base, power in bases.items()}


def readings(name: str) -> Iterator[tuple[str, Any]]:
    """What a name may mean, the likeliest first: the factor of its prefix, and its unit."""
    names = unit_names()
    if name in names["alone"]:
        yield "1", names["alone"][name]
    for end in ("", "s"):
        for prefix, factor in names["prefixes"].items():
            middle = name[len(prefix) : len(name) - len(end)]
            if name == prefix + middle + end and middle in names["units"] and len(middle) > len(end):
                yield factor, names["units"][middle]


@cache
def unit_names() -> dict[str, Any]:
    """Prefixes and units by name, as pint has them; ``scripts/unit_names`` asked it."""
    return dict(json.loads(files("hydroservo.scenario").joinpath("unit_names.json").read_text("utf-8")))


def case_hint(text: str) -> str:
    """The usual name that a name in a unit differs from by its case alone, as a question; "" if none does."""
    every = unit_names()["usual"]
    names = [name for name, _ in unit_powers(text) if name not in every]
    pairs = ((name, usual) for name in names for usual in every if usual.lower() == name.lower())
    return next((f"; did you mean {usual}?" for _, usual in pairs), "")


def check_si(text: str) -> None:
    """Refuse a unit that is not coherent SI, as mm, bar and deg are not.

    Hz, a cycle per second, may stand for a frequency, and y for the unit of what a loop controls.
    """
    if all(name == CONTROLLED or is_coherent(name) for name, _ in unit_powers(text)):
        return
    instead = coherent_unit(text)
    way = "units without prefixes, such as m, kg, s, Pa and rad" if instead is None else repr(instead)
    raise ValueError(f"is not SI: declare it in {way}; scenarios may still give {text}")


def is_coherent(name: str) -> bool:
    """Whether a unit is one of the SI's own; pint's base of mass is the gram, of angle the radian."""
    factor, bases = unit_of_name(name)
    return name == "Hz" or factor == Fraction(1000) ** bases.get("gram", Fraction(0))


def coherent_unit(text: str) -> str | None:
    """A unit with each name exchanged for SI's, or one of a few; None where neither can be."""
    same = {name: unit_of_dimension(name, NAMED) for name, _ in unit_powers(text) if not is_coherent(name)}
    if None not in same.values():
        return re.sub(NAME, lambda found: same.get(found[0]) or found[0], text)
    return unit_of_dimension(text, COMPOUND)


def unit_of_dimension(text: str, units: tuple[str, ...]) -> str | None:
    """The first of some units that has the dimension of another."""
    dimension = factor_and_dimension(text)[1]
    return next((unit for unit in units if factor_and_dimension(unit)[1] == dimension), None)
