"""Runs masters, and keeps what was measured of those that are not here."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.masters.master import Master
from benchmarks.masters.system import SAMPLES, System, delayed, error, simulated, system, undelayed
from hydroservo.export.fmu import FmiVersion

__all__ = ["RESULTS", "Result", "Results", "Systems", "exported_systems", "measured", "updated"]

RESULTS = Path(__file__).with_name("results.json")

Result = dict[str, Any]
Results = dict[str, Result]  # by the name of the master
Systems = dict[str, System]


def exported_systems(folder: Path) -> Systems:
    """The loop as FMUs of both versions, and with the gains for a delay."""
    plain = {version.value: system(undelayed(), version, folder / version) for version in FmiVersion}
    return plain | {"delayed": system(delayed(), FmiVersion.FMI2, folder / "delayed")}


def measured(master: Master, systems: Systems, say: Callable[[str], None]) -> Result:
    """What becomes of the loop under a master.

    Raises:
        Exception: what the master raises on FMUs of FMI 2; one that cannot read those of FMI 3 need not.
    """
    older = velocities(master, systems["2"])
    versions = ["2"]
    try:
        newer = velocities(master, systems["3"])
    except Exception as problem:  # each tool has its own
        say(f"{master.name}, FMI 3: {problem}")
    else:
        if not np.array_equal(older, newer):
            raise RuntimeError(f"{master.name}: FMUs of FMI 3 run otherwise than those of FMI 2")
        versions.append("3")
    return {
        "version": master.version(),
        "fmi": versions,
        "equal": int(np.sum(older == simulated(undelayed()))),
        "error": error(older),
        "error_with_gains_for_delay": error(velocities(master, systems["delayed"])),
    }


def velocities(master: Master, coupled: System) -> NDArray[np.float64]:
    values = np.asarray(master.velocities(coupled), dtype=np.float64)
    if values.shape != (SAMPLES,):
        raise RuntimeError(f"{master.name}: {values.shape[0]} samples instead of {SAMPLES}")
    return values


def updated(
    results: Results, masters: Iterable[Master], systems: Systems, say: Callable[[str], None]
) -> Results:
    """The results with those of the masters that are here measured anew."""
    newest = dict(results)
    for master in masters:
        if master.version() is None:
            say(f"{master.name}: {master.package} is not installed; its last result is kept")
            continue
        say(master.name)
        try:
            newest[master.name] = measured(master, systems, say)
        except Exception as problem:  # each tool has its own
            say(f"{master.name}: {problem}; its last result is kept")
    return newest
