"""The logs that a map is made from."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

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
    """
    given = [logs] if isinstance(logs, str | Path | Mapping) else list(logs)
    return [understood(log, i) for i, log in enumerate(read_logs(given, mapping, (TIME, *needed)))]


def demand(log: Understood, signals: Sequence[str], why: str) -> None:
    """Refuse a log that lacks a signal, or in which it never changes.

    Args:
        log: the log.
        signals: one of which must be there.
        why: what needs it.
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


class Piston(NamedTuple):
    """The piston of a plant.

    Attributes:
        plant: the plant.
        area_a: of chamber A [m^2].
        area_b: of chamber B [m^2].
    """

    plant: Any
    area_a: float
    area_b: float

    @property
    def has_chambers(self) -> bool:
        """Whether it is a cylinder with two chambers, and not one described by its load pressure."""
        return hasattr(self.plant, "volume_a")

    def volumes(self, position: Samples) -> tuple[Samples, Samples]:
        """V_A and V_B [m^3]; of a plant described by its load pressure, half of V_t each."""
        if not self.has_chambers:
            half = np.full(position.size, 0.5 * self.plant.total_volume)
            return half, half
        a, b = zip(
            *((self.plant.volume_a(x), self.plant.volume_b(x)) for x in position.tolist()), strict=True
        )
        return np.array(a), np.array(b)

    def inertia(self, position: float) -> float:
        """The moving mass [kg]."""
        if not self.has_chambers:
            return float(self.plant.mass)
        carried = self.plant.carried
        return float(carried.inertia(carried.init(), self.plant.mechanism, position))

    def resistance(self, position: float, velocity: float) -> float:
        """What the mechanism resists with at a steady speed, without friction of the piston [N]."""
        if not self.has_chambers:
            return 0.0
        carried = self.plant.carried
        return float(carried.resistance(carried.init(), self.plant.mechanism, position, velocity))


def piston_of(plant: Any, scenario: str) -> Piston:
    """The piston of a scenario's plant."""
    if hasattr(plant, "piston_area") and hasattr(plant, "total_volume"):
        return Piston(plant, plant.piston_area, plant.piston_area)
    if hasattr(plant, "volume_a") and hasattr(plant, "area_a"):
        return Piston(plant, plant.area_a, plant.area_b)
    problem = f"{type(plant).__name__} has no piston areas and volumes; Cylinder and LoadPressurePlant have"
    raise ScenarioError(scenario, "plant.type", problem)
