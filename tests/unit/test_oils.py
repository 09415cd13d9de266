"""The oils against the volume laws that they state."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo import ParameterError
from hydroservo.machine.oils import AeratedOil, CavitatingOil, ConstantOil
from hydroservo.machine.oils.mineral import MineralOil

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


VG_46 = MineralOil(879.0, 46e-6, 6.7e-6)  # the numbers of a zinc-based oil of viscosity index 98
CELSIUS = 273.15


@pytest.mark.parametrize(
    ("cold", "hot", "temperature", "wanted", "rounding"),
    [
        (404.0, 28.0, 60.0, 132.126, 5e-4),  # SAE 140 gear oil, published example of ASTM D341
        (68.0, 8.8, 80.0, 14.85, 0.05 / 8.8 * 14.85),  # the 8.8 was published as what 14.85 comes to
    ],
)
def test_viscosities_between_two_are_those_that_others_publish(
    cold: float, hot: float, temperature: float, wanted: float, rounding: float
) -> None:
    oil = MineralOil(890.0, 1e-6 * cold, 1e-6 * hot)
    found = oil.kinematic_viscosity(CELSIUS + temperature)
    assert found == pytest.approx(1e-6 * wanted, abs=1e-6 * rounding)


def test_a_data_sheet_s_own_viscosities_come_out() -> None:
    assert VG_46.kinematic_viscosity(CELSIUS + 40.0) == pytest.approx(46e-6, rel=1e-12)
    assert VG_46.kinematic_viscosity(CELSIUS + 100.0) == pytest.approx(6.7e-6, rel=1e-12)
    assert VG_46.viscosity(CELSIUS + 40.0) == pytest.approx(VG_46.density(CELSIUS + 40.0) * 46e-6)


@pytest.mark.parametrize("celsius", [-20.0, 15.0, 40.0, 80.0])
def test_density_is_that_of_the_petroleum_tables(celsius: float) -> None:
    """The same law in degrees Fahrenheit, as ASTM D1250 has it for lubricating oils."""
    expansion = 0.34878 / 879.0  # 1/degF
    fahrenheit = 1.8 * (celsius - 15.0)
    wanted = 879.0 * math.exp(-expansion * fahrenheit * (1.0 + 0.8 * expansion * fahrenheit))
    assert VG_46.density(CELSIUS + celsius) == pytest.approx(wanted, rel=1e-12)


def test_ten_kelvin_cost_seven_thousandths_of_the_density() -> None:
    lost = 1.0 - VG_46.density(CELSIUS + 25.0) / VG_46.density(CELSIUS + 15.0)
    assert lost == pytest.approx(7e-3, rel=0.05)


@pytest.mark.parametrize(
    ("oil", "says"),
    [
        (MineralOil(879.0, 46e-6, 50e-6), "viscosity_100 = 5e-05: must be below viscosity_40"),
        (MineralOil(-879.0, 46e-6, 6.7e-6), r"density_15 = -879\.0: must be a finite number above 0"),
        (MineralOil(879.0, math.nan, 6.7e-6), "viscosity_40 = nan: must be a finite number above 0"),
    ],
)
def test_an_oil_that_thickens_with_heat_or_is_none_is_refused(oil: MineralOil, says: str) -> None:
    for asked in (oil.density, oil.kinematic_viscosity, oil.viscosity):
        with pytest.raises(ParameterError, match=says):
            asked(313.15)


MODULI = {"cold": 293.15, "cold_bulk_modulus": 1.9e9, "hot": 343.15, "hot_bulk_modulus": 1.45e9}


def test_a_temperature_in_degrees_celsius_is_refused() -> None:
    for asked in (VG_46.density, VG_46.kinematic_viscosity, VG_46.viscosity):
        with pytest.raises(ParameterError, match=r"temperature = 40\.0: must be from 200 to 500 \[K\]"):
            asked(40.0)


class TestAtTemperature:
    def test_it_meets_both_moduli_and_their_mean_between(self) -> None:
        found = [
            AeratedOil.at_temperature(t, **MODULI, air_content=0.01).liquid_bulk_modulus
            for t in (293.15, 318.15, 343.15)
        ]
        assert found == pytest.approx([1.9e9, math.sqrt(1.9e9 * 1.45e9), 1.45e9], rel=1e-12)
        oil = AeratedOil.at_temperature(300.0, **MODULI, air_content=0.01)
        assert (oil.air_content, oil.polytropic_index) == (0.01, 1.4)

    @pytest.mark.parametrize(
        ("changes", "says"),
        [
            ({"temperature": 40.0}, r"temperature = 40\.0: must be from 200 to 500 \[K\]"),
            ({"temperature": -400.0}, r"temperature = -400\.0: must be from 200"),
            ({"cold": 20.0}, r"cold = 20\.0: must be from 200 to 500 \[K\]"),
            ({"hot": 700.0}, r"hot = 700\.0: must be from 200 to 500 \[K\]"),
        ],
    )
    def test_what_cannot_be_an_absolute_temperature_is_refused(
        self, changes: dict[str, float], says: str
    ) -> None:
        with pytest.raises(ParameterError, match=says):
            AeratedOil.at_temperature(**{"temperature": 300.0, **MODULI, **changes})

    @pytest.mark.parametrize(
        ("changes", "says"),
        [
            ({"hot": 293.15}, r"hot = 293\.15: must be above cold"),
            ({"hot_bulk_modulus": 2e9}, r"hot_bulk_modulus = 2000000000\.0: must be below cold_bulk_modulus"),
        ],
    )
    def test_what_is_the_wrong_way_round_is_refused(self, changes: dict[str, float], says: str) -> None:
        with pytest.raises(ParameterError, match=says):
            AeratedOil.at_temperature(300.0, **{**MODULI, **changes})


@given(absolute=st.floats(1e-2, 4e7))
def test_cavitating_oil_is_liquid_in_series_with_a_void(absolute: float) -> None:
    oil = CavitatingOil(1e9, 1e-4)
    compliance = 1e-9 + 1e-4 * ATMOSPHERE / absolute**2
    assert oil.bulk_modulus(absolute - ATMOSPHERE) == pytest.approx(1.0 / compliance, rel=1e-6)


def test_cavitating_oil_at_work_and_below_vacuum() -> None:
    oil = CavitatingOil(1e9)
    assert oil.bulk_modulus(1e6) == pytest.approx(1e9, rel=1e-3)
    assert oil.bulk_modulus(-1e9) == pytest.approx(oil.bulk_modulus(1e-3 - ATMOSPHERE), rel=1e-6)
    assert oil.bulk_modulus(-1e9) > 0.0
