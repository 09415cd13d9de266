"""The paper's machine without uncertainty and its three laws, on which scenarios of tests build."""

from pathlib import Path

__all__ = ["CYLINDER", "DATASHEET", "on_base"]

DATASHEET = """
[simulation]
duration = "20 ms"
period = "1 ms"
substeps = 20

[supply]
supply_pressure = "160 bar"

[plant]
type = "Cylinder.from_diameters"
bore = "63 mm"
rod = "45 mm"
stroke = "70 mm"
start_position = "auto"
oil.type = "AeratedOil"
"""  # its mechanism is still to be given
CYLINDER = {  # what it has and the paper's plant does not
    "plant.type": "Cylinder",
    "plant.area_a": "4.91 cm^2",
    "plant.area_b": "4.91 cm^2",
    "plant.dead_volume_a": "25 cm^3",
    "plant.dead_volume_b": "25 cm^3",
    "plant.oil": {"type": "ConstantOil", "effective_bulk_modulus": "7000 bar"},
    "plant.mechanism": {"type": "Mass", "mass": "6 kg"},
    "plant.friction.coefficient": "50 N s/m",
}


def on_base(text: str, law: str = "pi") -> str:
    """A scenario's text, to lie over that of the machine with a law: pi, tsmc or backstepping."""
    return f"base = '{Path(__file__).with_name(law)}.toml'\n{text}"
