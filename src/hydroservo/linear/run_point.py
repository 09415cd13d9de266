"""Where a loop is at an instant of its run."""

import numpy as np

from hydroservo.block import leaves
from hydroservo.cosimulation import refuse_foreign
from hydroservo.errors import ParameterError
from hydroservo.field import Field
from hydroservo.hooks import smoothed
from hydroservo.linear.operating_point import DigitalState, OperatingPoint
from hydroservo.loop import AUTO, Loop
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import ready, simulate
from hydroservo.states import filled
from hydroservo.validation import number


def run_point(loop: Loop, time: float) -> OperatingPoint:
    """Where a loop is at the last sample up to an instant, before it measures there.

    Args:
        loop: the loop; it runs from its start.
        time: the instant [s], from the third sample on.

    Raises:
        ParameterError: the instant is not in the run, or the run diverged before it.
    """
    refuse_foreign(loop, "linearise it")
    begun = ready(loop)
    h, duration = begun.simulation.period, begun.simulation.duration
    number(time, "time", Field("s", "", at_least=2.0 * h, at_most=duration), float)
    before = h * (round(time / h + 1e-9) - 1)
    short = begun.simulation._replace(duration=before, record_period=before)
    state = begun.init()
    paths = [path for path, _ in leaves(state)]
    data = quietly(simulate)(begun._replace(simulation=short), record=paths, metrics=[])
    if data["diverged"]:
        raise ParameterError("time", time, f"the run diverged at {float(data['diverged_at']):g} s")
    last = filled(state, iter(float(data[path].values[-1]) for path in paths))
    substeps = begun.simulation.substeps
    substeps = int(data.attrs["substeps"]) if substeps == AUTO else substeps
    held = begun.held(last)
    machine = begun.simulation.integrator.advance(begun, before, begun.machine(last), held, h, substeps)
    now = before + h
    return OperatingPoint(
        begun._replace(controller=smoothed(begun.controller), sensors=smoothed(begun.sensors)),
        float(begun.hold.at(held, np.nextafter(now, before))),
        machine,
        DigitalState(last.sensors, last.controller, last.hold),
        begun.reference.at(now),
        begun.load.force(now),
    )
