"""Units as FMI defines them: a factor times integer powers of the base units."""

from collections.abc import Mapping
from fractions import Fraction

from hydroservo.scenario.units import factor_and_dimension

SYMBOLS = {  # and the size of pint's root unit in FMI's base unit
    "gram": ("kg", Fraction(1, 1000)),
    "meter": ("m", Fraction(1)),
    "second": ("s", Fraction(1)),
    "ampere": ("A", Fraction(1)),
    "kelvin": ("K", Fraction(1)),
    "mole": ("mol", Fraction(1)),
    "candela": ("cd", Fraction(1)),
    "radian": ("rad", Fraction(1)),
}


def base_unit(text: str) -> Mapping[str, int | float] | None:
    """The attributes of a unit's ``BaseUnit``: exponents, and the factor where it is not 1.

    None where FMI cannot say it, as for m^(2/7), or where the text is no unit.
    """
    try:
        factor, dimension = factor_and_dimension(text)
    except ValueError:
        return None
    attributes: dict[str, int | float] = {}
    for root, power in dimension.items():
        if root not in SYMBOLS or power.denominator != 1:
            return None
        symbol, size = SYMBOLS[root]
        attributes[symbol] = int(power)
        factor *= size ** int(power)
    if factor != 1:
        attributes["factor"] = float(factor)
    return attributes
