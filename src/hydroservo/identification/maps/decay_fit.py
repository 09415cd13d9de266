"""What the oil's balances in blocked ports tell, by least squares."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.identification.maps.piston import Piston, bridge_gaps
from hydroservo.identification.regression import Regression, regression, thin_out
from hydroservo.identification.segments import Segment, noise_of

SIGMAS = 5.0  # of its noise: a pressure further below 0 is truly negative, and drives no oil out

Samples = NDArray[np.float64]
SURE = 0.5  # half of an interval over its number, up to which a bulk modulus is told by a motion
DRAWS = 40  # of noise, that say how much of it integrals gather
STEPS = 5.0  # deviations of the position's noise, that a motion goes


class Balance(NamedTuple):
    """One chamber's oil over a stretch: what rises in its pressure, and what that is owed to."""

    raised: Samples  # the integral of V dp [m^3 Pa]
    swept: Samples  # what the piston leaves to the chamber [m^3]
    across: Samples  # the integral of the pressure that drives oil in past the piston [Pa s]
    outside: Samples  # the integral of that which drives it in from outside, none where it is below 0 [Pa s]
    pressed: Samples  # the same of any sign, as that of a sensor with an offset may have [Pa s]
    duration: float  # of the stretch [s]


class WatchedStretch(NamedTuple):
    """A stretch with the balances of both its chambers."""

    segment: Segment  # the stretch
    period: float  # between its samples here [s]
    rows: dict[str, Samples]  # pressures ``a`` and ``b`` [Pa] and position ``x`` [m], shape (n,)
    balances: Sequence[Balance]  # of chamber A and of chamber B

    @property
    def time(self) -> Samples:
        """Instants on the log's clock [s]."""
        offset = 0.5 * (self.period - self.segment.period)
        places = np.arange(self.rows["a"].size, dtype=np.float64)
        return self.segment.start + offset + self.period * places


def watch_stretch(one: Segment, piston: Piston) -> WatchedStretch:
    """What a stretch shows of both chambers."""
    measured = one.measured
    if {"pressure_a", "pressure_b"} <= set(measured):
        rows = {"a": measured["pressure_a"], "b": measured["pressure_b"]}
    else:
        half = 0.5 * measured["hydraulic_force"] / piston.area_a
        rows = {"a": half, "b": -half}
    rows["x"] = measured.get("position", np.full(one.samples, piston.plant.start_position))
    period, few = thin_out(one.period, rows)
    whole = {name: bridge_gaps(values, one.log) for name, values in few.items()}
    return WatchedStretch(one, period, whole, chamber_balances(whole, period, piston))


def with_pressure_offset(offset: float, one: WatchedStretch, piston: Piston) -> WatchedStretch:
    """A stretch whose sensor of pressure A shows so much more [Pa]."""
    rows = one.rows | {"a": one.rows["a"] + offset}
    return one._replace(rows=rows, balances=chamber_balances(rows, one.period, piston))


def with_exchanged_chambers(one: WatchedStretch, piston: Piston) -> WatchedStretch:
    """A stretch with the pressures of both chambers exchanged."""
    rows = one.rows | {"a": one.rows["b"], "b": one.rows["a"]}
    return one._replace(rows=rows, balances=chamber_balances(rows, one.period, piston))


def chamber_balances(rows: Mapping[str, Samples], period: float, piston: Piston) -> list[Balance]:
    """The balances of both chambers."""
    a, b, x = rows["a"], rows["b"], rows["x"]
    volume_a, volume_b = piston.volumes(x)
    gone, past, lasts = x - x[0], integral(a - b, period), period * (x.size - 1)
    outside = [-integral(np.where(p > -SIGMAS * noise_of(p), p, 0.0), period) for p in (a, b)]
    return [
        Balance(
            stieltjes(volume_a, a), -piston.area_a * gone, -past, outside[0], -integral(a, period), lasts
        ),
        Balance(stieltjes(volume_b, b), piston.area_b * gone, past, outside[1], -integral(b, period), lasts),
    ]


def integral(values: Samples, period: float) -> Samples:
    """Over time, by trapezia, from 0."""
    from scipy.integrate import cumulative_trapezoid

    return np.asarray(cumulative_trapezoid(values, dx=period, initial=0.0), dtype=np.float64)


def stieltjes(volume: Samples, pressure: Samples) -> Samples:
    """The integral of V dp, from 0."""
    means = 0.5 * (volume[1:] + volume[:-1])
    return np.asarray(np.concatenate([[0.0], np.cumsum(means * np.diff(pressure))]), dtype=np.float64)


class DecayFit(NamedTuple):
    """What the regression tells.

    Its columns are a constant for each chamber of each stretch, a ramp in time for each offset of a sensor,
    the motion, leakage past the piston, and leakage to the outside.
    """

    found: Regression  # the regression
    modulus: float  # the bulk modulus [Pa], as found, or that of the scenario
    seen: bool  # whether a motion tells it
    external: bool  # whether leakage to the outside is among the columns
    offsets: int  # how many offsets of sensors are: 0, or 1 of a hydraulic force, or 2

    @property
    def stretches(self) -> int:
        """How many columns come before those of the offsets."""
        return self.found.values.size - 1 - self.external - self.seen - self.offsets

    @property
    def leaks(self) -> bool:
        """Whether a leakage is told: above 0, by intervals that are narrow enough."""
        return any(
            self.found.half(self.weight(place)) < SURE * self.found.values[place]
            for place in range(-1 - self.external, 0)
        )

    @property
    def drifts(self) -> bool:
        """Whether a ramp is there that only an offset of a sensor makes."""
        first = self.stretches
        places = range(first, first + self.offsets)
        return any(abs(self.found.values[i]) > self.found.half(self.weight(i)) for i in places)

    @property
    def across(self) -> Samples:
        """The weight of what leaks past the piston, times the bulk modulus, among the columns."""
        return self.weight(-1 - self.external)

    def without_negative_leakage(self) -> "DecayFit":
        """The same with no leakage below 0."""
        best = self.found
        for place in range(-1 - self.external, 0):
            if best.values[place] < 0.0:
                best = best.without(place)
        return self._replace(found=best)

    def weight(self, place: int) -> Samples:
        """The weights that take one coefficient alone."""
        found: Samples = np.eye(self.found.values.size)[place]
        return found


def fit_balances(stretches: Sequence[WatchedStretch], piston: Piston) -> DecayFit | None:
    """What the balances tell, the bulk modulus too where a motion shows it; None if columns are too alike."""
    fit = fit_by_motion(stretches, piston) or regress_balances(stretches, piston, False)
    return None if fit is None else with_noise(fit, stretches, piston)


def with_offsets(fit: DecayFit, stretches: Sequence[WatchedStretch], piston: Piston) -> DecayFit:
    """The same with the offsets of sensors among its unknowns, where the decay is long enough to tell them.

    An offset drives a leakage at a constant rate, and a leakage one that falls as the pressures do.
    """
    free = regress_balances(stretches, piston, fit.seen, offsets=2 if piston.has_chambers else 1)
    if free is None:
        return fit
    free = with_noise(free, stretches, piston)
    return free if free.leaks or (free.drifts and not fit.leaks) else fit


def with_noise(fit: DecayFit, stretches: Sequence[WatchedStretch], piston: Piston) -> DecayFit:
    """The same with what the noise of pressures adds to its covariance.

    Noise adds up in integrals, which no covariance of what is left knows of: how far the numbers move when
    as much noise is added once more counts too, one way or to and fro.
    """
    rng = np.random.default_rng(0)
    scale = np.sqrt(np.maximum(np.diag(fit.found.covariance), 1e-300))
    apart = []
    for _ in range(DRAWS):
        again = [with_more_noise(one, rng, piston) for one in stretches]
        design, aim = (
            np.concatenate(rows) for rows in zip(*chamber_columns(again, piston, fit), strict=True)
        )
        apart.append(np.linalg.lstsq(design * scale, aim, rcond=None)[0] * scale - fit.found.values)
    covariance = fit.found.covariance + np.transpose(apart) @ np.array(apart) / DRAWS
    return fit._replace(found=fit.found._replace(covariance=covariance))


def fit_by_motion(stretches: Sequence[WatchedStretch], piston: Piston) -> DecayFit | None:
    """What the balances tell with the bulk modulus among it; None where no motion shows it well enough."""
    if not any(map(piston_moves, stretches)):
        return None
    fit = regress_balances(stretches, piston, True)
    if fit is None or fit.found.half(fit.weight(2 * len(stretches))) >= SURE * fit.modulus:
        return None
    return fit


def piston_moves(one: WatchedStretch) -> bool:
    """Whether the piston moves by more than its sensor's noise."""
    position = one.segment.measured.get("position")
    return position is not None and float(np.ptp(one.rows["x"])) > STEPS * noise_of(position)


def with_more_noise(one: WatchedStretch, rng: np.random.Generator, piston: Piston) -> WatchedStretch:
    """A stretch whose pressures have noise of their own size once more."""
    noisy = {
        chamber: one.rows[chamber] + rng.normal(scale=noise_of(one.rows[chamber]), size=one.time.size)
        for chamber in "ab"
    }
    rows = one.rows | noisy
    return one._replace(rows=rows, balances=chamber_balances(rows, one.period, piston))


def regress_balances(
    stretches: Sequence[WatchedStretch], piston: Piston, seen: bool, offsets: int = 0
) -> DecayFit | None:
    """The regression, with the bulk modulus or with that of the scenario; None if columns are too alike."""
    external = hasattr(piston.plant, "external_leakage")
    blank = Regression(np.zeros(0), np.zeros((0, 0)), 0.0)
    fit = DecayFit(blank, scenario_modulus(piston, stretches), seen, external, offsets)
    found = regression(chamber_columns(stretches, piston, fit))
    if found is None:
        return None
    modulus = float(found.values[2 * len(stretches) + offsets]) if seen else fit.modulus
    return fit._replace(found=found, modulus=modulus)


def chamber_columns(
    stretches: Sequence[WatchedStretch], piston: Piston, fit: DecayFit
) -> list[tuple[Samples, Samples]]:
    """Of each chamber of each stretch the columns, and what they explain."""
    chambers = [one for stretch in stretches for one in stretch.balances]
    known = 0.0 if fit.seen else scenario_modulus(piston, stretches)
    shape = len(chambers), fit.external, fit.seen, fit.offsets
    return [
        (balance_columns(one, i, *shape), one.raised - known * one.swept) for i, one in enumerate(chambers)
    ]


def balance_columns(
    one: Balance, place: int, count: int, external: bool, moved: bool, offsets: int
) -> Samples:
    """What a chamber's balance is owed to: a constant of its own, offsets of sensors, motion, leakages.

    The place is that of its constant, even for chamber A and odd for B. Offsets are 2 of pressures, 1 of a
    hydraulic force, which chamber B has the other way round, or 0.
    """
    own = np.zeros((one.raised.size, count))
    own[:, place] = 1.0
    ramp = np.linspace(0.0, 1.0, one.raised.size) * one.duration
    chamber = place % 2
    ways = (1.0 - chamber, float(chamber)) if offsets == 2 else (1.0 - 2.0 * chamber,)
    ramps = [way * ramp for way in ways[:offsets]]
    outside = one.pressed if offsets else one.outside
    more = [*ramps, *([one.swept] if moved else []), one.across, *([outside] if external else [])]
    return np.column_stack([own, *more])


def scenario_modulus(piston: Piston, stretches: Sequence[WatchedStretch]) -> float:
    """The scenario's bulk modulus at the mean pressure of the logs [Pa]."""
    if not piston.has_chambers:
        return float(piston.plant.bulk_modulus)
    mean = float(np.mean([0.5 * (one.rows["a"].mean() + one.rows["b"].mean()) for one in stretches]))
    return float(piston.plant.oil.bulk_modulus(mean))
