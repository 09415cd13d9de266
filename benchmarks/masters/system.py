"""The loop that masters are measured with: its units as FMUs, and what it does where it is simulated."""

import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo import simulate
from hydroservo.control.loop import Loop
from hydroservo.export.fmu import PARTS, FmiVersion, write_fmu, write_ssp
from hydroservo.export.fmu.write import Connection, connections
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import CModule, Part
from hydroservo.scenario import load_scenario

__all__ = [
    "SAMPLES",
    "VELOCITY",
    "System",
    "delayed",
    "error",
    "simulated",
    "system",
    "undelayed",
]

SCENARIO = "rig/1khz-tsmc-sine"
SAMPLES = 1000
VELOCITY = "plant.velocity"  # what is recorded, by its name in the machine's FMU
DELAY = {"hold.type": "DelayedHold", "hold.delay": "1 ms"}
# Those with which it was measured: a search found them while metrics looked at samples alone.
MEASURED = {
    "controller.reach": 1.3114,
    "controller.controller.linear_gain_1": 1190.0,
    "controller.controller.linear_gain_2": 1427.1,
    "controller.controller.power_gain_1": 33.884,
    "controller.controller.power_gain_2": 0.16372,
    "controller.controller.derivative.time_constant": 0.070559,
    "controller.controller.observer.linear_gain_1": 2.6506,
    "controller.controller.observer.linear_gain_2": 3.7227,
    "controller.controller.observer.switching_gain_1": 22.285,
    "controller.controller.observer.switching_gain_2": 259470.0,
    "controller.controller.observer.power_gain_1": 0.47015,
    "controller.controller.observer.power_gain_2": 14480.0,
}
# Found by the search in the scenario's file with this hold, and linear gains of the controller from 3 1/s on.
GAINS = {
    "controller.reach": 24.589,
    "controller.controller.linear_gain_1": 2114.5,
    "controller.controller.linear_gain_2": 2017.7,
    "controller.controller.power_gain_1": 73.506,
    "controller.controller.power_gain_2": 452.56,
    "controller.controller.derivative.time_constant": 6.4797e-05,
    "controller.controller.observer.linear_gain_1": 578.84,
    "controller.controller.observer.linear_gain_2": 156.71,
    "controller.controller.observer.switching_gain_1": 52.074,
    "controller.controller.observer.switching_gain_2": 1036700.0,
    "controller.controller.observer.power_gain_1": 0.4229,
    "controller.controller.observer.power_gain_2": 583.08,
}


class System(NamedTuple):
    """A loop as FMUs.

    Attributes:
        folder: what holds ``loop.ssp``, ``loop.fmu``, which is all of it in one, and an FMU for each part.
        version: of FMI.
        connections: from outputs to inputs; those that an answer depends on come before it.
        period: of the samples [s].
    """

    folder: Path
    version: FmiVersion
    connections: tuple[Connection, ...]
    period: float

    @property
    def ssp(self) -> Path:
        return self.folder / "loop.ssp"

    def fmu(self, part: Part) -> Path:
        return self.folder / f"{part}.fmu"


def undelayed() -> Loop:
    """The loop of the scenario, with the gains that were measured."""
    return load_scenario(SCENARIO, duration() | MEASURED)


def delayed() -> Loop:
    """The loop whose commands come a period late, with gains that were found for it."""
    return load_scenario(SCENARIO, duration() | DELAY | GAINS)


def duration() -> dict[str, object]:
    """What a run of so many samples takes, each of which is recorded."""
    return {"simulation.duration": SAMPLES * 1e-3, "simulation.record_period": 1e-3}


def system(controlled: Loop, version: FmiVersion, folder: Path) -> System:
    """The undelayed loop's machine and demand, and the controller of this loop."""
    plain = undelayed()
    units = {part: unit_of(controlled if part is Part.CONTROLLER else plain, part) for part in PARTS}
    stop_time = plain.simulation.duration
    folder.mkdir()
    made = System(folder, version, tuple(connections(units)), plain.simulation.period)
    write_fmu(unit_of(controlled, Part.LOOP), made.fmu(Part.LOOP), stop_time=stop_time, version=version)
    with zipfile.ZipFile(write_ssp(units, made.ssp, stop_time=stop_time, version=version)) as archive:
        for part in PARTS:
            made.fmu(part).write_bytes(archive.read(f"resources/{part}.fmu"))
    return made


def unit_of(loop: Loop, part: Part) -> CModule:
    return exported_unit(loop, part, prefix=part.value, title=f"the {part} of {SCENARIO}")


def simulated(loop: Loop) -> NDArray[np.float64]:
    """The velocity at each sample where the loop is simulated [m/s]."""
    return np.asarray(simulate(loop, strict=True)[VELOCITY].values[:SAMPLES])


def error(velocities: NDArray[np.float64]) -> float:
    """The rms error of a velocity against the demand [m/s]."""
    loop = undelayed()
    demand = np.array([loop.reference.at(k * loop.simulation.period).value for k in range(SAMPLES)])
    return float(np.sqrt(np.mean((velocities - demand) ** 2)))
