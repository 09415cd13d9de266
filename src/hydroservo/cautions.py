"""What the user of a result should know of it, in lines of its attribute ``warning``."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from hydroservo.constants import ATMOSPHERE

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["pressure_caution", "warnings_of", "with_warning"]


def with_warning(data: "xr.Dataset", lines: Iterable[str]) -> "xr.Dataset":
    """A result with these lines as its ``warning``, each once, empty ones left out; none without any."""
    text = "\n".join(dict.fromkeys(line for text in lines for line in text.splitlines()))
    others = {name: value for name, value in data.attrs.items() if name != "warning"}
    found = data.copy()
    found.attrs = others | ({"warning": text} if text else {})
    return found


def warnings_of(data: "xr.Dataset") -> list[str]:
    """The lines of a result's ``warning``."""
    return str(data.attrs.get("warning", "")).splitlines()


def pressure_caution(data: "xr.Dataset") -> str:
    """That a chamber's pressure fell below absolute zero, in a run or in some of many; else empty."""
    lost = np.isfinite(data["diverged_at"].values)  # what overflows passes every pressure
    lowest = np.where(lost, np.nan, data["pressure_min"].values)
    below = np.atleast_1d(lowest < -ATMOSPHERE)
    if not below.any():
        return ""
    where = "" if lowest.ndim == 0 else f" in {below.sum():,} of {below.size:,} runs"
    return (
        f"the pressure in a chamber fell to {1e-5 * np.nanmin(lowest):.3g} bar{where}, below absolute "
        f"zero ({-1e-5 * ATMOSPHERE:.3g} bar gauge): real oil cavitates before that, as an AeratedOil does"
    )
