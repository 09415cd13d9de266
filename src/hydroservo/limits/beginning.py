"""Where a search for the best commands begins: with the run of a law, or with a machine at rest."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.block import leaves, values
from hydroservo.limits.command import CommandLimits
from hydroservo.limits.interval import Scales
from hydroservo.limits.problem import Course
from hydroservo.runs.steady import sized

if TYPE_CHECKING:
    import xarray as xr

COMMAND = "controller.u"
DEMAND = "reference.value"

Vector = NDArray[np.float64]


class Beginning(NamedTuple):
    """The course with which a search begins, and what its numbers are measured by."""

    course: Course
    scales: Scales


def remembers(loop: Loop, limits: CommandLimits) -> bool:
    """Whether the command of the sample before is part of a state: it still acts, or limits the next one."""
    return limits.rated or hasattr(loop.hold, "delay")


def of_run(loop: Loop, limits: CommandLimits, run: "xr.Dataset") -> Beginning:
    """A run of the loop; where it diverged, rest.

    Args:
        loop: the loop, ready to run.
        limits: of the command.
        run: has all states of the machine, and the command.
    """
    if run["diverged"]:
        return at_rest(loop, limits, run)
    states = np.array([run[path].values for path, _ in leaves(loop.machine(loop.init()))])
    commands = run[COMMAND].values[:-1]
    scales = Scales(np.array([largest(row) for row in states]), largest(commands), error_of(run))
    return measured(loop, limits, states, commands, scales)


def at_rest(loop: Loop, limits: CommandLimits, run: "xr.Dataset") -> Beginning:
    """A machine that stays as it is, with no command.

    Args:
        loop: the loop, ready to run.
        limits: of the command.
        run: one of the loop, by whose error errors are measured; where it diverged, by the largest demand.
    """
    like = loop.machine(loop.init())
    samples = run[COMMAND].size - 1
    states = np.repeat(np.array(values(like))[:, np.newaxis], samples + 1, axis=1)
    error = largest(run[DEMAND].values) if run["diverged"] else error_of(run)
    scales = Scales(np.array([one for _, one in sized(like)]), limits.limit, error)
    return measured(loop, limits, states, np.zeros(samples), scales)


def measured(
    loop: Loop, limits: CommandLimits, states: NDArray[np.float64], commands: Vector, scales: Scales
) -> Beginning:
    """A course of states and commands in SI units."""
    course, commands = states / scales.machine[:, np.newaxis], commands / scales.command
    if remembers(loop, limits):
        first = float(loop.init().controller.u) / scales.command
        course = np.vstack([course, np.append(first, commands)])
    return Beginning(Course(course, commands), scales)


def error_of(run: "xr.Dataset") -> float:
    """The rms error of a run, and 1 where it is 0."""
    return float(run["rms_error"]) or 1.0


def largest(values: Vector) -> float:
    """The largest size of some numbers, and 1 where all are 0 or none is there."""
    return float(np.nanmax(np.abs(values), initial=0.0)) or 1.0
