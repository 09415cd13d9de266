"""Numbers and quantities as an engineer reads them."""

import math
from collections.abc import Iterable, Mapping, Sequence
from numbers import Real
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple, TypeGuard

from hydroservo.core.command_scale import in_command_unit

if TYPE_CHECKING:
    import xarray as xr

MINUS = "\N{MINUS SIGN}"
TIMES = "\N{MULTIPLICATION SIGN}"
NONE = "\N{EN DASH}"  # stands where there is no number
DEGREES = "\N{DEGREE SIGN}"
COMMON = {  # the units of datasheets, whatever the size of a number
    "m": ("mm", 1e3),
    "m/s": ("mm/s", 1e3),
    "m/V": ("mm/V", 1e3),
    "m^2": ("cm²", 1e4),
    "m^3": ("cm³", 1e6),
    "m^3/s": ("L/min", 6e4),
    "m^3/(s V)": ("L/(min V)", 6e4),
    "Pa": ("bar", 1e-5),
    "Pa/V": ("bar/V", 1e-5),
    "rad": (DEGREES, 180.0 / math.pi),
}
LARGE = ("N", "N/s", "Hz", "W")  # units that get a prefix from 10,000 on
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class Scale(NamedTuple):
    """A unit to read SI numbers in: they are ``factor`` times the number, less ``zero``."""

    label: str
    factor: float
    zero: float = 0.0

    def of(self, value: float) -> float:
        """The number to read."""
        return self.factor * value - self.zero


KELVIN = "K"
CELSIUS = Scale("degC", 1.0, 273.15)


def readable_unit(unit: str, largest: float) -> tuple[str, float]:
    """The unit in which an engineer reads SI numbers of up to this size, and the factor to it.

    For instance ``("mm/s", 1e3)`` for "m/s", and ``("mV", 1e3)`` for "V" where everything is below 1 V. What
    has V in it comes in the unit of commands.
    """
    own, per_volt = in_command_unit(unit)
    if own != unit:
        label, factor = COMMON.get(unit, (unit, 1.0))
        return superscripts(in_command_unit(label)[0]), factor * per_volt
    if unit in COMMON:
        return COMMON[unit]
    if unit in LARGE and largest >= 1e4:
        prefix, factor = ("k", 1e-3) if largest < 1e7 else ("M", 1e-6)
        return f"{prefix}{unit}", factor
    if unit == "V" and largest < 1.0:
        return "mV", 1e3
    if unit == "s" and 0.0 < largest < 1.0:
        return ("ms", 1e3) if largest >= 1e-3 else ("µs", 1e6)
    return superscripts(unit), 1.0


def superscripts(unit: str) -> str:
    return unit.replace("^2", "²").replace("^3", "³")


def common_unit(values: Iterable[float], unit: str) -> tuple[str, float]:
    """The one unit that suits the largest of some SI numbers, and the factor to it."""
    return readable_unit(unit, max((abs(value) for value in values if math.isfinite(value)), default=0.0))


def scale_of(values: Iterable[float], unit: str) -> Scale:
    """The one unit that suits some SI numbers; of temperatures degrees Celsius."""
    return CELSIUS if unit == KELVIN else Scale(*common_unit(values, unit))


def scales_of(
    rows: Iterable[tuple[str, Iterable[float]]], typed: Mapping[str, Scale] = MappingProxyType({})
) -> dict[str, Scale]:
    """The unit of each quantity of a table, by its SI unit: one for all rows that have it.

    Args:
        rows: of each its SI unit and its numbers in it.
        typed: units that a user wrote, by SI unit; they go before those that suit the largest number.
    """
    numbers: dict[str, list[float]] = {}
    for unit, values in rows:
        numbers.setdefault(unit, []).extend(values)
    return {unit: typed.get(unit) or scale_of(values, unit) for unit, values in numbers.items()}


def number(value: float, digits: int = 3) -> str:
    """A number as it is read: so many significant digits, a true minus sign, far from 1 a power of ten."""
    if not math.isfinite(value):
        return "no number" if math.isnan(value) else "∞" if value > 0.0 else f"{MINUS}∞"
    if value == 0.0:
        return "0"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = int(exponent)
    if -4 < power < 5:
        text = f"{float(f'{mantissa}e{exponent}'):.{max(digits - 1 - power, 0)}f}"
    else:
        text = f"{mantissa} {TIMES} 10{str(power).translate(SUPERSCRIPT)}"
    return text.replace("-", MINUS)


def brief(value: float, digits: int = 4) -> str:
    """A number as :func:`number` has it, without zeros at the end of its decimals."""
    text = number(value, digits)
    mantissa, power, rest = text.partition(f" {TIMES}")
    return (mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa) + power + rest


def quantity(value: float, unit: str) -> str:
    """A number of SI unit as an engineer reads it, such as 0.266 mm/s."""
    if not math.isfinite(value):
        return number(value)
    scale = scale_of([value], unit)
    return with_label(number(scale.of(value)), scale.label)


def plain_quantity(value: float, unit: str) -> str:
    """A quantity in characters that every terminal has."""
    return quantity(value, unit).replace(MINUS, "-")


def with_label(text: str, label: str) -> str:
    """A number with its unit behind it."""
    if text == NONE:
        return text
    return f"{text}{label}" if label == DEGREES else f"{text} {label}".strip()


def measured(run: "xr.Dataset", metric: str) -> str:
    """A metric of a run, with its unit."""
    return quantity(float(run[metric]), run[metric].attrs["units"])


def column(values: Iterable[float], unit: str) -> tuple[str, list[str]]:
    """SI numbers in the one unit that suits the largest of them, and that unit."""
    values = list(values)
    scale = scale_of(values, unit)
    return scale.label, cells_of(values, scale)


def cells_of(values: Iterable[float], scale: Scale) -> list[str]:
    """SI numbers as they are read in a unit."""
    return [NONE if math.isnan(value) else number(scale.of(value)) for value in values]


def counted(count: int, noun: str) -> str:
    """So many of something, such as "1 run" and "1,000 runs"."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


def is_number(value: object) -> TypeGuard[int | float]:
    """True for an integer or a float; a truth value is not a number here."""
    return isinstance(value, Real) and not isinstance(value, bool)


def yes_or_no(flag: object) -> str:
    return "yes" if flag else "no"


def enumeration(parts: Sequence[str]) -> str:
    """Parts as they stand in a sentence."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}" if parts else ""
