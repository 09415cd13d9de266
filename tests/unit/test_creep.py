"""A weight that dry friction holds: LuGre lets it creep and says so, the other frictions hold it."""

import warnings

import pytest

from hydroservo import HydroservoWarning, simulate
from tests.support.axes import commanded_axis, step

# Both chambers are open to the tank; the seals hold 196 N of weight, and 30 N to and fro.
HELD = {
    "simulation": {"duration": "5 s", "period": "1 ms", "substeps": 24, "record_period": "10 ms"},
    "reference": step("0 V", "0 V", "1 s"),
    "supply.supply_pressure": "1 bar",
    "load": {"type": "Sine", "amplitude": "30 N", "frequency": "5 Hz"},
    "plant.bore": "50 mm",
    "plant.rod": "28 mm",
    "plant.rods": 2,
    "plant.start_pressure_a": "0.5 bar",
    "plant.start_pressure_b": "0.5 bar",
    "plant.mechanism": {"type": "Mass", "mass": "20 kg", "rise": 1},
    "valve.orifice.lap": "-0.2 mm",
}
DRY = {"coulomb": "220 N", "breakaway": "300 N", "stribeck_velocity": "5 mm/s"}
BRISTLES = {"type": "LuGre", "bristle_stiffness": "1e7 N/m", "bristle_damping": "3000 N s/m", **DRY}
ELASTIC = {"type": "ElastoPlastic", "bristles": BRISTLES}


def drift(friction: dict[str, object], **changes: object) -> tuple[float, list[str]]:
    """How far the weight goes after the first second [m], and what the run warns of."""
    loop = commanded_axis(HELD | {"plant.friction": friction} | changes)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", HydroservoWarning)
        position = simulate(loop, record=["plant.position"])["plant.position"].values
    return position[-1] - position[100], [str(warning.message) for warning in caught]


def test_lugre_creeps_and_says_so() -> None:
    way, said = drift(BRISTLES)
    assert way < -100e-6
    assert len(said) == 1
    assert said[0].startswith("the piston crept by 0.3")
    assert said[0].endswith("ElastoPlastic and Stribeck hold it")


@pytest.mark.parametrize(
    "friction", [{"type": "Stribeck", **DRY}, ELASTIC], ids=["Stribeck", "ElastoPlastic"]
)
def test_other_frictions_hold(friction: dict[str, object]) -> None:
    assert drift(friction) == (0.0, [])


def test_what_slides_does_not_creep() -> None:
    way, said = drift(BRISTLES, **{"load.amplitude": 130.0})
    assert way < -1e-3
    assert said == []
