"""Whether a chamber's pressure fell below absolute zero."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from hydroservo.core.constants import ATMOSPHERE


def pressure_caution(data: Mapping[Any, Any]) -> str:
    """That a chamber's pressure fell below absolute zero, in a run or in some of many; else empty."""
    if "pressure_min" not in data:
        return ""
    lost = np.isfinite(data["diverged_at"])  # what overflows passes every pressure
    lowest = np.where(lost, np.nan, data["pressure_min"])
    below = np.atleast_1d(lowest < -ATMOSPHERE)
    if not below.any():
        return ""
    where = "" if lowest.ndim == 0 else f" in {below.sum():,} of {below.size:,} runs"
    return (
        f"the pressure in a chamber fell to {1e-5 * np.nanmin(lowest):.3g} bar{where}, below absolute "
        f"zero ({-1e-5 * ATMOSPHERE:.3g} bar gauge): real oil cavitates before that, as an AeratedOil does"
    )
