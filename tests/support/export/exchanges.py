"""Instances of FMUs for model exchange, of either version behind one face; and an integrator of one's own."""

from collections.abc import Callable, Mapping
from ctypes import c_double
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy import fmi2, fmi3
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.export.compilers import this_platform
from hydroservo.export.fmu import FmiVersion
from hydroservo.export.fmu.write import library_place
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import CModule, Part
from hydroservo.machine.loads import Step
from hydroservo.machine.plants import Cylinder
from hydroservo.testing.examples import example

States = NDArray[np.float64]


def equations() -> CModule:
    """Those of an axis whose load jumps."""
    loop = example(Loop, plant=example(Cylinder), load=example(Step))
    return exported_unit(loop, Part.EQUATIONS, prefix="axis", title="equations of an axis")


class Exchange:
    """One instance of an unpacked FMU, in the words that both versions share."""

    def __init__(self, folder: Path) -> None:
        description = fmpy.read_model_description(folder)
        self.version = FmiVersion(str(description.fmiMajorVersion))
        self.references = {one.name: one.valueReference for one in description.modelVariables}
        self.count = description.numberOfContinuousStates
        self.messages: list[str] = []
        identifier = description.modelExchange.modelIdentifier
        kind = fmi2.FMU2Model if self.version is FmiVersion.FMI2 else fmi3.FMU3Model
        self.model: Any = kind(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=identifier,
            instanceName="one",
            libraryPath=str(folder / library_place(self.version, identifier, this_platform())),
        )
        if self.version is FmiVersion.FMI2:
            callbacks = fmi2.fmi2CallbackFunctions()
            callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(
                lambda _, __, ___, ____, text: self.messages.append(text.decode())
            )
            self.model.instantiate(callbacks=callbacks, loggingOn=True)
        else:
            self.model.instantiate(
                logMessage=lambda _, __, ___, text: self.messages.append(text.decode()), loggingOn=True
            )

    def __enter__(self) -> "Exchange":
        return self

    def __exit__(self, *_: object) -> None:
        self.model.freeInstance()

    def begin(self, start: float = 0.0) -> "Exchange":
        """Through the initialization, into the event mode."""
        if self.version is FmiVersion.FMI2:
            self.model.setupExperiment(startTime=start)
            self.model.enterInitializationMode()
        else:
            self.model.enterInitializationMode(startTime=start)
        self.model.exitInitializationMode()
        return self

    def go_on(self) -> float | None:
        """From the event mode into continuous time; returns the time of the next event, if there is one."""
        update = "newDiscreteStates" if self.version is FmiVersion.FMI2 else "updateDiscreteStates"
        *_, defined, next_time = getattr(self.model, update)()
        self.model.enterContinuousTimeMode()
        return next_time if defined else None

    def event(self, t: float) -> float | None:
        """Through an event."""
        self.model.setTime(t)
        self.model.enterEventMode()
        return self.go_on()

    def get(self, *names: str) -> list[float]:
        references = [self.references[name] for name in names]
        model = self.model
        return (model.getReal if self.version is FmiVersion.FMI2 else model.getFloat64)(references)

    def set(self, values: Mapping[str, float]) -> None:
        references = [self.references[name] for name in values]
        model = self.model
        (model.setReal if self.version is FmiVersion.FMI2 else model.setFloat64)(
            references, list(values.values())
        )

    @property
    def states(self) -> States:
        found = (c_double * self.count)()
        self.model.getContinuousStates(found, self.count)
        return np.array(found)

    @states.setter
    def states(self, values: States) -> None:
        self.model.setContinuousStates((c_double * self.count)(*values), self.count)

    def rates(self, t: float, x: States) -> States:
        self.model.setTime(t)
        self.states = x
        found = (c_double * self.count)()
        name = "getDerivatives" if self.version is FmiVersion.FMI2 else "getContinuousStateDerivatives"
        getattr(self.model, name)(found, self.count)
        return np.array(found)


def rk4(rates: Callable[[float, States], States], t: float, x: States, h: float) -> States:
    """A step of the classical Runge-Kutta method, as the textbook has it."""
    k1 = rates(t, x)
    k2 = rates(t + 0.5 * h, x + 0.5 * h * k1)
    k3 = rates(t + 0.5 * h, x + 0.5 * h * k2)
    k4 = rates(t + h, x + h * k3)
    return ((x + h / 6.0 * k1 + h / 3.0 * k2) + h / 3.0 * k3) + h / 6.0 * k4
