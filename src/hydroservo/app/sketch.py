"""A run while a slider moves: its steps are not judged, and it cautions of nothing."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from hydroservo.control.loop import AUTO, Loop
from hydroservo.control.metrics import monitors_of, values_of
from hydroservo.runs.fitting import compilation, first_state
from hydroservo.runs.run import Mode, complete, lost, paths_of, plan_of, ready, run
from hydroservo.runs.step_sizes import with_substeps
from hydroservo.runs.trace import Trace, dataset

if TYPE_CHECKING:
    import xarray as xr


def sketched_run(loop: Loop, substeps: int, progress: Callable[[float], None]) -> "xr.Dataset":
    """What :func:`~hydroservo.simulate` returns, but for what it says of its steps.

    Args:
        loop: the loop.
        substeps: those of the last whole run, for a loop whose substeps are automatic.
        progress: called with the fraction done.
    """
    automatic = loop.simulation.substeps == AUTO
    asked = complete(loop)
    loop = ready(with_substeps(asked, substeps) if automatic else asked)
    state, watching = first_state(loop), monitors_of(loop)
    wanted = paths_of(loop, state)
    plan = plan_of(loop, state, wanted)
    out = np.full((plan.rows, len(plan.paths)), np.nan)
    with compilation(loop):
        states, loss = run(loop, state, plan, out, Mode(compiled=True, strict=False), progress)
    values = values_of(watching, states, lost(loss))
    return dataset(Trace(asked, loop, plan, wanted, out, values, {"diverged_by": loss.path}))
