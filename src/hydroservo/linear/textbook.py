"""What a textbook says of a machine about a point: the piston's mass on its two columns of oil."""

import math
from collections.abc import Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np

from hydroservo.core.field import Field
from hydroservo.linear.operating_point import OperatingPoint
from hydroservo.linear.slopes import slopes
from hydroservo.linear.system import machine_slopes
from hydroservo.machine.plants import Cylinder, LoadPressurePlant

DRAINED = 0.5  # of the natural frequency, above which a column that drains so fast is no spring


class Textbook(NamedTuple):
    """The formulas of hydraulics for a machine about a point."""

    stiffness: Annotated[float, Field("N/m", "of the oil columns, k_h")]
    mass: Annotated[float, Field("kg", "that they move, m")]
    natural_frequency: Annotated[float, Field("rad/s", "omega_h = sqrt(k_h/m)")]
    damping_ratio: Annotated[
        float, Field("", "zeta_h, from leakage, flow-pressure coefficients and friction")
    ]


class OilColumn(NamedTuple):
    """A column of oil, or two that are alike as one."""

    area: float  # of the piston towards it [m^2]
    rise: float  # of its pressure per oil that comes in, beta_i/V_i [Pa/m^3]
    leak: float  # oil that leaves it per pressure [m^3/(s Pa)]


def textbook(point: OperatingPoint) -> Textbook | None:
    """Natural frequency and damping ratio of a machine by formulas; None where they do not hold.

    With A_i, beta_i/V_i and K_i the area, the pressure rise and all that lets oil out by pressure, of each
    column (the valve's flow-pressure coefficient, leakage past the piston and to the outside)::

        k_h = sum A_i^2 beta_i/V_i,   omega_h = sqrt(k_h/m)
        zeta_h = (sum A_i^2 (beta_i/V_i)^2 K_i/k_h + b/m)/(2 omega_h)

    For two equal columns zeta_h is K_ce/A sqrt(beta m/V_t) + b/(4 A) sqrt(V_t/(beta m)).

    They hold for plants with a load pressure or two chambers. A column whose K_i beta_i/V_i is not small
    against omega_h, as behind an open check valve, is not a spring: where one of two has more than half of
    omega_h the result is None.

    Source: Merritt, Hydraulic Control Systems, 1967, sec. 6-1; Jelali and Kroll, Hydraulic Servo-systems,
    2003, ch. 4 for two columns that differ.
    Fails beside hoses, what swings on the rod, friction with bristles or a supply that gives way, which it
    leaves out.
    """
    plant: Any = point.loop.plant
    s = point.machine.plant
    if isinstance(plant, LoadPressurePlant):
        mass, columns = plant.mass, [joint_oil_column(point)]
    elif isinstance(plant, Cylinder):
        mass, columns = plant.carried.inertia(s.carried, plant.mechanism, s.position), oil_columns(point)
    else:
        return None
    friction = -mass * float(machine_slopes(point).mean[0, 0])
    stiffness = math.fsum(one.area**2 * one.rise for one in columns)
    lost = math.fsum((one.area * one.rise) ** 2 * one.leak for one in columns) / stiffness
    frequency = math.sqrt(stiffness / mass)
    if len(columns) > 1 and max(one.leak * one.rise for one in columns) > DRAINED * frequency:
        return None
    return Textbook(stiffness, mass, frequency, (lost + friction / mass) / (2.0 * frequency))


def joint_oil_column(point: OperatingPoint) -> OilColumn:
    """Both columns of a plant that is described by its load pressure."""
    plant: Any = point.loop.plant
    x = point.machine.plant

    def rows(here: OperatingPoint, numbers: Sequence[Any]) -> list[Any]:
        return [here.loop.ports(here.machine, point.command).load_flow(numbers[0])]

    at = np.array([plant.load_pressure(x)])
    by_pressure = slopes(rows, point, at, np.array([1e6])).mean
    rise = 4.0 * plant.bulk_modulus / plant.total_volume
    return OilColumn(plant.piston_area, rise, plant.leakage - float(by_pressure[0, 0]))


def oil_columns(point: OperatingPoint) -> list[OilColumn]:
    """The columns of a cylinder's two chambers, whose pressures swing against each other."""
    plant: Any = point.loop.plant
    x = point.machine.plant

    def rows(here: OperatingPoint, numbers: Sequence[Any]) -> list[Any]:
        flows = here.loop.ports(here.machine, point.command).flows(*numbers)
        return [flows.a, flows.b]

    at = np.array([x.pressure_a, x.pressure_b])
    (into_a, _), (_, out_of_b) = slopes(rows, point, at, np.array([1e6, 1e6])).mean.tolist()
    rise_a, rise_b = plant.stiffness_a(x), plant.stiffness_b(x)
    swing = plant.area_b * rise_b / (plant.area_a * rise_a)  # of p_B by that of p_A
    leak, outside = plant.internal_leakage, plant.external_leakage
    return [
        OilColumn(plant.area_a, rise_a, outside + leak * (1.0 + swing) - into_a),
        OilColumn(plant.area_b, rise_b, outside + leak * (1.0 + 1.0 / swing) + out_of_b),
    ]
