"""Leakages, bulk modulus and time constant from what the oil's balances tell."""

from collections.abc import Mapping, Sequence

import numpy as np

from hydroservo.errors import ScenarioError
from hydroservo.formatting import MINUS, quantity
from hydroservo.identification.maps.balances import Watched
from hydroservo.identification.maps.decay_fit import DecayFit
from hydroservo.identification.maps.reading import Piston
from hydroservo.identification.maps.result import Interval


def numbers_of(fit: DecayFit, piston: Piston, stretches: Sequence[Watched]) -> dict[str, Interval]:
    """Leakages, bulk modulus and time constant."""
    product = Interval.around(float(fit.across @ fit.found.values), fit.found.half(fit.across), "m^3/s", "")
    leakages = {key: one.at_least_0() for key, one in leakages_of(fit).items()}
    numbers = leakages | modulus_of(fit, product, piston) | offset_of(fit)
    if product.low > 0.0:
        numbers["time_constant"] = time_constant(product, piston, stretches)
    return numbers


def leakages_of(fit: DecayFit) -> dict[str, Interval]:
    """Leakage coefficients: of the products, each over the bulk modulus."""
    leak = "leakage coefficient"
    products = {"internal_leakage": (fit.across, f"{leak} past the piston")}
    if fit.external:
        products["external_leakage"] = fit.weight(-1), f"{leak} of each chamber to the outside"
    numbers = {}
    for name, (weights, meaning) in products.items():
        if fit.seen:
            value, half = fit.found.ratio(weights, fit.weight(-2 - fit.external))
        else:
            value, half = (
                float(weights @ fit.found.values) / fit.modulus,
                fit.found.half(weights) / fit.modulus,
            )
        numbers[name] = Interval.around(value, half, "m^3/(s Pa)", meaning)
    return numbers


def offset_of(fit: DecayFit) -> dict[str, Interval]:
    """What pressure_a shows more than pressure_b where both are alike, by the ramps that it makes.

    With offsets o_A, o_B and D = o_A - o_B the ramps are beta (C_i D + C_e o_A) and beta (-C_i D + C_e o_B).
    """
    if not fit.offsets or not fit.across @ fit.found.values > 0.0:
        return {}
    above, below = fit.weight(fit.stretches), fit.across.copy()
    if fit.offsets > 1:
        above, below = above - fit.weight(fit.stretches + 1), 2.0 * below
        below += fit.weight(-1) if fit.external else 0.0
    meaning = "offset of the sensor of pressure_a less that of pressure_b"
    return {"pressure_offset": Interval.around(*fit.found.ratio(above, below), "Pa", meaning)}


def modulus_of(fit: DecayFit, product: Interval, piston: Piston) -> dict[str, Interval]:
    """The bulk modulus: by a motion, or of the product that the decay tells, by the scenario's leakage."""
    if fit.seen:
        half = fit.found.half(fit.weight(-2 - fit.external))
        return {"bulk_modulus": Interval.around(fit.modulus, half, "Pa", "bulk modulus, by a motion")}
    own = getattr(piston.plant, "internal_leakage", getattr(piston.plant, "leakage", 0.0))
    if not (own > 0.0 and product.low > 0.0):
        return {}
    meaning = "bulk modulus that goes with the scenario's leakage past the piston"
    return {"bulk_modulus": product.times(1.0 / own, "Pa")._replace(meaning=meaning)}


def time_constant(product: Interval, piston: Piston, stretches: Sequence[Watched]) -> Interval:
    """V_A V_B/(V_A + V_B)/(beta C_i), with the volumes of the mean position."""
    position = np.array([np.mean(np.concatenate([one.rows["x"] for one in stretches]))])
    a, b = (float(one[0]) for one in piston.volumes(position))
    joint = 1.0 / (1.0 / a + 1.0 / b)
    meaning = "of the difference of both pressures, by leakage past the piston"
    return Interval(joint / product.value, joint / product.high, joint / product.low, "s", meaning)


def check_decays(fit: DecayFit, free: DecayFit, stretches: Sequence[Watched], name: str) -> None:
    """Refuse pressures that do not decay, unless a motion tells a bulk modulus from them.

    Args:
        fit: without offsets of sensors.
        free: with them, where the decay tells them.
        stretches: of the logs.
        name: of the first log.
    """
    leak = [*leakages_of(fit).values()]
    rises = any(one.high < 0.0 for one in leak)
    if rises and leak[0].low > 0.0:
        problem = "both pressures rise together, which leakage cannot cause; does the oil warm up?"
        raise ScenarioError(name, "", problem)
    if free.offsets and free.leaks:
        return
    if rises or not (fit.seen or any(one.low > 0.0 for one in leak)):
        apart = stretches[0].rows["a"] - stretches[0].rows["b"]
        ends = [quantity(float(one), "Pa").replace(MINUS, "-") for one in (apart[0], apart[-1])]
        lasts = stretches[0].period * (apart.size - 1)
        noise = "" if rises else " beyond their noise"
        problem = (
            f"pressures do not decay{noise}: p_A - p_B goes from {ends[0]} to {ends[1]} in {lasts:.3g} s"
        )
        raise ScenarioError(name, "", problem)


def values_of(
    fit: DecayFit, numbers: Mapping[str, Interval], piston: Piston
) -> tuple[dict[str, Interval], list[str]]:
    """The numbers of the scenario's plant, and what a user should know."""
    inner = "internal_leakage" if piston.has_chambers else "leakage"
    places = {"internal_leakage": f"plant.{inner}", "external_leakage": "plant.external_leakage"}
    values, remarks = {}, []
    for name, path in places.items():
        if name not in numbers:
            continue
        if numbers[name].low > 0.0:
            values[path] = numbers[name]
        else:
            remarks.append(f"{name} cannot be told from none: the scenario keeps its own")
    if not fit.seen:
        remarks.append(
            f"the piston is not seen to move: leakages go with the scenario's bulk modulus of "
            f"{quantity(fit.modulus, 'Pa')}"
        )
        return values, remarks
    if not piston.has_chambers:
        values["plant.bulk_modulus"] = numbers["bulk_modulus"]
    elif hasattr(piston.plant.oil, "effective_bulk_modulus"):
        values["plant.oil.effective_bulk_modulus"] = numbers["bulk_modulus"]
    else:
        oil = type(piston.plant.oil).__name__
        remarks.append(
            f"{oil} has no bulk modulus of its own that would be written: it changes with pressure"
        )
    return values, remarks
