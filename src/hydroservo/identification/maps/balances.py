"""The balance of the oil in both chambers of a cylinder, over a stretch of a log."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.identification.maps.reading import Piston, bridged
from hydroservo.identification.segments import Segment
from hydroservo.identification.spikes import noise_of
from hydroservo.identification.thinning import thinned

SIGMAS = 5.0  # of its noise: a pressure further below 0 is truly negative, and drives no oil out

Samples = NDArray[np.float64]


class Balance(NamedTuple):
    """One chamber's oil over a stretch: what rises in its pressure, and what that is owed to.

    Attributes:
        raised: the integral of V dp [m^3 Pa].
        swept: what the piston leaves to the chamber [m^3].
        across: the integral of the pressure that drives oil in past the piston [Pa s].
        outside: the integral of that which drives it in from outside, none where it is below 0 [Pa s].
        pressed: the same of any sign, as that of a sensor with an offset may have [Pa s].
        duration: of the stretch [s].
    """

    raised: Samples
    swept: Samples
    across: Samples
    outside: Samples
    pressed: Samples
    duration: float


class Watched(NamedTuple):
    """A stretch with the balances of both its chambers.

    Attributes:
        segment: the stretch.
        period: between its samples here [s].
        rows: pressures ``a`` and ``b`` [Pa] and position ``x`` [m], shape (n,).
        balances: of chamber A and of chamber B.
    """

    segment: Segment
    period: float
    rows: dict[str, Samples]
    balances: Sequence[Balance]

    @property
    def time(self) -> Samples:
        """Instants on the log's clock [s]."""
        offset = 0.5 * (self.period - self.segment.period)
        places = np.arange(self.rows["a"].size, dtype=np.float64)
        return self.segment.start + offset + self.period * places


def watched(one: Segment, piston: Piston) -> Watched:
    """What a stretch shows of both chambers.

    Args:
        one: with both pressures, or the load force of a plant that is described by it.
        piston: of the plant.
    """
    measured = one.measured
    if {"pressure_a", "pressure_b"} <= set(measured):
        rows = {"a": measured["pressure_a"], "b": measured["pressure_b"]}
    else:
        half = 0.5 * measured["load_force"] / piston.area_a
        rows = {"a": half, "b": -half}
    rows["x"] = measured.get("position", np.full(one.samples, piston.plant.start_position))
    period, few = thinned(one.period, rows)
    whole = {name: bridged(values, one.log) for name, values in few.items()}
    return Watched(one, period, whole, balances(whole, period, piston))


def shifted_by(offset: float, one: Watched, piston: Piston) -> Watched:
    """A stretch whose sensor of pressure A shows so much more [Pa]."""
    rows = one.rows | {"a": one.rows["a"] + offset}
    return one._replace(rows=rows, balances=balances(rows, one.period, piston))


def exchanged(one: Watched, piston: Piston) -> Watched:
    """A stretch with the pressures of both chambers exchanged."""
    rows = one.rows | {"a": one.rows["b"], "b": one.rows["a"]}
    return one._replace(rows=rows, balances=balances(rows, one.period, piston))


def balances(rows: Mapping[str, Samples], period: float, piston: Piston) -> list[Balance]:
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
