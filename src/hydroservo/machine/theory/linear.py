"""The load-pressure plant linearised at rest: its frequency, its damping and PI's stability limit."""

import math

from hydroservo.machine.plants.load_pressure import LoadPressurePlant
from hydroservo.machine.supplies.ideal import IdealSupply
from hydroservo.machine.theory.ranges import require_not_negative
from hydroservo.machine.valves.first_order import FirstOrderValve


def natural_frequency(plant: LoadPressurePlant) -> float:
    """Hydraulic natural frequency [rad/s]: the mass on the oil's spring.

    omega_h = sqrt(4 beta_e A_p^2/(V_t m))

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 6.
    Fails where b C_tl/A_p^2 is not small against 1; the poles lie at omega_h sqrt(1 + b C_tl/A_p^2), 0.3 %
    higher with the paper's numbers. A piston off mid-stroke is stiffer.
    """
    return math.sqrt(-plant.free_force_rate(1.0, 0.0) / plant.mass)


def damping_ratio(plant: LoadPressurePlant) -> float:
    """Hydraulic damping ratio, from leakage and friction.

    zeta_h = (4 beta_e C_tl/V_t + b/m)/(2 omega_h)

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 6.
    Fails away from rest, where the valve's flow-pressure slope adds most of the damping.
    """
    leakage_rate = -plant.free_force_rate(0.0, 1.0)
    return (leakage_rate + plant.damping / plant.mass) / (2.0 * natural_frequency(plant))


def proportional_gain_limit(
    plant: LoadPressurePlant, valve: FirstOrderValve, supply: IdealSupply, integral_gain: float
) -> float:
    """Largest stable proportional gain k_p [V s/m] of PI velocity control with a first-order valve.

    With c_1, c_0 the coefficients of the plant's s^2 + c_1 s + c_0, K the numerator of velocity over
    command [m/(s^3 V)] and T_sv the valve's lag, the characteristic polynomial of the loop at rest is::

        T_sv s^4 + (1 + T_sv c_1) s^3 + (c_1 + T_sv c_0) s^2 + (c_0 + K k_p) s + K k_i

    Routh's condition, with a_i the coefficient of s^i, is a_1 (a_3 a_2 - a_4 a_1) > a_3^2 a_0, so::

        c_0 + K k_p < (a_3 a_2 + sqrt((a_3 a_2)^2 - 4 a_4 a_3^2 a_0))/(2 a_4)

    Args:
        plant: cylinder and mass.
        valve: servo valve with its lag and metering edges.
        supply: pressures; at rest the edges share all of p_s - p_r.
        integral_gain: k_i [V/m], at least 0.

    Returns:
        The limit, or nan where k_i alone makes every k_p unstable. It may be negative.

    Raises:
        ParameterError: a negative integral gain.

    Source: Routh's criterion (as in Merritt, Hydraulic Control Systems, 1967, ch. 6) on eqs. (2)-(4) of
    doi:10.1007/s42401-021-00087-w with T_sv dx_v/dt = K_sv u - x_v.
    Fails for a sampled loop, which a delay of half a period and more destabilises earlier, and for large
    motion, where the command saturates and the orifice damps.
    """
    require_not_negative("integral_gain", integral_gain)
    friction_rate = plant.damping / plant.mass
    leakage_rate = -plant.free_force_rate(0.0, 1.0)
    c1 = friction_rate + leakage_rate
    c0 = natural_frequency(plant) ** 2 + friction_rate * leakage_rate
    flow_gain: float = valve.gain * valve.orifice.simplified().flow_per_opening(supply.drop())
    gain = plant.flow_gain() * flow_gain / plant.mass
    lag = valve.time_constant
    a4, a3, a2, a0 = lag, 1.0 + lag * c1, c1 + lag * c0, gain * integral_gain
    discriminant = (a3 * a2) ** 2 - 4.0 * a4 * a3**2 * a0
    if discriminant < 0.0:
        return math.nan
    return ((a3 * a2 + math.sqrt(discriminant)) / (2.0 * a4) - c0) / gain
