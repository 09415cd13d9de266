"""A weight that dry friction holds: LuGre lets it creep and says so, the other frictions hold it."""

import warnings
from pathlib import Path

import pytest

from hydroservo import HydroservoWarning, load_scenario, simulate

# Both chambers are open to the tank; the seals hold 196 N of weight, and 30 N to and fro.
HELD = """
simulation = { duration = "5 s", period = "1 ms", substeps = 24, record_period = "10 ms" }
controls = { type = "Command" }
controller = { type = "OpenLoop" }
reference = { type = "Step", initial = "0 V", final = "0 V", time = "1 s" }
supply = { type = "IdealSupply", supply_pressure = "1 bar" }
load = { type = "Sine", amplitude = "30 N", frequency = "5 Hz" }

[plant]
type = "Cylinder.from_diameters"
bore = "50 mm"
rod = "28 mm"
rods = 2
stroke = "200 mm"
start_pressure_a = "0.5 bar"
start_pressure_b = "0.5 bar"
mechanism = { type = "Mass", mass = "20 kg", rise = 1 }
oil = { type = "ConstantOil", effective_bulk_modulus = "12000 bar" }

[valve]
type = "StaticValve"
gain = "0.1 mm/V"
max_opening = "1 mm"
orifice.type = "FourEdges.rated"
orifice.rated_flow = "40 L/min"
orifice.rated_drop = "70 bar"
orifice.rated_opening = "1 mm"
orifice.lap = "-0.2 mm"

[plant.friction]
"""
DRY = 'coulomb = "220 N"\nbreakaway = "300 N"\nstribeck_velocity = "5 mm/s"\n'
BRISTLES = f'type = "LuGre"\nbristle_stiffness = "1e7 N/m"\nbristle_damping = "3000 N s/m"\n{DRY}'
ELASTIC = f'type = "ElastoPlastic"\n[plant.friction.bristles]\n{BRISTLES}'


def drift(folder: Path, friction: str, **changes: object) -> tuple[float, list[str]]:
    """How far the weight goes after the first second [m], and what the run warns of."""
    file = folder / "held.toml"
    file.write_text(HELD + friction, encoding="utf-8")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", HydroservoWarning)
        position = simulate(load_scenario(file, changes), record=["plant.position"])["plant.position"].values
    return position[-1] - position[100], [str(warning.message) for warning in caught]


def test_lugre_creeps_and_says_so(tmp_path: Path) -> None:
    way, said = drift(tmp_path, BRISTLES)
    assert way < -100e-6
    assert len(said) == 1
    assert said[0].startswith("the piston crept by 0.3")
    assert said[0].endswith("ElastoPlastic and Stribeck hold it")


@pytest.mark.parametrize(
    "friction", [f'type = "Stribeck"\n{DRY}', ELASTIC], ids=["Stribeck", "ElastoPlastic"]
)
def test_other_frictions_hold(friction: str, tmp_path: Path) -> None:
    assert drift(tmp_path, friction) == (0.0, [])


def test_what_slides_does_not_creep(tmp_path: Path) -> None:
    way, said = drift(tmp_path, BRISTLES, **{"load.amplitude": 130.0})
    assert way < -1e-3
    assert said == []
