"""Poles in closed form: bristles, a swinging load, a pump; and the describing function of an overlap."""

import math

import numpy as np
import pytest

from hydroservo import Loop, load_scenario, replace
from hydroservo.control.controlled import Velocity
from hydroservo.control.controllers import PI
from hydroservo.linear.linearize import linearization_at
from hydroservo.linear.measurement import GIVEN, ExcitationPlan, measure_spectra
from hydroservo.linear.operating_point import OperatingPoint, machine_point, operating_point
from hydroservo.machine.mechanics import LuGre, Mass, SwingingLoad, Viscous
from hydroservo.machine.plants import LoadPressurePlant
from hydroservo.machine.sensors import IdealSensors

SHUT = {  # edges that overlap and do not leak, so that oil is a spring and nothing else
    "valve.orifice.clearance": 0.0,
    "valve.hysteresis": 0.0,
    "plant.internal_leakage": 0.0,
    "load.initial": 0.0,
}
FRICTION = LuGre(5e6, 1000.0, 250.0, 350.0, 0.01, 800.0)


def axis(**changes: object) -> Loop:
    return replace(load_scenario("axis/position"), {**SHUT, **changes})


def columns(point: OperatingPoint) -> tuple[float, float]:
    """beta/V of both chambers [Pa/m^3]."""
    plant, x = point.loop.plant, point.machine.plant
    volume_a = plant.dead_volume_a + plant.area_a * x.position
    volume_b = plant.dead_volume_b + plant.area_b * (plant.stroke - x.position)
    return (
        float(plant.oil.bulk_modulus(x.pressure_a)) / volume_a,
        float(plant.oil.bulk_modulus(x.pressure_b)) / volume_b,
    )


def spring(point: OperatingPoint) -> float:
    """k_h = sum A_i^2 beta/V_i [N/m]."""
    plant = point.loop.plant
    rise_a, rise_b = columns(point)
    return float(plant.area_a**2 * rise_a + plant.area_b**2 * rise_b)


def assert_poles(point: OperatingPoint, expected: list[complex]) -> None:
    """Each pole by its natural frequency and damping ratio, to 1e-6."""
    poles = linearization_at(point, "machine").poles
    for root in expected:
        found = complex(poles[np.abs(poles - root).argmin()])
        assert abs(found) == pytest.approx(abs(root), rel=1e-6)
        assert -found.real / abs(found) == pytest.approx(-root.real / abs(root), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(("stiffness", "damping"), [(5e6, 1000.0), (5e7, 0.0), (2e5, 4000.0)])
def test_bristles_at_rest_are_a_spring_and_a_damper_beside_the_oil(stiffness: float, damping: float) -> None:
    """omega^2 = (k_h + sigma_0)/m, 2 zeta omega = (sigma_1 + sigma_2)/m: unbent bristles go with the rod.

    Canudas de Wit et al., IEEE Trans. Automatic Control 40(3), 1995, sec. III: in presliding LuGre is that.
    """
    friction = FRICTION._replace(bristle_stiffness=stiffness, bristle_damping=damping)
    point = machine_point(axis(**{"plant.friction": friction}), 0.0)
    assert point.machine.plant.friction.deflection == pytest.approx(0.0, abs=1e-12)
    mass = point.loop.plant.mechanism.mass
    frequency = math.sqrt((spring(point) + stiffness) / mass)
    ratio = (damping + friction.viscous) / (2.0 * mass * frequency)
    assert ratio < 1.0
    assert_poles(point, [frequency * complex(-ratio, math.sqrt(1.0 - ratio**2))])


def test_a_load_on_a_level_cart_swings_with_the_oil() -> None:
    """((M + m) I - m^2 c^2) s^4 + ((M + m) m g c + k_h I) s^2 + k_h m g c = 0: a crane held by a spring."""
    load = SwingingLoad(40.0, 0.7, moment_of_inertia=2.5)
    changes = {"plant.carried": load, "plant.friction": Viscous(0.0), "plant.mechanism": Mass(160.0)}
    point = machine_point(axis(**changes), 0.0)
    m, c, g = load.mass, load.centre_distance, load.gravity
    inertia, total, k = load.moment_of_inertia + m * c**2, 160.0 + m, spring(point)
    squares = np.roots([total * inertia - (m * c) ** 2, total * m * g * c + k * inertia, k * m * g * c])
    assert_poles(point, [1j * math.sqrt(-square) for square in squares.tolist()])


def test_a_held_load_swings_as_a_pendulum() -> None:
    """omega^2 = m g c/I, 2 zeta omega = b/I, where the rod is too heavy to move."""
    load = SwingingLoad(2.0, 0.7, moment_of_inertia=0.1, damping=0.5)
    changes = {"plant.carried": load, "plant.friction": Viscous(0.0), "plant.mechanism": Mass(1e8)}
    point = machine_point(axis(**changes), 0.0)
    inertia = 0.1 + 2.0 * 0.7**2
    frequency, decay = math.sqrt(2.0 * load.gravity * 0.7 / inertia), 0.25 / inertia
    assert_poles(point, [complex(-decay, math.sqrt(frequency**2 - decay**2))])


@pytest.mark.parametrize("speed_gain", [0.05, 0.8, 1e3])
def test_a_pump_between_the_ports_has_the_poles_of_motor_and_oil(speed_gain: float) -> None:
    """(m s + b)(c s + l)(J s + K + B) + (m s + b) D^2 + A^2 (J s + K + B) = 0, c = V_t/(4 beta).

    l is the leakage of cylinder and pump together. A stiff motor leaves the oil's own frequency,
    2 sqrt(beta (A^2 + b l)/(V_t m)): Merritt, Hydraulic Control Systems, 1967, ch. 5.
    """
    plant = LoadPressurePlant(60.0, 500.0, 5e-4, 1e-4, 7e8, 1e-12, 1.0, 0.5)
    loop = replace(
        load_scenario("axis/pump-controlled"),
        {
            "plant": plant,
            "controls": Velocity(),
            "controller": PI(1.0, 0.0),
            "sensors": IdealSensors(),
            "load.amplitude": 0.0,
            "drive.speed_gain": speed_gain,
            "drive.viscous": 0.01,
            "drive.case_leakage": 2e-13,
        },
    )
    drive = loop.drive
    body, motor = (
        np.poly1d([plant.mass, plant.damping]),
        np.poly1d([drive.inertia, speed_gain + drive.viscous]),
    )
    leak = plant.leakage + drive.leakage + 0.5 * drive.case_leakage
    oil = np.poly1d([plant.total_volume / (4.0 * plant.bulk_modulus), leak])
    whole = body * oil * motor + body * drive.displacement**2 + motor * plant.piston_area**2
    point = machine_point(loop, 0.5)
    assert_poles(point, [complex(root) for root in whole.roots])
    if speed_gain == 1e3:
        squared = plant.piston_area**2 + plant.damping * leak
        stiff = 2.0 * math.sqrt(plant.bulk_modulus * squared / (plant.total_volume * plant.mass))
        assert [abs(root) for root in whole.roots if root.imag > 0.0] == [pytest.approx(stiff, rel=1e-4)]


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_a_valve_with_overlap_has_the_describing_function_of_a_dead_band(share: float) -> None:
    """N = 1 - 2/pi (asin d + d sqrt(1 - d^2)), d = overlap/A: Gelb, Vander Velde, 1968, ch. 2."""
    amplitude, plan = 2.0, ExcitationPlan(np.array([4]), 1000, 2, 1, seed=0)  # 4 Hz

    def gain(lap: float) -> complex:
        loop = axis(
            **{
                "plant.friction": Viscous(100.0),
                "plant.mechanism": Mass(5.0),
                "plant.start_position": 0.15,
                "valve.orifice.lap": lap,
                "controls": Velocity(),
                "controller": PI(1e-9, 0.0),
                "sensors": IdealSensors(),
            }
        )
        point = operating_point(loop, 0.0)
        heard = measure_spectra(loop, point, "command", amplitude, plan, ["plant.velocity"])
        return complex(heard.response("plant.velocity", GIVEN)[0])

    function = 1.0 - 2.0 / math.pi * (math.asin(share) + share * math.sqrt(1.0 - share**2))
    overlap = share * amplitude * load_scenario("axis/position").valve.gain
    assert gain(overlap) / gain(0.0) == pytest.approx(function, rel=0.01)
