"""Machines written anew from their equations, by which labels of runs are found without the blocks' own text.

A machine is a function ``rates(t, y, u, force, p)``: the states y in the order in which a loop has them, the
command u [V], what of the load is constant until it jumps [N], and all parameters in p.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hydroservo.core.block import Block, leaves

ATMOSPHERE = 101325.0  # [Pa]
GROUPS = ("plant", "valve", "supply", "drive", "load")

Vector = NDArray[np.float64]
Rates = Callable[..., Vector]


class Machine(NamedTuple):
    """Rates of a machine's states, and the parameters that go with them."""

    rates: Rates
    parameters: Any


def machine(loop: Block) -> Machine:
    """The machine of a wired loop, written by hand.

    Raises:
        KeyError: there is none of such blocks here.
    """
    numbers = {
        f"{group}.{path}".replace(".", "_"): value
        for group in GROUPS
        for path, value in leaves(getattr(loop, group))
        if isinstance(value, int | float)
    }
    return Machine(RATES[kind(loop)], record(numbers))


def kind(loop: Block) -> tuple[str, ...]:
    """The blocks that tell machines apart."""
    plant = loop.plant
    inner = (plant.oil, plant.friction, plant.mechanism, plant.carried) if hasattr(plant, "oil") else ()
    blocks = (plant, *inner, loop.valve, loop.supply, loop.drive)
    return tuple(type(block).__name__ for block in blocks)


def record(numbers: Mapping[str, float]) -> Any:
    """Numbers by name as one record, which compiled code reads."""
    names = [*numbers, *({"load_amplitude", "load_frequency"} - numbers.keys())]
    table = np.zeros(1, [(name, float) for name in names])
    for name, value in numbers.items():
        table[name] = value
    return table[0]


@njit
def within(x, least, most):
    return min(max(x, least), most)


@njit
def root(drop, transition):
    """The root of a drop with its sign, linear far below the transition."""
    return drop / (drop * drop + transition * transition) ** 0.25


@njit
def sine(t, force, p):
    """The load with its sine, if it has one [N]."""
    return force + p.load_amplitude * np.sin(2.0 * np.pi * p.load_frequency * t)


@njit
def lumped(t, y, u, force, p):
    """A load-pressure cylinder on a valve of first order: velocity, hydraulic force, position, spool."""
    v, x2, _, spool = y
    demanded = within(p.valve_gain * u, -p.valve_max_opening, p.valve_max_opening)
    drop = p.supply_supply_pressure - p.supply_return_pressure - np.sign(spool) * x2 / p.plant_piston_area
    size = p.valve_orifice_discharge_coefficient * p.valve_orifice_area_gradient
    flow = size * spool * np.sqrt(max(drop, 0.0) / p.valve_orifice_density)
    lost = p.plant_piston_area * v + p.plant_leakage * x2 / p.plant_piston_area
    stiffness = 4.0 * p.plant_bulk_modulus * p.plant_piston_area / p.plant_total_volume
    return np.array(
        [
            (x2 - p.plant_damping * v - sine(t, force, p)) / p.plant_mass,
            stiffness * (flow - lost),
            v,
            (demanded - spool) / p.valve_time_constant,
        ]
    )


@njit
def spool_acceleration(x, v, u, p):
    """Of a spool of second order with play, a largest speed and ends [m/s^2]."""
    w, end, play = p.valve_natural_frequency, p.valve_max_opening, 0.5 * p.valve_hysteresis
    demanded = within(p.valve_gain * u, -end, end)
    free = w * w * (within(x, demanded - play, demanded + play) - x) - 2.0 * p.valve_damping_ratio * w * v
    k = 5.0 * w
    most = min(k * (p.valve_slew_limit - v), k * k * (end - x) - 2.0 * k * v)
    least = -min(k * (p.valve_slew_limit + v), k * k * (end + x) + 2.0 * k * v)
    return within(free, least, most)


@njit
def edge(x, drop, p):
    """Flow through an edge that a spool at x uncovers, per area gradient [m^2/s]."""
    z = x - p.valve_orifice_lap
    opening = 0.5 * (z + np.sqrt(z * z + 4.0 * p.valve_orifice_clearance**2))
    speed = np.sqrt(2.0 / p.valve_orifice_density) * root(drop, p.valve_orifice_transition_drop)
    return p.valve_orifice_discharge_coefficient * opening * speed


@njit
def four_edges(x, supply, tank, a, b, p):
    """Flows into A, out of B and from the supply [m^3/s]."""
    w_a, w_b = p.valve_orifice_area_gradient, p.valve_orifice_area_gradient * p.valve_orifice_area_ratio_b
    from_supply_a, to_tank_a = w_a * edge(x, supply - a, p), w_a * edge(-x, a - tank, p)
    from_supply_b, to_tank_b = w_b * edge(-x, supply - b, p), w_b * edge(x, b - tank, p)
    return from_supply_a - to_tank_a, to_tank_b - from_supply_b, from_supply_a + from_supply_b


@njit
def bristles(v, z, p):
    """LuGre's rate of the deflection [m/s], and its force [N]."""
    fall = np.exp(-((v / p.plant_friction_stribeck_velocity) ** 2))
    level = p.plant_friction_coulomb + (p.plant_friction_breakaway - p.plant_friction_coulomb) * fall
    rate = v - p.plant_friction_bristle_stiffness * abs(v) / level * z
    force = p.plant_friction_bristle_stiffness * z + p.plant_friction_bristle_damping * rate
    return rate, force + p.plant_friction_viscous * v


@njit
def stops(x, v, p):
    """Of both ends of the stroke [N]."""
    below, above = max(-x, 0.0), max(x - p.plant_stroke, 0.0)
    c = p.plant_stops_dissipation
    return p.plant_stops_stiffness * (below * max(1.0 - c * v, 0.0) - above * max(1.0 + c * v, 0.0))


@njit
def chambers(x, v, a, b, into_a, out_of_b, soft, p):
    """Rates of the two pressures [Pa/s]; ``soft`` is the bulk modulus in each."""
    volume_a = max(p.plant_dead_volume_a + p.plant_area_a * x, 0.01 * p.plant_dead_volume_a)
    volume_b = max(
        p.plant_dead_volume_b + p.plant_area_b * (p.plant_stroke - x), 0.01 * p.plant_dead_volume_b
    )
    past = p.plant_internal_leakage * (a - b)
    lost_a, lost_b = p.plant_external_leakage * max(a, 0.0), p.plant_external_leakage * max(b, 0.0)
    rate_a = soft[0] / volume_a * (into_a - past - lost_a - p.plant_area_a * v)
    rate_b = soft[1] / volume_b * (past - out_of_b - lost_b + p.plant_area_b * v)
    return rate_a, rate_b


@njit
def aerated(pressure, p):
    """Bulk modulus of liquid and air, -V/(dV/dp) of their volumes together [Pa]."""
    absolute = max(pressure + ATMOSPHERE, 1e-3)
    beta, air, n = p.plant_oil_liquid_bulk_modulus, p.plant_oil_air_content, p.plant_oil_polytropic_index
    squeezed = 1.0 + (absolute - ATMOSPHERE) / beta
    liquid, gas = (1.0 - air) / squeezed, air * (ATMOSPHERE / absolute) ** (1.0 / n)
    return (liquid + gas) / (liquid / (squeezed * beta) + gas / (n * absolute))


@njit
def constant(_pressure, p):
    return p.plant_oil_effective_bulk_modulus


def axis(oil: Callable[..., float]) -> Rates:
    """A mass on a single rod, a servo valve on an ideal supply."""

    @njit
    def rates(t, y, u, force, p):
        v, x, a, b, z, spool, speed = y
        supply, tank = p.supply_supply_pressure, p.supply_return_pressure
        into_a, out_of_b, _ = four_edges(spool, supply, tank, a, b, p)
        rate_a, rate_b = chambers(x, v, a, b, into_a, out_of_b, (oil(a, p), oil(b, p)), p)
        bending, rubbed = bristles(v, z, p)
        weight = p.plant_mechanism_mass * p.plant_mechanism_gravity * p.plant_mechanism_rise
        net = p.plant_area_a * a - p.plant_area_b * b - sine(t, force, p) - weight + stops(x, v, p) - rubbed
        pushed = spool_acceleration(spool, speed, u, p)
        return np.array([net / p.plant_mechanism_mass, v, rate_a, rate_b, bending, speed, pushed])

    return rates


@njit
def replenished(pressure, pilot, p):
    """What a port of the pump gets from the line through its check valve, less what it relieves [m^3/s]."""
    drop, over = p.supply_supply_pressure - pressure, pilot - p.supply_supply_pressure
    forced = drop + p.drive_check_valve_pilot_ratio * max(over, 0.0) - p.drive_check_valve_cracking_pressure
    x = within(forced / p.drive_check_valve_opening_range, 0.0, 1.0)
    let_in = p.drive_check_valve_conductance * x * x * (3.0 - 2.0 * x) * drop
    return let_in - p.drive_relief_gradient * max(-drop - p.drive_relief_cracking_pressure, 0.0)


def pump(oil: Callable[..., float]) -> Rates:
    """A mass on a single rod, driven by a pump between its ports."""

    @njit
    def rates(t, y, u, force, p):
        v, x, a, b, w = y
        demanded = within(p.drive_command_gain * u, -p.drive_max_speed, p.drive_max_speed)
        torque = within(p.drive_speed_gain * (demanded - w), -p.drive_max_torque, p.drive_max_torque)
        pumped = p.drive_displacement * w - p.drive_leakage * (a - b)
        case_a = p.drive_case_leakage * (a - p.supply_return_pressure)
        case_b = p.drive_case_leakage * (b - p.supply_return_pressure)
        into_a = pumped - case_a + replenished(a, b, p)
        out_of_b = pumped + case_b - replenished(b, a, p)
        rate_a, rate_b = chambers(x, v, a, b, into_a, out_of_b, (oil(a, p), oil(b, p)), p)
        weight = p.plant_mechanism_mass * p.plant_mechanism_gravity * p.plant_mechanism_rise
        net = p.plant_area_a * a - p.plant_area_b * b - sine(t, force, p) - weight + stops(x, v, p)
        net -= p.plant_friction_coefficient * v
        turned = (torque - p.drive_displacement * (a - b) - p.drive_viscous * w) / p.drive_inertia
        return np.array([net / p.plant_mechanism_mass, v, rate_a, rate_b, turned])

    return rates


@njit
def pump_line(w, pressure, drawn, p):
    """Rates of the supply's shaft and of its line, with relief valve and accumulator."""
    rise = pressure - p.supply_return_pressure
    torque = p.supply_speed_gain * (p.supply_demanded_speed - w)
    torque = within(torque, -p.supply_max_torque, p.supply_max_torque)
    relieved = p.supply_relief_gradient * max(pressure - p.supply_relief_cracking_pressure, 0.0)
    left = p.supply_displacement * w - p.supply_leakage * rise - relieved - drawn
    absolute = max(pressure + ATMOSPHERE, 1.0)
    gives = p.supply_volume * (1.0 / p.supply_bulk_modulus + p.supply_free_air * ATMOSPHERE / absolute**2)
    charged, n = p.supply_accumulator_precharge + ATMOSPHERE, p.supply_accumulator_exponent
    if pressure + ATMOSPHERE > charged:
        held = p.supply_accumulator_gas_volume * (charged / (pressure + ATMOSPHERE)) ** (1.0 / n)
        gives += held / (n * (pressure + ATMOSPHERE))
    turned = torque - p.supply_displacement * rise - p.supply_viscous * w
    return turned / p.supply_inertia, left / gives


@njit
def arm_angle(x, p):
    """The hinge's angle q, its rate per rod dq/dx, and the second [rad, rad/m, rad/m^2]."""
    base, pin = p.plant_mechanism_base_distance, p.plant_mechanism_pin_distance
    length = p.plant_mechanism_closed_length + x
    q = np.arccos((base * base + pin * pin - length * length) / (2.0 * base * pin))
    turn = length / (base * pin * np.sin(q))
    return q, turn, turn / length - turn * turn / np.tan(q)


@njit
def arm(x, v, p):
    """Inertia [kg] of a link on the rod, and what it resists with at constant speed [N]."""
    q, turn, bend = arm_angle(x, p)
    tip, reach = p.plant_mechanism_payload, p.plant_mechanism_reach
    inertia = p.plant_mechanism_arm_inertia + tip * reach * reach
    moment = p.plant_mechanism_arm_mass * p.plant_mechanism_centre_distance + tip * reach
    lifted = p.plant_mechanism_gravity * moment * np.cos(q - p.plant_mechanism_level_angle)
    return (
        p.plant_mechanism_moving_mass + inertia * turn * turn,
        inertia * turn * bend * v * v + lifted * turn,
    )


@njit
def link_alone(x, v, net, _y, p):
    """The rod's acceleration under a force with the link alone, and no body's."""
    mass, met = arm(x, v, p)
    return (net - met) / mass, 0.0


@njit
def link_and_body(x, v, net, y, p):
    """The rod's acceleration and the body's, which hangs from the link's tip, by Lagrange's equations."""
    phi, rate = y[5], y[6]
    mass, met = arm(x, v, p)
    q, turn, bend = arm_angle(x, p)
    q -= p.plant_mechanism_level_angle
    reach, m, c = p.plant_mechanism_reach, p.plant_carried_mass, p.plant_carried_centre_distance
    across, up = -reach * np.sin(q) * turn, reach * np.cos(q) * turn
    across_bend = -reach * (np.cos(q) * turn * turn + np.sin(q) * bend)
    up_bend = reach * (np.cos(q) * bend - np.sin(q) * turn * turn)
    sin, cos, g = np.sin(phi), np.cos(phi), p.plant_carried_gravity
    hinge = p.plant_carried_damping * (rate - turn * v)
    m11, m12 = mass + m * (across**2 + up**2), m * c * (across * cos + up * sin)
    m22 = p.plant_carried_moment_of_inertia + m * c * c
    pulled = m * ((across * across_bend + up * up_bend) * v * v + g * up)
    f1 = net - met - pulled - m * c * (up * cos - across * sin) * rate**2 + turn * hinge
    f2 = -m * c * ((across_bend * cos + up_bend * sin) * v * v + g * sin) - hinge
    free = m11 * m22 - m12 * m12
    return (m22 * f1 - m12 * f2) / free, (m11 * f2 - m12 * f1) / free


def link(oil: Callable[..., float], moved: Callable[..., tuple[float, float]], carries: bool) -> Rates:
    """A link on a hinge, a servo valve on a pump with its line; what the link carries may swing."""

    @njit
    def rates(t, y, u, force, p):
        v, x, a, b, z = y[:5]
        spool, speed, w, line = y[-4:]
        into_a, out_of_b, drawn = four_edges(spool, line, p.supply_return_pressure, a, b, p)
        rate_a, rate_b = chambers(x, v, a, b, into_a, out_of_b, (oil(a, p), oil(b, p)), p)
        bending, rubbed = bristles(v, z, p)
        net = p.plant_area_a * a - p.plant_area_b * b - sine(t, force, p) + stops(x, v, p) - rubbed
        pushed, swung = moved(x, v, net, y, p)
        turned, filled = pump_line(w, line, drawn, p)
        found = np.empty_like(y)
        found[:5] = pushed, v, rate_a, rate_b, bending
        if carries:
            found[5], found[6] = y[6], swung
        found[-4:] = speed, spool_acceleration(spool, speed, u, p), turned, filled
        return found

    return rates


OILS = {"AeratedOil": aerated, "ConstantOil": constant}
LUGRE_MASS = ("LuGre", "Mass", "NothingCarried")
VISCOUS_MASS = ("Viscous", "Mass", "NothingCarried")
ARM = ("LuGre", "OneLinkArm")
ON_VALVE = ("SecondOrderValve", "IdealSupply", "ValveOnSupply")
ON_PUMP = ("SecondOrderValve", "PumpSupply", "ValveOnSupply")
BY_PUMP = ("NoValve", "IdealSupply", "PumpDrive")
RATES: dict[tuple[str, ...], Rates] = {
    ("LoadPressurePlant", "FirstOrderValve", "IdealSupply", "ValveOnSupply"): lumped,
    **{("Cylinder", oil, *LUGRE_MASS, *ON_VALVE): axis(of) for oil, of in OILS.items()},
    **{("Cylinder", oil, *VISCOUS_MASS, *BY_PUMP): pump(of) for oil, of in OILS.items()},
    **{
        ("Cylinder", oil, *ARM, "NothingCarried", *ON_PUMP): link(of, link_alone, False)
        for oil, of in OILS.items()
    },
    **{
        ("Cylinder", oil, *ARM, "SwingingLoad", *ON_PUMP): link(of, link_and_body, True)
        for oil, of in OILS.items()
    },
}
