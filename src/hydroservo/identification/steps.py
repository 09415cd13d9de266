"""How finely the machine is followed between two samples of a log."""

import math

from hydroservo.identification.experiment import experiment
from hydroservo.identification.segments import Segment
from hydroservo.loop import AUTO, Loop
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import simulate
from hydroservo.runs.step_sizes import command_parts

__all__ = ["substeps_for"]

TRIED = 1.0  # s of a log, after which the steps that it takes are known


def substeps_for(loop: Loop, segment: Segment) -> int:
    """The number of integration steps between two samples of a log.

    As many in a second as the scenario has, at least; with automatic ones, as many as the log's beginning
    takes.

    Args:
        loop: of the scenario.
        segment: that will be played.
    """
    simulation = loop.simulation
    if simulation.substeps != AUTO:
        wanted = math.ceil(simulation.substeps * segment.period / simulation.period * (1.0 - 1e-9))
        one = experiment(loop, segment, (), AUTO).loop
        parts = command_parts(one)
        return -(-wanted // parts) * parts
    samples = max(min(segment.samples, round(TRIED / segment.period)), 2)
    short = segment._replace(
        inputs={name: values[:samples] for name, values in segment.inputs.items()},
        measured={name: values[:samples] for name, values in segment.measured.items()},
    )
    one = experiment(loop, short, (), AUTO).given
    return int(quietly(simulate)(one, record=()).attrs["substeps"])
