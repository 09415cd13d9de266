"""How well each log is met, and whether the model fits it."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import Block, leaves
from hydroservo.core.formatting import plain_quantity
from hydroservo.identification.log import SIGNALS
from hydroservo.identification.problem import Problem, simulate_segments
from hydroservo.identification.result import LogFit, SignalFit
from hydroservo.identification.search import Misfit, Solution, misfit_at, refine
from hydroservo.identification.segments import TO_DEVIATION, UnderstoodLog, resolution_of
from hydroservo.identification.uncertainty import Uncertainty
from hydroservo.runs.trace import signal_attributes

if TYPE_CHECKING:
    import xarray as xr

LAGS = 20
CUT = 3.0  # deviations, to which residuals are cut, for single outliers are no sign of a model
DRAWS = 8  # of noise that is rounded as a signal is
COARSE = 0.5  # deviations of the residuals, from which a signal's resolution colours them

Samples = NDArray[np.float64]
SHARE = 0.2  # of each segment, its end

BEGUN = 0.05  # of each stretch, after which states that were not measured do not matter any more
WHITE = 1e-6  # probability, below which residuals are not white
EXACT = 1e-8  # share of a signal's variance, below which what is left may be of the integration
LITTLE = 0.5  # share of a signal's variance, below which the model is of something else
ABOVE = 1.25  # times the noise that a sensor has, from which more than noise is left


def autocorrelation(parts: Sequence[Samples], lag: int) -> float:
    """The correlation of residuals with themselves so many samples later; 0 for none."""
    mean = float(np.mean(np.concatenate(parts)))
    after = math.fsum(float(((part[lag:] - mean) * (part[:-lag] - mean)).sum()) for part in parts)
    squares = math.fsum(float(((part - mean) ** 2).sum()) for part in parts)
    return after / squares if squares > 0.0 else 0.0


def whiteness(
    parts: Sequence[Samples], first: int = 1, null: Sequence[Sequence[Samples]] | None = None
) -> float:
    """The probability that noise alone would hang together as residuals do, or more: Ljung and Box's test.

    Stretches of 20 samples or fewer are left out. Residuals in ``null``, which noise alone leaves, scale the
    statistic where they are not white.

    Source: Ljung, Box, Biometrika 65, 1978, doi:10.1093/biomet/65.2.297.
    Fails to see what hangs together over more than 20 samples alone.
    """
    from scipy.special import chdtrc

    degrees = LAGS + 1 - first
    usual = max([portmanteau(one, first) for one in null or ()], default=0.0)
    return float(chdtrc(degrees, portmanteau(parts, first) * degrees / max(usual, degrees)))


def portmanteau(parts: Sequence[Samples], first: int) -> float:
    """Ljung and Box's statistic; 0 of too few residuals."""
    cut = [np.clip(part, -CUT, CUT) for part in parts if part.size > LAGS]
    size = sum(part.size for part in cut)
    if not size:
        return 0.0
    total = math.fsum(autocorrelation(cut, lag) ** 2 / (size - lag) for lag in range(first, LAGS + 1))
    return size * (size + 2.0) * total


def rounded_noise(
    residuals: Sequence[Samples], measured: Sequence[Samples], step: float
) -> list[list[Samples]] | None:
    """Residuals that a right model leaves in a quantised signal; None where they are as good as white.

    What the model shows is taken for true, and noise is added to it of which, with the rounding, as much is
    left as of the residuals.
    """
    if step <= COARSE:
        return None
    size = float(np.sqrt(np.mean(np.clip(np.concatenate(residuals), -CUT, CUT) ** 2)))
    noise = math.sqrt(max(size**2 - step**2 / 12.0, 0.0))
    rng = np.random.default_rng(0)
    draws = []
    for _ in range(DRAWS):
        shown = [values - left for values, left in zip(measured, residuals, strict=True)]
        noisy = [one + noise * rng.normal(size=one.size) for one in shown]
        draws.append([step * np.round(one / step) - own for one, own in zip(noisy, shown, strict=True)])
    return draws


class HeldOutErrors(NamedTuple):
    """Root mean squares of weighted residuals."""

    inside: float  # over what was fitted
    outside: float  # over what was held out


def held_out_errors(problem: Problem, best: Solution) -> dict[tuple[int, str], HeldOutErrors]:
    """Fit the first four fifths of each segment, and simulate the last: the residuals of both.

    They are by log and signal, in the signal's unit.
    """
    counted = {}
    for i, one in enumerate(problem.experiments):
        samples = one.segment.samples
        counted[i] = np.arange(samples) < (1.0 - SHARE) * samples
    part = refine(problem, best.x, best.weights, counted=counted)
    shown = misfit_at(problem, part.x, best.weights, slopes=False)
    rows: dict[tuple[int, str], list[list[np.ndarray]]] = {}
    for (i, name), place in shown.rows.items():
        key = problem.experiments[i].segment.log, name
        for inside, of in ((True, 0), (False, 1)):
            own = shown.there[place] & (counted[i] == inside)
            rows.setdefault(key, [[], []])[of].append(shown.residuals[place][own] / best.weights[key])
    return {key: HeldOutErrors(*(rms(np.concatenate(parts)) for parts in both)) for key, both in rows.items()}


def rms(values: np.ndarray) -> float:
    """Root of the mean square; nan of nothing."""
    return float(np.sqrt(np.mean(values**2))) if values.size else float("nan")


class Residuals(NamedTuple):
    """What is left of a signal of a log, weighted, a row for each segment."""

    left: list[Samples]  # measured less simulated
    measured: list[Samples]  # the signal
    interpolated: bool  # whether samples were moved onto a grid


def log_fits(
    problem: Problem,
    best: Solution,
    sure: Uncertainty,
    taken: Sequence[UnderstoodLog],
    apart: Mapping[tuple[int, str], HeldOutErrors],
    sensors: Block,
) -> list[LogFit]:
    """Each log as it was met by the model."""
    shown = misfit_at(problem, best.x, best.weights, slopes=False)
    predicted = any(one.observer is not None for one in problem.experiments)
    fits = []
    for log, one in enumerate(taken):
        signals = {}
        for name in dict.fromkeys(name for number, name in best.weights if number == log):
            fit = signal_fit(problem, best, sure, (log, name), residuals_of(problem, shown, log, name), apart)
            noise = noise_in(sensors, name)
            signals[name] = fit if predicted else fit._replace(problem=unfit_reason(fit, noise))
        delay = log_unknown(problem, best, sure, log, "delay")
        fits.append(LogFit(one, delay, signals, fit_data(problem, best, log)))
    return fits


def residuals_of(problem: Problem, shown: Misfit, log: int, name: str) -> Residuals:
    """What is left of a signal, where it was measured."""
    left, measured, interpolated = [], [], False
    for (i, signal), place in shown.rows.items():
        segment = problem.experiments[i].segment
        if (segment.log, signal) == (log, name):
            there = shown.there[place]
            left.append(shown.residuals[place][there])
            measured.append(segment.measured[name][there])
            interpolated |= segment.interpolated
    return Residuals(left, measured, interpolated)


def signal_fit(
    problem: Problem,
    best: Solution,
    sure: Uncertainty,
    key: tuple[int, str],
    rows: Residuals,
    apart: Mapping[tuple[int, str], HeldOutErrors],
) -> SignalFit:
    """How well a signal is met; whether the model fits it is left open."""
    log, name = key
    weight = best.weights[key]
    values = np.concatenate(rows.left) / weight
    step = weight * resolution_of(np.concatenate(rows.measured))
    later = [one[int(BEGUN * one.size) :] for one in rows.left]
    levels = [weight * one[int(BEGUN * one.size) :] for one in rows.measured]
    return SignalFit(
        rms=rms(values),
        noise=TO_DEVIATION * float(np.median(np.abs(values))),
        explained=1.0 - float(np.var(values)) / problem.spread[key] ** 2,
        whiteness=whiteness(later, 2 if rows.interpolated else 1, rounded_noise(later, levels, step)),
        correlation=autocorrelation(later, 1),
        held_out=apart[key].outside,
        held_in=apart[key].inside,
        offset=log_unknown(problem, best, sure, log, "offset", name),
        problem="",
        unit=SIGNALS[name].unit,
    )


def unfit_reason(fit: SignalFit, noise: float) -> str:
    """Why the model does not fit a signal; empty where it does."""
    if 1.0 - fit.explained < EXACT:
        return ""
    if fit.whiteness < WHITE and fit.explained < LITTLE:
        share = f"{100.0 * fit.explained:.0f} %" if fit.explained > 0.0 else "none"
        return f"the model explains {share} of its variance; check its unit, its sign and its column"
    if fit.whiteness < WHITE:
        return f"what is left is not white noise (correlation {fit.correlation:.2f} of neighbouring samples)"
    if noise and fit.noise > ABOVE * noise:
        left, usual = (plain_quantity(one, fit.unit) for one in (fit.noise, noise))
        return f"{left} rms is left, and its sensor has a noise of {usual}"
    return ""


def noise_in(sensors: Block, signal: str) -> float:
    """The rms of the noise that a scenario's sensor has [the signal's unit]; 0 where it has none."""
    known = {path: value for path, value in leaves(sensors) if isinstance(value, float)}
    share = known.get(f"{signal}.noise", 0.0)
    span = known.get(f"{signal}.range_high", 1.0) - known.get(f"{signal}.range_low", 0.0)
    return float(known.get(f"{signal}_noise", share * span))


def log_unknown(
    problem: Problem, best: Solution, sure: Uncertainty, log: int, kind: str, key: str = ""
) -> tuple[float, float]:
    """An unknown of a log and its standard deviation, in SI units; 0 if there is none."""
    for i, one in enumerate(problem.unknowns):
        if one.kind == kind and one.where == log and key in ("", one.key):
            return float(best.x[i] * one.scale), float(sure.deviations[i] * one.scale)
    return 0.0, 0.0


def fit_data(problem: Problem, best: Solution, log: int) -> "xr.Dataset":
    """Measured and simulated signals of a log over its time."""
    import xarray as xr

    shown = simulate_segments(problem, best.x, slopes=False)
    parts = []
    for one, values in zip(problem.experiments, shown, strict=True):
        if one.segment.log != log:
            continue
        rows = {**one.segment.inputs, **one.segment.measured}
        simulated = {f"{name}_simulated": name for name in values.values}
        rows |= {shown: values.values[name] for shown, name in simulated.items()}
        signals = {name: SIGNALS[simulated.get(name, name)] for name in rows}
        own = {name: ("time", row, signal_attributes(signals[name])) for name, row in rows.items()}
        time = ("time", one.segment.time, {"units": "s", "long_name": "time"})
        parts.append(xr.Dataset(own, coords={"time": time}))
    return xr.concat(parts, "time") if len(parts) > 1 else parts[0]
