"""How finely the machine is followed between two samples of a log."""

import math
from collections.abc import Mapping

from hydroservo.block import replace
from hydroservo.identification.experiment import Experiment, experiment
from hydroservo.identification.segments import Segment
from hydroservo.loop import AUTO, Loop
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import simulate
from hydroservo.runs.step_sizes import command_parts, with_substeps

TRIED = 1.0  # s of a log, after which the steps that it takes are known
COARSE = 1e-4  # tolerance of a search's steps: a tenth of what its first fit tries to get below


def first_steps(loop: Loop, segment: Segment) -> int:
    """The number of integration steps between two samples of a log, to begin a search with.

    As many in a second as the scenario has, at least; with automatic ones, as many as the log's beginning
    takes with the scenario's own machine, coarsely.

    Args:
        loop: of the scenario.
        segment: that will be played.
    """
    simulation = loop.simulation
    one = experiment(loop, segment, (), AUTO)
    if simulation.substeps == AUTO:
        return automatic_steps(one, {}, COARSE)
    wanted = math.ceil(simulation.substeps * segment.period / simulation.period * (1.0 - 1e-9))
    parts = command_parts(one.loop)
    return -(-wanted // parts) * parts


def automatic_steps(one: Experiment, numbers: Mapping[str, float], tolerance: float) -> int:
    """The number of automatic steps between two samples that a machine takes over a log's beginning.

    Args:
        one: the experiment.
        numbers: of the machine, by path in its loop.
        tolerance: relative error that steps may make; the scenario's own applies where it is larger.
    """
    simulation, segment = one.given.simulation, one.segment
    samples = max(min(segment.samples, round(TRIED / segment.period)), 2)
    brief = simulation._replace(
        duration=segment.period * (samples - 1),
        substeps=AUTO,
        tolerance=max(tolerance, simulation.tolerance),
    )
    loop: Loop = replace(one.given._replace(simulation=brief), numbers)
    return int(quietly(simulate)(loop, record=()).attrs["substeps"])


def with_steps(one: Experiment, substeps: int) -> Experiment:
    """The experiment with so many steps between two samples."""
    return one._replace(given=with_substeps(one.given, substeps), loop=with_substeps(one.loop, substeps))
