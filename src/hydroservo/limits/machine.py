"""The least errors that are possible in a loop, whatever its law."""

from typing import NamedTuple

import numpy as np

from hydroservo.control.loop import Loop
from hydroservo.core.block import replace
from hydroservo.core.errors import require
from hydroservo.limits.beginning import at_rest
from hydroservo.limits.command import CommandLimits, Playback
from hydroservo.limits.interval import machine_functions
from hydroservo.limits.search import (
    best_commands,
    checked_samples,
    prepared,
    run_of,
)
from hydroservo.machine.sensors import IdealSensors


class MachineLimits(NamedTuple):
    """The least rms errors that commands can leave.

    Attributes:
        clairvoyant: of one to which all is known.
        causal: of one to which jumps are known once they are there.
        converged: whether both searches ended; where they did not, an error is what a command reached.
    """

    clairvoyant: float
    causal: float
    converged: bool


def lawless(loop: Loop) -> Loop:
    """A loop without what its limits do not depend on: law, sensors and seed; its command is 0."""
    changed: Loop = replace(loop, {"simulation.seed": 0})
    return changed._replace(controller=Playback(np.zeros(1)), sensors=IdealSensors())


def check_limited(loop: Loop) -> None:
    """Refuse what has no limits before anything is computed."""
    require("casadi", "limit", "a limit")
    loop = prepared(loop)
    checked_samples(loop)
    machine_functions(loop)


def machine_limits(loop: Loop, limits: CommandLimits) -> MachineLimits:
    """The limits of a loop as :func:`~hydroservo.limits.least_error.limit` has them, without a law.

    The search begins with a machine at rest, its errors are measured by that of a command of 0, and all is
    computed on one core: nothing depends on a law.

    Args:
        loop: without a law, its substeps a number.
        limits: of its command.
    """
    require("casadi", "limit", "a limit")
    loop = prepared(loop)
    still = run_of(loop._replace(controller=Playback(np.zeros(checked_samples(loop) + 1))))
    found = best_commands(loop, limits, at_rest(loop, limits, still), lambda _: None, threads=1)
    clairvoyant, causal = (float(run["rms_error"]) for run in (found.clairvoyant, found.causal))
    return MachineLimits(clairvoyant, causal, all(bool(run.attrs["converged"]) for run in found))
