"""Whether the sizes of a machine are those of machines."""

from hydroservo.core.block import Block, field_at, leaves
from hydroservo.core.formatting import quantity

AREAS, MODULI = (1e-6, 5.0), (1e6, 1e11)  # [m^2], [Pa]
MACHINE = ("plant.", "valve.", "supply.", "drive.")
USUAL = {  # in SI units by a number's name, with room beyond any catalogue
    "area_a": AREAS,
    "area_b": AREAS,
    "piston_area": AREAS,
    "stroke": (1e-4, 50.0),
    "max_opening": (1e-6, 0.1),
    "mass": (1e-4, 1e7),
    "supply_pressure": (1e4, 5e8),
    "bulk_modulus": MODULI,
    "effective_bulk_modulus": MODULI,
    "liquid_bulk_modulus": MODULI,
    "density": (100.0, 5000.0),
    "time_constant": (1e-7, 100.0),
}


def size_cautions(loop: Block) -> list[str]:
    """Which numbers of a loop's machine are out of all proportion, as a bore of 50 m for one of 50 mm is.

    Args:
        loop: the loop.

    Fails to know a slip that stays within what is usual, and numbers of other names.
    """
    found = []
    for path, value in leaves(loop):
        name = path.rpartition(".")[2]
        if not path.startswith(MACHINE) or name not in USUAL:
            continue
        least, most = USUAL[name]
        if least <= value <= most:
            continue
        unit = field_at(loop, path).unit
        here, low, high = (quantity(one, unit) for one in (value, least, most))
        found.append(
            f"{path} is {here}, and machines have {low} to {high}: is its unit right? "
            "A number without one is in SI units"
        )
    return found
