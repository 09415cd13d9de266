"""A command for the next log, that tells what the logs so far do not."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.command_scale import in_command_unit
from hydroservo.core.errors import HydroservoError
from hydroservo.identification.log import OUTPUTS
from hydroservo.identification.regression import NORMAL
from hydroservo.identification.result import Identified
from hydroservo.identification.search import Report
from hydroservo.identification.trial import (
    SignalBounds,
    Trial,
    bounds_of,
    candidates,
    draw_machines,
    openness,
    steady_command,
    trial_of,
)

NEWS = 0.5  # by which logarithms of variances fall, of which less is none
LONGEST = 10.0  # s

Matrix = NDArray[np.float64]


class Promise(NamedTuple):
    """What a log of a proposed command would make of one interval.

    Attributes:
        low: lower end of the 95 % interval about the value found so far.
        high: the upper end.
        times: how many times as narrow it would be.
        unit: SI.
    """

    low: float
    high: float
    times: float
    unit: str


class Proposal(NamedTuple):
    """A command for the next log.

    Attributes:
        name: what it is, for people.
        time: instants of its samples [s].
        command: at each [V].
        promises: what would become of each parameter's interval, by path.
        asked: the parameters for which it was chosen.
        reached: the least and the most of each signal of the machine found under it, by name.
        bounds: between what the signals were to stay.
    """

    name: str
    time: Matrix
    command: Matrix
    promises: Mapping[str, Promise]
    asked: Sequence[str]
    reached: Mapping[str, tuple[float, float]]
    bounds: SignalBounds

    def csv(self) -> str:
        """A table of time and command, as a rig plays it and a ``Recorded`` demand takes it."""
        unit, factor = in_command_unit("V")
        rows = zip(self.time.tolist(), (factor * self.command).tolist(), strict=True)
        return f"time [s],command [{unit}]\n" + "".join(f"{t:.9g},{u:.6g}\n" for t, u in rows)


def propose(
    found: Identified, *, limits: SignalBounds | None = None, seed: int = 0, progress: Report | None = None
) -> Proposal:
    """The command that would narrow the intervals of what the logs do not tell most::

        least of sum over s of ln cov_ss(u),   cov(u)^-1 = cov_0^-1 + J(u)' J(u)

    over multisines, chirps and steps at random u, each as large as the limits allow, with the covariance
    cov_0 that the logs so far leave, the slopes J of weighted signals by the parameters once the new log's
    own delay, start and offsets are sought too, and s the parameters that the logs do not tell; all of them
    if they tell all, or no command tells more of those. It is as long as the longest stretch of the logs,
    10 s at most, and starts where the scenario does. Limits are kept with the machine found and with up to 24
    others that the logs allow.

    Args:
        found: by :func:`~hydroservo.identify`.
        limits: between what the command and what is measured must stay, by name, in SI units. Else the
            command has its own limits, a position the stroke less 2 % at both ends, and a chamber's pressure
            0 and one and a half times the supply's.
        seed: of the candidates.
        progress: called now and then with the fraction done.

    Raises:
        ParameterError: a limit is none, or nothing limits the command.
        HydroservoError: no candidate keeps the limits.

    Source: Goodwin, Payne, Dynamic System Identification, 1977, ch. 6 (inputs from information).
    Fails where the machine is far from the one found: slopes are taken there; and to tell what no command
    tells, as two factors of one product.
    """
    report = progress or (lambda _: None)
    fit = found.fitted
    bounds = bounds_of(fit.assembly.loop, limits or {})
    longest = max((one.segment for one in fit.problem.experiments), key=lambda one: one.samples)
    samples = min(longest.samples, round(LONGEST / longest.period) + 1)
    tried = candidates(samples, longest.period, seed)
    machines = draw_machines(fit, seed)
    held = steady_command(fit, samples, longest.period, bounds, machines)
    trials = []
    for number, one in enumerate(tried):
        trials.append(trial_of(found, one, longest, bounds, machines, held))
        report((number + 1) / len(tried))
    kept_ones = [one for one in trials if one is not None]
    if not kept_ones:
        ends = ", ".join(f"{name} in {low:g}..{high:g}" for name, (low, high) in bounds.items())
        raise HydroservoError(f"no command tried stays within the limits: {ends}")
    asked = parameters_asked(found, kept_ones)
    best = min(kept_ones, key=lambda one: openness(one.covariance, asked))
    names = list(found.parameters)
    return proposal_of(found, best, longest.period, [names[i] for i in asked], bounds)


def parameters_asked(found: Identified, trials: Sequence[Trial]) -> list[int]:
    """The parameters that the logs do not tell; all where they tell all, or no trial tells more of these."""
    count = len(found.parameters)
    untold = [i for i, one in enumerate(found.parameters.values()) if not one.identifiable]
    now = found.fitted.sure.covariance[:count, :count]
    best = min((openness(one.covariance, untold) for one in trials), default=0.0)
    return untold if untold and openness(now, untold) - best > NEWS else list(range(count))


def proposal_of(
    found: Identified, trial: Trial, period: float, asked: Sequence[str], bounds: SignalBounds
) -> Proposal:
    space = found.fitted.problem.space
    count = len(space.ranges)
    own = found.fitted.best.x[:count]
    after: Matrix = np.sqrt(np.diag(trial.covariance))
    low, high = (space.values((own + sign * NORMAL * after)[np.newaxis]) for sign in (-1.0, 1.0))
    before = found.fitted.sure.deviations[:count]
    promises = {
        path: Promise(float(low[path][0]), float(high[path][0]), float(before[i] / after[i]), one.unit)
        for i, (path, one) in enumerate(found.parameters.items())
    }
    reached = {
        name: (float(row.min()), float(row.max())) for name, row in zip(OUTPUTS, trial.shown.T, strict=True)
    }
    time: Matrix = period * np.arange(trial.command.size, dtype=np.float64)
    return Proposal(trial.name, time, trial.command, promises, asked, reached, bounds)
