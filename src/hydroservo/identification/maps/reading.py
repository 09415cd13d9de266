"""The logs that a map is made from."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import ScenarioError
from hydroservo.identification.log import Given, read_logs
from hydroservo.identification.segments import Segment, Understood, understood
from hydroservo.identification.signals import SIGNALS, TIME

Samples = NDArray[np.float64]


def logs_of(
    logs: Given | Sequence[Given], mapping: Mapping[str, str], needed: Sequence[str]
) -> list[Understood]:
    """The logs, as they are understood.

    Args:
        logs: one or several, as :func:`~hydroservo.identification.maps.map_logs` takes them.
        mapping: which column holds which signal.
        needed: signals, besides the time, without which a log is none.

    Raises:
        ParameterError: there is none.
        ScenarioError: one is not what it must be.
    """
    given = [logs] if isinstance(logs, str | Path | Mapping) else list(logs)
    return [understood(log, i) for i, log in enumerate(read_logs(given, mapping, (TIME, *needed)))]


def demand(log: Understood, signals: Sequence[str], why: str) -> None:
    """Refuse a log that lacks a signal, or in which it never changes.

    Args:
        log: the log.
        signals: one of which must be there.
        why: what needs it.

    Raises:
        ScenarioError: none is.
    """
    if not any(set(signals) & set(one.measured) for one in log.segments):
        names = " or ".join(f'"{name} [{SIGNALS[name].unit}]"' for name in signals)
        lacking = "changes" if set(signals) & set(log.log.signals) else "is there"
        raise ScenarioError(log.log.name, "", f"no column {names} {lacking}, which {why} needs")


def velocity_of(one: Segment) -> Samples:
    """The velocity in a stretch [m/s]: measured, or the slope of the position."""
    if "velocity" in one.measured:
        return one.measured["velocity"]
    return np.gradient(one.measured["position"], one.period)


def bridged(values: Samples, log: int) -> Samples:
    """A signal with straight lines over what is missing.

    Args:
        values: shape (n,).
        log: the number of the log, from 0.

    Raises:
        ScenarioError: there is nothing else.
    """
    places, there = np.arange(values.size), np.isfinite(values)
    if not there.any():
        raise ScenarioError(
            f"log {log + 1}",
            "",
            "a signal is missing throughout a stretch between two gaps: cut that stretch out",
        )
    found: Samples = np.interp(places, places[there], values[there])
    return found
