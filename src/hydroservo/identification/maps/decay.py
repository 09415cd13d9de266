"""Leakage and bulk modulus, from pressures that decay in blocked ports."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import ScenarioError
from hydroservo.core.formatting import plain_quantity, quantity
from hydroservo.identification.log import COMMAND
from hydroservo.identification.maps.decay_fit import (
    DecayFit,
    WatchedStretch,
    balance_columns,
    fit_balances,
    piston_moves,
    regress_balances,
    watch_stretch,
    with_exchanged_chambers,
    with_offsets,
    with_pressure_offset,
)
from hydroservo.identification.maps.piston import Piston, require_signals
from hydroservo.identification.maps.result import Interval, MapContents, curve_of
from hydroservo.identification.segments import UnderstoodLog

if TYPE_CHECKING:
    import xarray as xr

OFFSET = 1e5  # Pa, of which it is said how far it moves a leakage
CLEARER = 0.5  # times what pressures leave unexplained, below which others are the right ones
OPENED = 1e-3  # V, by which the command of a closed valve may change

Samples = NDArray[np.float64]


def decay_numbers(fit: DecayFit, piston: Piston, stretches: Sequence[WatchedStretch]) -> dict[str, Interval]:
    """Leakages, bulk modulus and time constant."""
    product = Interval.around(float(fit.across @ fit.found.values), fit.found.half(fit.across), "m^3/s", "")
    leakages = {key: one.at_least_0() for key, one in leakages_of(fit).items()}
    numbers = leakages | modulus_interval(fit, product, piston) | offset_of(fit)
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


def modulus_interval(fit: DecayFit, product: Interval, piston: Piston) -> dict[str, Interval]:
    """The bulk modulus: by a motion, or of the product that the decay tells, by the scenario's leakage."""
    if fit.seen:
        half = fit.found.half(fit.weight(-2 - fit.external))
        return {"bulk_modulus": Interval.around(fit.modulus, half, "Pa", "bulk modulus, by a motion")}
    own = getattr(piston.plant, "internal_leakage", getattr(piston.plant, "leakage", 0.0))
    if not (own > 0.0 and product.low > 0.0):
        return {}
    meaning = "bulk modulus that goes with the scenario's leakage past the piston"
    return {"bulk_modulus": product.times(1.0 / own, "Pa")._replace(meaning=meaning)}


def time_constant(product: Interval, piston: Piston, stretches: Sequence[WatchedStretch]) -> Interval:
    """V_A V_B/(V_A + V_B)/(beta C_i), with the volumes of the mean position."""
    position = np.array([np.mean(np.concatenate([one.rows["x"] for one in stretches]))])
    a, b = (float(one[0]) for one in piston.volumes(position))
    joint = 1.0 / (1.0 / a + 1.0 / b)
    meaning = "of the difference of both pressures, by leakage past the piston"
    return Interval(joint / product.value, joint / product.high, joint / product.low, "s", meaning)


def check_decays(fit: DecayFit, free: DecayFit, stretches: Sequence[WatchedStretch], name: str) -> None:
    """Refuse pressures that do not decay, unless a motion tells a bulk modulus from them."""
    leak = [*leakages_of(fit).values()]
    rises = any(one.high < 0.0 for one in leak)
    if rises and leak[0].low > 0.0:
        problem = "both pressures rise together, which leakage cannot cause; does the oil warm up?"
        raise ScenarioError(name, "", problem)
    if free.offsets and free.leaks:
        return
    if rises or not (fit.seen or any(one.low > 0.0 for one in leak)):
        apart = stretches[0].rows["a"] - stretches[0].rows["b"]
        ends = [plain_quantity(float(one), "Pa") for one in (apart[0], apart[-1])]
        lasts = stretches[0].period * (apart.size - 1)
        noise = "" if rises else " beyond their noise"
        problem = (
            f"pressures do not decay{noise}: p_A - p_B goes from {ends[0]} to {ends[1]} in {lasts:.3g} s"
        )
        raise ScenarioError(name, "", problem)


def decay_values(
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


def decay_map(logs: Sequence[UnderstoodLog], piston: Piston) -> MapContents:
    """Leakage and bulk modulus from blocked ports, each chamber's oil balanced over time::

        int V_A dp_A = c_A - beta A_A (x - x_0) - beta C_i int (p_A - p_B) dt - beta C_e int p_A dt
        int V_B dp_B = c_B + beta A_B (x - x_0) + beta C_i int (p_A - p_B) dt - beta C_e int p_B dt

    An offset of a sensor adds a ramp to each, where the decay is long enough to tell it. Least squares give
    beta, beta C_i and beta C_e. Where the piston does not move, beta is not among them: a decay alone tells
    the products. Leakages then go with the scenario's bulk modulus, and the bulk modulus with the scenario's
    leakage.

    Source: the continuity of flow; Merritt, Hydraulic Control Systems, 1967, ch. 6; least squares.
    Fails where the valve's own leakage counts, which is taken for that of the cylinder: ports must be plugged
    or a valve with overlap closed; and where the bulk modulus changes much over the pressures of the log, of
    which it is a mean.
    """
    for log in logs:
        check_decay_signals(log, piston)
    stretches = [watch_stretch(one, piston) for log in logs for one in log.segments]
    name = logs[0].log.name
    check_motion(stretches, piston, name)
    fit = fit_balances(stretches, piston)
    if fit is None:
        raise ScenarioError(name, "", "its pressures show no leakage: they are too similar")
    free = with_offsets(fit, stretches, piston)
    check_decays(fit, free, stretches, name)
    check_volumes(free, stretches, piston, name)
    fit = free.without_negative_leakage()
    numbers = decay_numbers(fit, piston, stretches)
    values, remarks = decay_values(fit, numbers, piston)
    if not fit.offsets:
        remarks.append(offset_remark(fit, stretches, piston))
    return MapContents(pressures_of(fit, stretches, piston), numbers, (), values, remarks)


def check_motion(stretches: Sequence[WatchedStretch], piston: Piston, name: str) -> None:
    """Refuse pressures that a motion moves the wrong way."""
    fit = regress_balances(stretches, piston, True) if any(map(piston_moves, stretches)) else None
    if fit is not None and fit.modulus + fit.found.half(fit.weight(fit.stretches + fit.offsets)) < 0.0:
        problem = (
            "pressures rise where the motion leaves the oil more room: pressure_a and pressure_b are "
            "swapped, or position is reversed"
        )
        raise ScenarioError(name, "", problem)


def check_volumes(fit: DecayFit, stretches: Sequence[WatchedStretch], piston: Piston, name: str) -> None:
    """Refuse pressures that the volumes of both chambers explain far better when exchanged."""
    other = regress_balances(
        [with_exchanged_chambers(one, piston) for one in stretches], piston, fit.seen, fit.offsets
    )
    if other is not None and other.found.scatter < CLEARER * fit.found.scatter:
        problem = (
            "the volumes of both chambers explain the decay far better with pressure_a and pressure_b "
            "exchanged: these are swapped, or the scenario's volumes or the position wrong"
        )
        raise ScenarioError(name, "", problem)


def offset_remark(fit: DecayFit, stretches: Sequence[WatchedStretch], piston: Piston) -> str:
    """By how much an offset of a sensor, which this decay does not tell, would move the leakage."""
    shifted = [with_pressure_offset(OFFSET, one, piston) for one in stretches]
    again = regress_balances(shifted, piston, fit.seen)
    said = "the decay is too short to tell an offset of a pressure sensor from leakage"
    own = float(fit.across @ fit.found.values)
    if again is None or not own > 0.0:
        return said
    share = abs(float(again.across @ again.found.values) * fit.modulus / again.modulus / own - 1.0)
    return f"{said}: one of {quantity(OFFSET, 'Pa')} moves internal_leakage by {100.0 * share:.2g} %"


def check_decay_signals(log: UnderstoodLog, piston: Piston) -> None:
    """Refuse a log that is none of blocked ports."""
    by_hydraulic_force = not piston.has_chambers and any(
        "hydraulic_force" in one.measured for one in log.segments
    )
    if not by_hydraulic_force:
        for name in ("pressure_a", "pressure_b"):
            require_signals(log, (name,), "a decay")
    for one in log.segments:
        command = one.inputs.get(COMMAND)
        if command is not None and np.ptp(command) > OPENED:
            changed = quantity(float(np.ptp(command)), "V")
            problem = f"changes by {changed}: ports must be blocked, with the valve at rest"
            raise ScenarioError(log.log.name, "command", problem)


def fitted_pressures(fit: DecayFit, place: int, one: WatchedStretch, piston: Piston) -> dict[str, Samples]:
    """The pressures of both chambers that the balances give."""
    found = {}
    volumes = piston.volumes(one.rows["x"])
    for j, chamber in enumerate("ab"):
        own = one.balances[j]
        given = (
            balance_columns(own, place + j, fit.stretches, fit.external, fit.seen, fit.offsets)
            @ fit.found.values
        )
        beside = given - own.raised + (0.0 if fit.seen else fit.modulus * own.swept)
        found[chamber] = one.rows[chamber] + beside / volumes[j]
    return found


def pressures_of(fit: DecayFit, stretches: Sequence[WatchedStretch], piston: Piston) -> "xr.Dataset":
    """Pressures and position over time, with the pressures that the balances give."""
    rows: dict[str, list[Samples]] = {}
    for i, one in enumerate(stretches):
        shown = {"time": one.time}
        for chamber, values in fitted_pressures(fit, 2 * i, one, piston).items():
            shown |= {f"pressure_{chamber}": one.rows[chamber], f"pressure_{chamber}_fitted": values}
        shown |= {"position": one.rows["x"], "log": np.full(one.time.size, float(one.segment.log + 1))}
        for name, values in shown.items():
            rows.setdefault(name, []).append(values)
    about = {"time": ("s", "time"), "position": ("m", "position"), "log": ("", "number of the log")}
    said = {name: about.get(name, ("Pa", name.replace("_", " "))) for name in rows}
    return curve_of({name: np.concatenate(parts) for name, parts in rows.items()}, said)
