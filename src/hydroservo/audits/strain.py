"""What a run asks of the oil, the cylinder and the command's limit."""

import math
from typing import Annotated, Any, NamedTuple

import numpy as np

from hydroservo.audits.describing import limit_of
from hydroservo.block import Block
from hydroservo.drives.load_sensing import LoadSensing
from hydroservo.field import Field
from hydroservo.hooks import drives_in, has_chambers, is_valveless
from hydroservo.loop import Loop
from hydroservo.monitors import ChamberPressures, SupplyLine

ABOVE = 1.01  # times the supply's pressure, from which a chamber is above it
AT_LIMIT = 0.99  # of the limit, for a converter has one step less above zero


class Strain(NamedTuple):
    """Extremes of a run; nan where the machine has none."""

    pressure_min: Annotated[float, Field("Pa", "lowest gauge pressure in a chamber")]
    low_pressure_time: Annotated[float, Field("s", "time with a chamber below the atmosphere's pressure")]
    pressure_max: Annotated[float, Field("Pa", "highest gauge pressure in a chamber")]
    supply_pressure: Annotated[float, Field("Pa", "highest gauge pressure of the supply")]
    limited: Annotated[float, Field("", "share of the time with the command at its limit")]

    @property
    def above_supply(self) -> bool:
        return self.pressure_max > ABOVE * self.supply_pressure


def strain_monitors(loop: Loop) -> list[Block]:
    """What a run needs to be asked."""
    return [ChamberPressures(), SupplyLine()] if has_chambers(loop.plant) else []


def strain(loop: Loop, run: Any) -> Strain | None:
    """The extremes of a run; None where it diverged.

    Args:
        loop: the loop.
        run: of it, with the command recorded and the metrics of :func:`strain_monitors`.

    Fails to see the supply of a drive that has a pump for itself: what it has then is nan.
    """
    if bool(run["diverged"]):
        return None
    low, below, high, supply = (
        float(run[name]) if name in run else math.nan
        for name in ("pressure_min", "low_pressure_time", "pressure_max", "supply_pressure_max")
    )
    own_pump = is_valveless(loop.drive) or any(isinstance(one, LoadSensing) for one in drives_in(loop.drive))
    limited = np.abs(run["controller.u"].to_numpy()) >= AT_LIMIT * limit_of(loop.controller)
    return Strain(low, below, high, math.nan if own_pump else supply, float(np.mean(limited)))
