"""Numbers with units, as text, and frequent slips in them."""

import re
from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache

from hydroservo.core.command_scale import CommandScale, command_scale
from hydroservo.core.field import exchanged, power_in
from hydroservo.scenario.units import case_hint, factor_and_dimension, power_of

SPACES = " '\N{RIGHT SINGLE QUOTATION MARK}\N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}"
NUMBER = r"[+-]?[0-9]+(?:\.[0-9]+)?"
COMMA = re.compile(
    rf"(?P<whole>[+-]?[0-9]+(?:[.{SPACES}][0-9]{{3}})*),(?P<part>[0-9]+)(?P<rest>[^0-9,.].*|)", re.DOTALL
)
THOUSANDS = re.compile(
    rf"(?P<number>[+-]?[0-9]{{1,3}}(?:[,{SPACES}][0-9]{{3}})+(?:\.[0-9]+)?)(?P<rest>[^0-9].*|)", re.DOTALL
)
RANGE = re.compile(
    rf"{NUMBER}\s*(?:[^\s0-9.]*\s*(?:\.\.+|…|\N{{EN DASH}}|\bto\b)|-)\s*{NUMBER}(?:\s.*|[^\s0-9.].*|)",
    re.DOTALL,
)
TEN = re.compile(
    rf"(?P<number>{NUMBER})\s*[*·\N{{MULTIPLICATION SIGN}}x]\s*10\s*"
    r"(?:\^|\*\*)\s*\(?(?P<power>[+-]?[0-9]{1,2})\)?(?P<rest>[^0-9].*|)",
    re.DOTALL,
)
RAISED = re.compile("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+")
SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
IN_BRACKETS = re.compile(rf"(?P<number>{NUMBER}(?:[eE][+-]?[0-9]+)?)\s*\[(?P<unit>[^\[\]]+)\]")

UNQUOTED = re.compile(rf"=\s*(?P<text>{NUMBER}(?:[eE][+-]?[0-9]+)?\s*[A-Za-zµμ°%Ω][^,}}\]#\"]*)")
DECIMAL_COMMA = re.compile(r"=\s*(?P<whole>[+-]?[0-9]+),(?P<part>[0-9]+)\s*(?:$|[#A-Za-z}\]])")
BARE_WORD = re.compile(r"=\s*(?P<text>[A-Za-z][\w.]*)\s*(?:$|[,}\]#])")
STRING = re.compile(r"\"[^\"]*\"|'[^']*'")
PLACE = re.compile(r"\(at line ([0-9]+), column [0-9]+\)$")
LONGEST = 64  # characters of a quantity
# An exponent has two digits at most, so that no text costs more than a few microseconds to evaluate.
RATIO = r"[+-]?[0-9]+\s*/\s*[0-9]+"
DECIMAL = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,2}(?![0-9]))?"
QUANTITY = re.compile(rf"({RATIO}|{DECIMAL})\s*(.*)", re.DOTALL)
EXAMPLES = {"m": "30 mm", "m/s": "30 mm/s", "m^2": "4.91 cm^2", "Pa": "40 bar", "s": "10 us", "": "5/7"}


def strip_signs(signs: str, text: str) -> str:
    return "".join(sign for sign in text if sign not in signs)


def comma_problem(match: re.Match[str]) -> str:
    whole, part, rest = strip_signs(f".{SPACES}", match["whole"]), match["part"], match["rest"]
    point = f"'{whole}.{part}{rest}'"
    if len(part) == 3 and len(whole.lstrip("+-")) <= 3:
        return f"has a comma; write {point} or '{whole}{part}{rest}'"
    return f"has a decimal comma; write {point}"


def thousands_problem(match: re.Match[str]) -> str:
    return f"separates thousands; write '{strip_signs(f',{SPACES}', match['number'])}{match['rest']}'"


SLIPS: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], str]], ...] = (
    (COMMA, comma_problem),
    (THOUSANDS, thousands_problem),
    (TEN, lambda match: f"is a product; write '{match['number']}e{int(match['power'])}{match['rest']}'"),
    (RANGE, lambda _: "is a range; give one number here (ranges are for batch, tune and identify)"),
    (IN_BRACKETS, lambda match: f"has brackets around its unit; write '{match['number']} {match['unit']}'"),
)


def quantity_slip(text: str) -> str:
    """Advice on a number as half of the world writes it; "" where there is none."""
    plain = RAISED.sub(lambda match: f"^{match[0].translate(SUPERSCRIPTS)}", text.strip())
    matches = ((slip.fullmatch(plain), problem) for slip, problem in SLIPS)
    return next((problem(match) for match, problem in matches if match), "")


def toml_slip(text: str, problem: str) -> str:
    """Advice on a text that is not TOML, to end a message with; "" where there is none."""
    lines, place = text.splitlines(), PLACE.search(problem)
    number = int(place[1]) if place else len(lines)
    line = lines[number - 1] if 0 < number <= len(lines) else ""
    if match := DECIMAL_COMMA.search(line):
        return f"; the decimal sign is a point: {match['whole']}.{match['part']}"
    if match := UNQUOTED.search(line):
        return f'; a number with a unit needs quotes: "{match["text"].strip()}"'
    if (match := BARE_WORD.search(line)) and match["text"] not in ("true", "false", "inf", "nan"):
        return f'; a text needs quotes: "{match["text"]}"'
    bare = STRING.sub("", line).partition("#")[0]
    return "; a table in braces is one line" if bare.count("{") > bare.count("}") else ""


def si_value(text: str, unit: str) -> float:
    """The number in an SI unit that a text such as "40 bar" says, correctly rounded.

    Args:
        text: a number and a unit of the same dimension; a number, or a ratio of two, where ``unit`` is "".
            Where that has V in it, mA or % of command count too as :class:`~.CommandScale` has it.
        unit: the SI unit of the result, as :class:`~hydroservo.core.field.Field` has it.
    """
    try:
        return cached_si_value(text.strip().replace("\N{MINUS SIGN}", "-"), unit, command_scale())
    except ValueError as error:
        raise ValueError((quantity_slip(text) if len(text) <= LONGEST else "") or str(error)) from None


@lru_cache(maxsize=4096)
def cached_si_value(text: str, unit: str, scale: CommandScale) -> float:
    """The number in an SI unit that a text says, as :func:`si_value` gives it."""
    number, given = number_and_unit(text, unit)
    if unit and not given:
        raise ValueError(f"has no unit; write '{text} {unit}', or the number without quotes")
    try:
        return float(number * cached_unit_factor(given, unit, scale))
    except ArithmeticError:  # overflow
        raise ValueError("is not a finite number") from None


def number_and_unit(text: str, unit: str = "") -> tuple[Fraction, str]:
    """The two parts of a quantity."""
    match = QUANTITY.fullmatch(text.strip()) if len(text) <= LONGEST else None
    if match is None:
        raise ValueError(f"is not a quantity such as '{EXAMPLES.get(unit, f'1.5 {unit}')}'")
    try:
        return Fraction(re.sub(r"\s", "", match[1])), match[2]
    except ArithmeticError:  # division by zero
        raise ValueError("is not a finite number") from None


def unit_factor(text: str, unit: str | None) -> Fraction:
    """How many of an SI unit one of the unit in a text is."""
    return cached_unit_factor(text, unit, command_scale())


@lru_cache(maxsize=1024)
def cached_unit_factor(text: str, unit: str | None, scale: CommandScale) -> Fraction:
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
    if volts and scale.unit != "V" and (found := factor_in_commands(text, unit, scale.unit)):
        return found / scale.per_volt**volts
    problem = f"does not convert to {unit}" if unit else "is not dimensionless"
    raise ValueError(f"{problem}{case_hint(text)}{command_unit_advice(text, unit, scale) if volts else ''}")


def factor_in_commands(text: str, unit: str, command: str) -> Fraction | None:
    """How many of a unit with that of commands in place of V one of another is; None if it is not of it."""
    own = exchanged(unit, "V", command)
    (factor, dimension), (factor_own, dimension_own) = map(factor_and_dimension, (text, own))
    alike = dimension == dimension_own and power_of("%", text) == power_of("%", own)
    return factor / factor_own if alike else None


def command_unit_advice(text: str, unit: str, scale: CommandScale) -> str:
    """What lets a command be in the unit of a text, or in which it is; "" where it would be in neither."""
    if scale.unit != "V":
        return f" or {exchanged(unit, 'V', scale.unit)}, as commands are by [command] full_scale"
    known = {"A": "40 mA", "%": "100 %"}
    example = next((known[one] for one in known if factor_in_commands(text, unit, one)), "")
    return example and f'; add [command] full_scale = "{example}", or what else 10 V stand for'
