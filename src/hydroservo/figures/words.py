"""Numbers and quantities as an engineer reads them."""

import math
from collections.abc import Iterable

import xarray as xr

from hydroservo.metrics import METRIC_FIELDS
from hydroservo.results import readable_unit

__all__ = [
    "MINUS",
    "NONE",
    "TIMES",
    "column",
    "measured",
    "number",
    "quantity",
    "readable",
    "yes_or_no",
]

MINUS = "\N{MINUS SIGN}"
TIMES = "\N{MULTIPLICATION SIGN}"
NONE = "\N{EN DASH}"  # stands where there is no number
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


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


def quantity(value: float, unit: str) -> str:
    """A number of SI unit as an engineer reads it, such as 0.266 mm/s."""
    if not math.isfinite(value):
        return number(value)
    label, factor = readable(unit, abs(value))
    return f"{number(factor * value)} {label}".strip()


def measured(run: xr.Dataset, metric: str) -> str:
    """A metric of a run, with its unit."""
    return quantity(float(run[metric]), METRIC_FIELDS[metric].unit)


def column(values: Iterable[float], unit: str) -> tuple[str, list[str]]:
    """SI numbers in the one unit that suits the largest of them, and that unit."""
    values = list(values)
    largest = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    label, factor = readable(unit, largest)
    return label, [NONE if math.isnan(value) else number(factor * value) for value in values]


def readable(unit: str, largest: float) -> tuple[str, float]:
    """The unit in which numbers of up to this size are read, short times included, and the factor to it."""
    if unit == "s" and 0.0 < largest < 1.0:
        return ("ms", 1e3) if largest >= 1e-3 else ("µs", 1e6)
    return readable_unit(unit, largest)


def yes_or_no(flag: object) -> str:
    """A flag as it is read."""
    return "yes" if flag else "no"
