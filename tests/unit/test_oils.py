"""The oils against the volume laws that they state."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.oils import AeratedOil, ConstantOil

ATMOSPHERE = 101325.0
OILS = [
    AeratedOil(1.4e9, 0.005, 1.4),
    AeratedOil(1.4e9, 0.05, 1.0),
    AeratedOil(1.0e9, 1e-4, 1.2),
]


def volume(oil: AeratedOil, pressure: float) -> float:
    """V(P) relative to that at atmospheric pressure, as the class states it."""
    liquid = (1.0 - oil.air_content) / (1.0 + pressure / oil.liquid_bulk_modulus)
    gas = oil.air_content * (ATMOSPHERE / (pressure + ATMOSPHERE)) ** (1.0 / oil.polytropic_index)
    return liquid + gas


def test_constant_oil() -> None:
    assert ConstantOil(8e8).bulk_modulus(-1e5) == ConstantOil(8e8).bulk_modulus(3e7) == 8e8


@pytest.mark.parametrize("oil", OILS)
@given(absolute=st.floats(1e2, 4e7))
def test_bulk_modulus_is_that_of_the_volume_law(oil: AeratedOil, absolute: float) -> None:
    """-V dp/dV, by a central difference."""
    step = 1e-4 * absolute
    low, high = (volume(oil, absolute - ATMOSPHERE + one) for one in (-step, step))
    slope = (high - low) / (2.0 * step)
    exact = -volume(oil, absolute - ATMOSPHERE) / slope
    assert oil.bulk_modulus(absolute - ATMOSPHERE) == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize("oil", OILS)
def test_in_torn_oil_only_the_gas_gives(oil: AeratedOil) -> None:
    """Its own n P, and the liquid as dead weight."""
    absolute = 10.0
    gas = oil.air_content * (ATMOSPHERE / absolute) ** (1.0 / oil.polytropic_index)
    expected = oil.polytropic_index * absolute * volume(oil, absolute - ATMOSPHERE) / gas
    assert oil.bulk_modulus(absolute - ATMOSPHERE) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("oil", OILS)
def test_air_does_not_matter_at_high_pressure(oil: AeratedOil) -> None:
    pressure = 3e8
    liquid = oil.liquid_bulk_modulus + pressure
    assert oil.bulk_modulus(pressure) == pytest.approx(liquid, rel=0.01)


@given(below=st.floats(-1e9, -ATMOSPHERE))
def test_it_stays_positive_below_vacuum(below: float) -> None:
    oil = AeratedOil()
    assert oil.bulk_modulus(below) == pytest.approx(oil.bulk_modulus(1e-3 - ATMOSPHERE), rel=1e-6)
    assert 0.0 < oil.bulk_modulus(below) < 1.0


@given(a=st.floats(-1e5, 4e7), b=st.floats(-1e5, 4e7))
def test_it_stiffens_with_pressure(a: float, b: float) -> None:
    assert AeratedOil().bulk_modulus(min(a, b)) <= AeratedOil().bulk_modulus(max(a, b))
