"""What a run is given, as one row of numbers: all that the peers know of a loop."""

from collections.abc import Mapping
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from hydroservo import Loop
from hydroservo.core.block import value_at

__all__ = ["AXIS", "LAW", "MACHINE", "named", "table"]

# By name, the path in the loop. The order is that of the struct Given in c/laws.h.
MACHINE = {
    "mass": "plant.mass",
    "damping": "plant.damping",
    "area": "plant.piston_area",
    "volume": "plant.total_volume",
    "bulk_modulus": "plant.bulk_modulus",
    "leakage": "plant.leakage",
    "start_position": "plant.start_position",
    "discharge": "valve.orifice.discharge_coefficient",
    "gradient": "valve.orifice.area_gradient",
    "density": "valve.orifice.density",
    "valve_gain": "valve.gain",
    "max_opening": "valve.max_opening",
    "supply": "supply.supply_pressure",
    "reference_amplitude": "reference.amplitude",
    "reference_frequency": "reference.frequency",
    "load_amplitude": "load.amplitude",
    "load_frequency": "load.frequency",
}
LAW = {
    "nominal_mass": "controller.model.plant.mass",
    "nominal_damping": "controller.model.plant.damping",
    "nominal_area": "controller.model.plant.piston_area",
    "nominal_volume": "controller.model.plant.total_volume",
    "nominal_bulk_modulus": "controller.model.plant.bulk_modulus",
    "nominal_leakage": "controller.model.plant.leakage",
    "nominal_discharge": "controller.model.orifice.discharge_coefficient",
    "nominal_gradient": "controller.model.orifice.area_gradient",
    "nominal_density": "controller.model.orifice.density",
    "nominal_supply": "controller.model.supply.supply_pressure",
    "nominal_valve_gain": "controller.model.valve_gain",
    "least_drop": "controller.model.least_drop",
    "mu1": "controller.linear_gain_1",
    "mu2": "controller.linear_gain_2",
    "delta1": "controller.power_gain_1",
    "delta2": "controller.power_gain_2",
    "a1": "controller.exponent_1",
    "a2": "controller.exponent_2",
    "least_xi": "controller.reaching.least_surface",
    "limit": "controller.saturation.limit",
    "kd1": "controller.observer.linear_gain_1",
    "kd2": "controller.observer.linear_gain_2",
    "D1": "controller.observer.switching_gain_1",
    "D2": "controller.observer.switching_gain_2",
    "eps1": "controller.observer.power_gain_1",
    "eps2": "controller.observer.power_gain_2",
    "a": "controller.observer.exponent",
    "phi1": "controller.observer.realisation.velocity_thickness",
    "phi2": "controller.observer.realisation.force_thickness",
    "time_constant": "controller.derivative.time_constant",
}

# The same of the axis under position control; the order is that of NUMBERS in c/axis.c.
AXIS = {
    "mass": "plant.mechanism.mass",
    "area_a": "plant.area_a",
    "area_b": "plant.area_b",
    "stroke": "plant.stroke",
    "dead_a": "plant.dead_volume_a",
    "dead_b": "plant.dead_volume_b",
    "leakage": "plant.internal_leakage",
    "position": "plant.start_position",
    "pressure_a": "plant.start_pressure_a",
    "pressure_b": "plant.start_pressure_b",
    "liquid": "plant.oil.liquid_bulk_modulus",
    "air": "plant.oil.air_content",
    "index": "plant.oil.polytropic_index",
    "bristles": "plant.friction.bristle_stiffness",
    "bending": "plant.friction.bristle_damping",
    "coulomb": "plant.friction.coulomb",
    "breakaway": "plant.friction.breakaway",
    "slip": "plant.friction.stribeck_velocity",
    "viscous": "plant.friction.viscous",
    "contact": "plant.stops.stiffness",
    "loss": "plant.stops.dissipation",
    "gain": "valve.gain",
    "omega": "valve.natural_frequency",
    "zeta": "valve.damping_ratio",
    "travel": "valve.max_opening",
    "slew": "valve.slew_limit",
    "hysteresis": "valve.hysteresis",
    "discharge": "valve.orifice.discharge_coefficient",
    "gradient": "valve.orifice.area_gradient",
    "density": "valve.orifice.density",
    "lap": "valve.orifice.lap",
    "clearance": "valve.orifice.clearance",
    "transition": "valve.orifice.transition_drop",
    "ratio_b": "valve.orifice.area_ratio_b",
    "supply": "supply.supply_pressure",
    "tank": "supply.return_pressure",
    "delay": "hold.delay",
    "from": "reference.initial",
    "to": "reference.final",
    "speed": "reference.rate",
    "begin": "reference.time",
    "load": "load.final",
    "load_time": "load.time",
    "kp": "controller.controller.proportional_gain",
    "ki": "controller.controller.integral_gain",
    "kv": "controller.controller.rate_feedforward",
    "windup": "controller.controller.anti_windup",
    "integral_limit": "controller.controller.integral_limit",
    "limit": "controller.saturation.limit",
    "extend": "controller.extend_overlap",
    "retract": "controller.retract_overlap",
    "threshold": "controller.threshold",
}


def table(
    loop: Loop, paths: Mapping[str, str], varied: Mapping[str, NDArray[np.float64]]
) -> NDArray[np.float64]:
    """A row of numbers for each run: those of the loop, or the run's own; shape (runs, paths)."""
    runs = max((values.size for values in varied.values()), default=1)
    columns = [np.broadcast_to(varied.get(path, value_at(loop, path)), runs) for path in paths.values()]
    return np.column_stack(columns).astype(np.float64)


def named(loop: Loop, paths: Mapping[str, str], varied: Mapping[str, NDArray[np.float64]]) -> SimpleNamespace:
    """The same by name: what varies as an array over the runs, the rest as plain numbers."""
    return SimpleNamespace(
        **{name: varied[path] if path in varied else value_at(loop, path) for name, path in paths.items()}
    )
