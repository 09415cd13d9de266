"""Whether a log can be of the scenario's machine."""

import math
from collections.abc import Iterable

import numpy as np

from hydroservo.block import Block
from hydroservo.errors import ScenarioError
from hydroservo.formatting import MINUS, quantity
from hydroservo.identification.segments import Understood

BEYOND = 0.1  # of the stroke, by which a sensor's zero may lie beside the machine's


def stroke_of(plant: Block) -> float:
    """The stroke of a plant [m]; inf without one."""
    return float(getattr(plant, "stroke", math.inf))


def check_positions(logs: Iterable[Understood], stroke: float) -> None:
    """Refuse positions far outside of the stroke, as of a wrong unit or a zero at mid-stroke.

    With them the piston would begin behind the ends of its cylinder.

    Args:
        logs: as they are understood.
        stroke: the longest that the machine may have [m].
    """
    if not math.isfinite(stroke):
        return
    for one in logs:
        rows = [part.measured["position"] for part in one.segments if "position" in part.measured]
        if not rows:
            continue
        every = np.concatenate(rows)
        low, high = float(np.nanmin(every)), float(np.nanmax(every))
        if low < -BEYOND * stroke or high > (1.0 + BEYOND) * stroke:
            first, last, whole = (quantity(at, "m").replace(MINUS, "-") for at in (low, high, stroke))
            problem = (
                f"lies between {first} and {last}, and the scenario's piston between 0 and {whole}: are its "
                "unit and its zero those of the machine?"
            )
            raise ScenarioError(one.log.name, "position", problem)
