"""What a proposed command must keep to."""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import ParameterError
from hydroservo.hooks import line_pressures
from hydroservo.identification.signals import COMMAND, OUTPUTS
from hydroservo.limits.command import command_limits
from hydroservo.loop import Loop

MARGIN = 0.02  # of a stroke, at both its ends
ABOVE = 1.5  # times the supply's pressure, that a chamber's may be

Bounds = Mapping[str, tuple[float, float]]  # by signal, in SI units
PLACES = {name: i for i, name in enumerate(OUTPUTS)}


def bounds_of(loop: Loop, given: Bounds) -> dict[str, tuple[float, float]]:
    """Between what each signal must stay: what is given, and else what the machine allows.

    A command has the limits of its converter, its law or its valve; a position the stroke less 2 % at both
    ends; a chamber's pressure 0 (gauge) and one and a half times the supply's.

    Args:
        loop: of the machine.
        given: by signal, in SI units.
    """
    allowed = (COMMAND, *OUTPUTS)
    for name, (low, high) in given.items():
        if name not in allowed:
            raise ParameterError("limits", name, f"is not a signal; they are {', '.join(allowed)}")
        if not low < high:
            raise ParameterError("limits", f"{name}: {low:g}..{high:g}", "must have its lower end first")
    own: dict[str, tuple[float, float]] = {}
    if COMMAND not in given:
        most = command_limits(loop).limit
        own[COMMAND] = -most, most
    stroke = getattr(loop.plant, "stroke", math.inf)
    if math.isfinite(stroke):
        own["position"] = MARGIN * stroke, (1.0 - MARGIN) * stroke
    supply = line_pressures(loop).supply
    own["pressure_a"] = own["pressure_b"] = 0.0, ABOVE * supply
    return {**own, **given}


def room(shown: NDArray[np.float64], bounds: Bounds) -> float:
    """How wide bounds are at least, over what the signals of all runs sweep; 0 if a run is lost.

    Args:
        shown: shape (samples, signals, runs), the signals those of MachineOutputs; nan where a run is lost.
        bounds: by signal.
    """
    if not np.isfinite(shown).all():
        return 0.0
    swept = {name: float(np.ptp(shown[:, PLACES[name]])) for name in bounds if name in PLACES}
    wide = (
        (bounds[name][1] - bounds[name][0]) / sweep if sweep > 0.0 else math.inf
        for name, sweep in swept.items()
    )
    return min(wide, default=math.inf)


def kept(shown: NDArray[np.float64], bounds: Bounds) -> bool:
    """Whether all runs stay within bounds.

    Args:
        shown: shape (samples, signals, runs), the signals those of MachineOutputs; nan where a run is lost.
        bounds: by signal.
    """
    rows = ((shown[:, PLACES[name]], ends) for name, ends in bounds.items() if name in PLACES)
    return bool(
        np.isfinite(shown).all() and all(((low <= row) & (row <= high)).all() for row, (low, high) in rows)
    )
