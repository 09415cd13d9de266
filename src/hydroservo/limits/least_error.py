"""The least error that any command can leave in a loop, with its law or without one."""

import math
import os
from typing import Any, NamedTuple

import numpy as np

from hydroservo.control.loop import AUTO, Loop
from hydroservo.core.assumptions import margin_ratio
from hydroservo.core.block import replace
from hydroservo.core.errors import require
from hydroservo.limits.command import CommandLimits, Playback, command_limits
from hydroservo.limits.finding import limits_finding
from hydroservo.limits.problem import machine_functions
from hydroservo.limits.search import (
    best_commands,
    checked_samples,
    limit_run,
    loop_to_limit,
    rest_beginning,
    run_beginning,
)
from hydroservo.machine.sensors import IdealSensors
from hydroservo.runs.arguments import checked_loop
from hydroservo.runs.cautions import with_warning
from hydroservo.runs.run import RunProgress
from hydroservo.runs.step_sizes import with_substeps
from hydroservo.show import Finding
from hydroservo.show.html import html_of
from hydroservo.work.notebook_bar import shows_progress

LAW = 0.05  # of the work, that is done after its run
WORSE = 1e-3  # by which a limit may lie above what another command leaves


class MachineLimits(NamedTuple):
    """The least rms errors that commands can leave."""

    clairvoyant: float  # of one to which all is known
    causal: float  # of one to which jumps are known once they are there
    converged: bool  # whether both searches ended; where they did not, an error is what a command reached


def without_law(loop: Loop) -> Loop:
    """A loop without what its limits do not depend on: law, sensors and seed; its command is 0."""
    changed: Loop = replace(loop, {"simulation.seed": 0})
    return changed._replace(controller=Playback(np.zeros(1)), sensors=IdealSensors())


def check_limited(loop: Loop) -> None:
    """Refuse what has no limits before anything is computed."""
    require("casadi", "limit", "a limit")
    loop = loop_to_limit(loop)
    checked_samples(loop)
    machine_functions(loop)


def machine_limits(loop: Loop, limits: CommandLimits) -> MachineLimits:
    """The limits of a loop as :func:`~hydroservo.limits.least_error.limit` has them, without a law.

    The search begins with a machine at rest, its errors are measured by that of a command of 0, and all is
    computed on one core: nothing depends on a law.
    """
    require("casadi", "limit", "a limit")
    loop = loop_to_limit(loop)
    still = limit_run(loop._replace(controller=Playback(np.zeros(checked_samples(loop) + 1))))
    loop = with_steps_of(still, loop)
    found = best_commands(loop, limits, rest_beginning(loop, limits, still), lambda _: None, threads=1)
    best, rest = machine_limits_of(*found), float(still["rms_error"])
    stayed = 0.0 < rest <= best.clairvoyant  # as where no small command moves the machine
    return best._replace(converged=best.converged and not stayed)


def machine_limits_of(causal: Any, clairvoyant: Any) -> MachineLimits:
    """The errors of the runs of two best commands."""
    converged = all(bool(run.attrs["converged"]) for run in (causal, clairvoyant))
    return MachineLimits(float(clairvoyant["rms_error"]), float(causal["rms_error"]), converged)


def with_steps_of(run: Any, loop: Loop) -> Loop:
    """The loop with the substeps of a run of it, where it leaves them open."""
    if loop.simulation.substeps != AUTO:
        return loop
    return with_substeps(loop, int(run.attrs["substeps"]))


class Limits(NamedTuple):
    """A law's run and those of the best commands, each a Dataset as ``simulate`` returns it.

    Attributes:
        law: the loop with its own law.
        causal: the best command of a controller to which jumps are known only once they are there.
        clairvoyant: the best command of one to which all is known.
    """

    law: Any  # datasets of xarray, which is heavy to import
    causal: Any
    clairvoyant: Any

    def finding(self) -> Finding:
        """What it says, as commands and notebooks show it."""
        return limits_finding(self)

    def _repr_html_(self) -> str:
        return html_of(self.finding())

    def multiples(self) -> dict[str, float]:
        """How many times the rms error of each limit the law leaves.

        inf over a limit of 0, and nan where the search for one did not end in an optimum.
        """
        law, limits = float(self.law["rms_error"]), {"causal": self.causal, "clairvoyant": self.clairvoyant}
        return {
            name: margin_ratio(law, float(run["rms_error"])) if run.attrs["converged"] else math.nan
            for name, run in limits.items()
        }


@shows_progress
def limit(loop: Loop, *, progress: RunProgress | None = None) -> Limits:
    """The least rms error that any controller could leave, at a loop's sample rate and within its limits.

    The command is found by optimal control of the very machine that is simulated, with the integrator's
    steps, the hold, and the error as its monitor measures it; then it is played back in the loop. So each
    limit is the error of a run that was made. Sensors and laws do not matter: all is known of the machine.

    *Clairvoyant*: demand and load are known for the whole run. No command of any law leaves less, as far as
    the optimum that was found is that of all.

    *Causal*: a jump of the demand, of its rate, or of the load is known from the first sample on at which it
    is there; until then the demand is expected to go on at its rate, and the load to stay. A demand without
    jumps counts as known, and both limits are one. It is no bound for a law that bets on a jump: such a one
    would do worse where none comes.

    Args:
        loop: the loop, with RK4 as its integrator.
        progress: called now and then with the fraction done.

    Returns:
        Three runs, with signal, demand and command recorded at each sample, and the metrics of
        :class:`~hydroservo.control.monitors.TrackingError`. Those of the limits have the attributes
        ``iterations``, of the solver, and ``converged``, whether the conditions of an optimum hold and
        neither the law nor another search leaves less; where not, an attribute ``warning`` says so. The
        clairvoyant one has ``sought_rms_error`` too, what the search says that its command leaves.

    Raises:
        ParameterError: the loop controls nothing or has too many samples, its command has no limit, its
            integrator is another one, or a block of its machine cannot be written with symbols.
        HydroservoError: CasADi is not installed, or the solver was lost.

    Source: optimal control by direct multiple shooting; see ``hydroservo.limits.problem.optimum``.
    Fails to tell a local optimum from the best of all; and at kinks, as of dry friction, where the solver may
    stop short of one.
    """
    report = progress or (lambda _: None)
    require("casadi", "limit", "a limit")
    loop = loop_to_limit(checked_loop(loop))
    limits = command_limits(loop)
    checked_samples(loop)
    own = limit_run(loop)
    report(LAW)
    loop = with_steps_of(own, loop)

    def report_search(done: float) -> None:
        report(LAW + (1.0 - LAW) * done)

    best = best_commands(loop, limits, run_beginning(loop, limits, own), report_search, os.cpu_count() or 1)
    law, causal = float(own["rms_error"]), float(best.causal["rms_error"])
    return Limits(own, unless_worse(best.causal, law), unless_worse(best.clairvoyant, min(law, causal)))


def unless_worse(run: Any, least: float) -> Any:
    """The run of a best command; one that did not converge where another command leaves less."""
    if float(run["rms_error"]) <= least * (1.0 + WORSE):
        return run
    line = "the search ended in a local optimum: another command leaves less"
    return with_warning(run.assign_attrs(converged=False), [line])
