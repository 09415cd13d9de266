"""A run while a slider moves: its steps are not judged, and it cautions of nothing."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from hydroservo.control.loop import AUTO, Loop
from hydroservo.runs.run import Mode, PreparedRun
from hydroservo.runs.step_sizes import with_substeps
from hydroservo.runs.trace import dataset

if TYPE_CHECKING:
    import xarray as xr


def sketch_run(loop: Loop, substeps: int, progress: Callable[[float], None]) -> "xr.Dataset":
    """What :func:`~hydroservo.simulate` returns, but for what it says of its steps.

    Args:
        loop: the loop.
        substeps: those of the last whole run, for a loop whose substeps are automatic.
        progress: called with the fraction done.
    """
    run = PreparedRun.of(loop, None, Mode(compiled=True, strict=False))
    if loop.simulation.substeps == AUTO:
        run = run._replace(loop=with_substeps(run.loop, substeps))
    return dataset(run.trace(progress))
