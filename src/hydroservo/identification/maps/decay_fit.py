"""What the oil's balances in blocked ports tell, by least squares."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.identification.maps.balances import Balance, Watched, balances
from hydroservo.identification.maps.piston import Piston
from hydroservo.identification.regression import Regression, regression
from hydroservo.identification.spikes import noise_of

__all__ = ["DecayFit", "columns", "fitted_to"]

SURE = 0.5  # half of an interval over its number, up to which a bulk modulus is told by a motion
DRAWS = 40  # of noise, that say how much of it integrals gather
STEPS = 5.0  # deviations of the position's noise, that a motion goes

Samples = NDArray[np.float64]


class DecayFit(NamedTuple):
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


def fitted_to(stretches: Sequence[Watched], piston: Piston) -> DecayFit | None:
    """What the balances tell, with the bulk modulus where a motion shows it; None if columns are too alike.

    Noise of a pressure adds up in its integral, which no covariance of what is left knows of: how far the
    numbers move when as much noise is added once more counts too, one way or to and fro.
    """
    fit = by_motion(stretches, piston) or regressed(stretches, piston, False)
    if fit is None:
        return None
    rng = np.random.default_rng(0)
    again = [
        regressed([noisier(one, rng, piston) for one in stretches], piston, fit.seen) for _ in range(DRAWS)
    ]
    apart = np.array([one.found.values - fit.found.values for one in again if one is not None])
    covariance = fit.found.covariance + apart.T @ apart / len(apart)
    return fit._replace(found=fit.found._replace(covariance=covariance))


def by_motion(stretches: Sequence[Watched], piston: Piston) -> DecayFit | None:
    """What the balances tell with the bulk modulus among it; None where no motion shows it well enough."""
    if not any(map(moves, stretches)):
        return None
    fit = regressed(stretches, piston, True)
    if fit is None or fit.found.half(fit.weight(2 * len(stretches))) >= SURE * fit.modulus:
        return None
    return fit


def moves(one: Watched) -> bool:
    """Whether the piston moves by more than its sensor's noise."""
    position = one.segment.measured.get("position")
    return position is not None and float(np.ptp(one.rows["x"])) > STEPS * noise_of(position)


def noisier(one: Watched, rng: np.random.Generator, piston: Piston) -> Watched:
    """A stretch whose pressures have noise of their own size once more."""
    noisy = {
        chamber: one.rows[chamber] + rng.normal(scale=noise_of(one.rows[chamber]), size=one.time.size)
        for chamber in "ab"
    }
    rows = one.rows | noisy
    return one._replace(rows=rows, balances=balances(rows, one.period, piston))


def regressed(stretches: Sequence[Watched], piston: Piston, seen: bool) -> DecayFit | None:
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
    return DecayFit(found, float(found.values[place]) if seen else known, seen, external)


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
