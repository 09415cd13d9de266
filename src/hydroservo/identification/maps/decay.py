"""Leakage and bulk modulus, from pressures that decay in blocked ports."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import ScenarioError
from hydroservo.formatting import MINUS, quantity
from hydroservo.identification.maps.balances import Balance, Watched, balances, watched
from hydroservo.identification.maps.piston import Piston
from hydroservo.identification.maps.reading import demand
from hydroservo.identification.maps.regression import Regression, regression
from hydroservo.identification.maps.result import Found, Interval, curve_of
from hydroservo.identification.segments import Understood
from hydroservo.identification.signals import COMMAND
from hydroservo.identification.spikes import noise_of

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["decay"]

SURE = 0.5  # half of an interval over its number, up to which a bulk modulus is told by a motion
DRAWS = 40  # of noise, that say how much of it integrals gather
STEPS = 5.0  # deviations of the position's noise, that a motion goes
OPENED = 1e-3  # V, by which the command of a closed valve may change

Samples = NDArray[np.float64]


class Told(NamedTuple):
    """What the regression tells.

    Attributes:
        found: the regression.
        modulus: the bulk modulus [Pa], as found, or that of the scenario.
        seen: whether a motion tells it.
        external: whether leakage to the outside is among the columns.
    """

    found: Regression
    modulus: float
    seen: bool
    external: bool


def decay(logs: Sequence[Understood], piston: Piston) -> Found:
    """Leakage and bulk modulus from blocked ports, each chamber's oil balanced over time::

        int V_A dp_A = c_A - beta A_A (x - x_0) - beta C_i int (p_A - p_B) dt - beta C_e int p_A dt
        int V_B dp_B = c_B + beta A_B (x - x_0) + beta C_i int (p_A - p_B) dt - beta C_e int p_B dt

    Least squares give beta, beta C_i and beta C_e. Where the piston does not move, beta is not among them: a
    decay alone tells the products. Leakages then go with the scenario's bulk modulus, and the bulk modulus
    with the scenario's leakage.

    Args:
        logs: with both pressures, or the load force of a plant described by it; and the position where the
            piston moves.
        piston: of the scenario's plant: areas and volumes.

    Raises:
        ScenarioError: a log lacks a signal, its command changes, or its pressures do not decay.

    Source: the continuity of flow; Merritt, Hydraulic Control Systems, 1967, ch. 6; least squares.
    Fails where the valve's own leakage counts, which is taken for that of the cylinder: ports must be plugged
    or a valve with overlap closed; and where the bulk modulus changes much over the pressures of the log, of
    which it is a mean.
    """
    for log in logs:
        check_signals(log, piston)
    stretches = [watched(one, piston) for log in logs for one in log.segments]
    name = logs[0].log.name
    told = told_of(stretches, piston)
    if told is None:
        raise ScenarioError(name, "", "its pressures show no leakage: they are too similar")
    numbers = numbers_of(told, piston, stretches)
    check_decays(told, numbers, stretches, name)
    values, remarks = values_of(told, numbers, piston)
    return Found(pressures_of(told, stretches, piston), numbers, (), values, remarks)


def check_signals(log: Understood, piston: Piston) -> None:
    """Refuse a log that is none of blocked ports.

    Raises:
        ScenarioError: it lacks pressures, or its command changes.
    """
    alone = not piston.has_chambers and any("load_force" in one.measured for one in log.segments)
    if not alone:
        for name in ("pressure_a", "pressure_b"):
            demand(log, (name,), "a decay")
    for one in log.segments:
        command = one.inputs.get(COMMAND)
        if command is not None and np.ptp(command) > OPENED:
            changed = quantity(float(np.ptp(command)), "V")
            problem = f"changes by {changed}: ports must be blocked, with the valve at rest"
            raise ScenarioError(log.log.name, "command", problem)


def moves(one: Watched) -> bool:
    """Whether the piston moves by more than its sensor's noise."""
    position = one.segment.measured.get("position")
    return position is not None and float(np.ptp(one.rows["x"])) > STEPS * noise_of(position)


def told_of(stretches: Sequence[Watched], piston: Piston) -> Told | None:
    """What the balances tell, with the bulk modulus where a motion shows it.

    Noise of a pressure adds up in its integral, which no covariance of what is left knows of: how far the
    numbers move when as much noise is added once more counts too.
    """
    told = None
    if any(map(moves, stretches)):
        told = regressed(stretches, piston, True)
        if told is not None:
            modulus = np.eye(told.found.values.size)[2 * len(stretches)]
            told = told if told.found.half(modulus) < SURE * told.modulus else None
    told = told or regressed(stretches, piston, False)
    if told is None:
        return None
    rng = np.random.default_rng(0)
    again = [
        regressed([noisier(one, rng, piston) for one in stretches], piston, told.seen) for _ in range(DRAWS)
    ]
    values = np.array([one.found.values for one in again if one is not None])
    covariance = told.found.covariance + np.cov(values.T)
    return told._replace(found=told.found._replace(covariance=covariance))


def noisier(one: Watched, rng: np.random.Generator, piston: Piston) -> Watched:
    """A stretch whose pressures have noise of their own size once more."""
    noisy = {
        chamber: one.rows[chamber] + rng.normal(scale=noise_of(one.rows[chamber]), size=one.time.size)
        for chamber in "ab"
    }
    rows = one.rows | noisy
    return one._replace(rows=rows, balances=balances(rows, one.period, piston))


def regressed(stretches: Sequence[Watched], piston: Piston, seen: bool) -> Told | None:
    """The regression, with the bulk modulus or with that of the scenario; None if columns are too alike."""
    external = hasattr(piston.plant, "external_leakage")
    place = 2 * len(stretches)
    chambers = list(enumerate(one for stretch in stretches for one in stretch.balances))
    known = modulus_of(piston, stretches)
    found = regression(
        [
            (columns(one, i, place, external, seen), one.raised - (0.0 if seen else known * one.swept))
            for i, one in chambers
        ]
    )
    if found is None:
        return None
    return Told(found, float(found.values[place]) if seen else known, seen, external)


def fitted(told: Told, place: int, one: Watched, piston: Piston) -> dict[str, Samples]:
    """The pressures of both chambers that the balances give.

    Args:
        told: the regression.
        place: of chamber A's constant among its columns.
        one: the stretch.
        piston: of the plant.
    """
    found = {}
    count = told.found.values.size - 1 - told.external - told.seen
    volumes = piston.volumes(one.rows["x"])
    for j, chamber in enumerate("ab"):
        own = one.balances[j]
        given = columns(own, place + j, count, told.external, told.seen) @ told.found.values
        beside = given - own.raised + (0.0 if told.seen else told.modulus * own.swept)
        found[chamber] = one.rows[chamber] + beside / volumes[j]
    return found


def columns(one: Balance, place: int, count: int, external: bool, moved: bool) -> Samples:
    """What a chamber's balance is owed to: a constant of its own, motion, leakages."""
    own = np.zeros((one.raised.size, count))
    own[:, place] = 1.0
    more = [one.swept] * moved + [one.across] + [one.outside] * external
    return np.column_stack([own, *more])


def modulus_of(piston: Piston, stretches: Sequence[Watched]) -> float:
    """The scenario's bulk modulus at the mean pressure of the logs [Pa]."""
    if not piston.has_chambers:
        return float(piston.plant.bulk_modulus)
    mean = float(np.mean([0.5 * (one.rows["a"].mean() + one.rows["b"].mean()) for one in stretches]))
    return float(piston.plant.oil.bulk_modulus(mean))


def numbers_of(told: Told, piston: Piston, stretches: Sequence[Watched]) -> dict[str, Interval]:
    """Leakages, bulk modulus and time constant."""
    found, size = told.found, told.found.values.size
    every = np.eye(size)
    across = every[size - 1 - told.external]
    products = {"internal_leakage": across} | ({"external_leakage": every[-1]} if told.external else {})
    meanings = {
        "internal_leakage": "leakage coefficient past the piston",
        "external_leakage": "leakage coefficient of each chamber to the outside",
    }
    numbers = {}
    for name, weights in products.items():
        if told.seen:
            value, half = found.ratio(weights, every[size - 2 - told.external])
        else:
            value, half = float(weights @ found.values) / told.modulus, found.half(weights) / told.modulus
        numbers[name] = Interval.around(value, half, "m^3/(s Pa)", meanings[name])
    unit = "Pa"
    if told.seen:
        half = found.half(every[size - 2 - told.external])
        numbers["bulk_modulus"] = Interval.around(told.modulus, half, unit, "bulk modulus, by a motion")
    own = getattr(piston.plant, "internal_leakage", getattr(piston.plant, "leakage", 0.0))
    product = Interval.around(float(across @ found.values), found.half(across), "m^3/s", "")
    if not told.seen and own > 0.0 and product.low > 0.0:
        meaning = "bulk modulus that goes with the scenario's leakage past the piston"
        numbers["bulk_modulus"] = product.times(1.0 / own, unit)._replace(meaning=meaning)
    if product.low > 0.0:
        position = np.array([np.mean(np.concatenate([one.rows["x"] for one in stretches]))])
        a, b = (float(one[0]) for one in piston.volumes(position))
        joint = 1.0 / (1.0 / a + 1.0 / b)
        numbers["time_constant"] = Interval(
            joint / product.value,
            joint / product.high,
            joint / product.low,
            "s",
            "of the difference of both pressures, by leakage past the piston",
        )
    return numbers


def check_decays(
    told: Told, numbers: Mapping[str, Interval], stretches: Sequence[Watched], name: str
) -> None:
    """Refuse pressures that do not decay, unless a motion tells a bulk modulus from them.

    Raises:
        ScenarioError: they do not.
    """
    leak = [numbers[one] for one in ("internal_leakage", "external_leakage") if one in numbers]
    rises = any(one.high < 0.0 for one in leak)
    if rises or not (told.seen or any(one.low > 0.0 for one in leak)):
        apart = stretches[0].rows["a"] - stretches[0].rows["b"]
        ends = [quantity(float(one), "Pa").replace(MINUS, "-") for one in (apart[0], apart[-1])]
        lasts = stretches[0].period * (apart.size - 1)
        problem = f"pressures do not decay: p_A - p_B goes from {ends[0]} to {ends[1]} in {lasts:.3g} s"
        raise ScenarioError(name, "", problem)


def values_of(
    told: Told, numbers: Mapping[str, Interval], piston: Piston
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
            remarks.append(f"{name} is not told from none: the scenario keeps its own")
    if not told.seen:
        remarks.append(
            f"the piston is not seen to move: leakages go with the scenario's bulk modulus of "
            f"{quantity(told.modulus, 'Pa')}"
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


def pressures_of(told: Told, stretches: Sequence[Watched], piston: Piston) -> "xr.Dataset":
    """Pressures and position over time, with the pressures that the balances give."""
    rows: dict[str, list[Samples]] = {}
    for i, one in enumerate(stretches):
        shown = {"time": one.time}
        for chamber, values in fitted(told, 2 * i, one, piston).items():
            shown |= {f"pressure_{chamber}": one.rows[chamber], f"pressure_{chamber}_fitted": values}
        shown |= {"position": one.rows["x"], "log": np.full(one.time.size, float(one.segment.log + 1))}
        for name, values in shown.items():
            rows.setdefault(name, []).append(values)
    about = {"time": ("s", "time"), "position": ("m", "position"), "log": ("", "number of the log")}
    said = {name: about.get(name, ("Pa", name.replace("_", " "))) for name in rows}
    return curve_of({name: np.concatenate(parts) for name, parts in rows.items()}, said)
