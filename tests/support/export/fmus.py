"""FMUs in tests: a machine in C by hand, and instances of either version behind one face."""

from collections.abc import Mapping, Sequence
from ctypes import byref, c_void_p
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import xarray as xr
from fmpy import fmi2, fmi3

from hydroservo.control.loop import Loop
from hydroservo.export.compilers import this_platform
from hydroservo.export.fmu import FmiVersion, write_fmu
from hydroservo.export.fmu.write import library_place
from hydroservo.export.unit import Argument, CModule, Part, Signal
from tests.support.export.by_hand import by_hand

MACHINE = ("plant.", "valve.", "supply.", "sensors.")

HEADER = """\
#ifndef MASS_H
#define MASS_H

typedef struct {
    double growth; /* [1] factor from sample to sample */
    double first;  /* [m/s] velocity at the start */
    double period; /* [s] sample period */
} mass_parameters;

typedef struct {
    double velocity; /* [m/s] velocity */
} mass_plant;

typedef struct {
    mass_plant plant;
    double reading; /* [m/s] measured velocity */
    double before;  /* [m/s] measured velocity before */
} mass_state;

typedef struct {
    double u; /* [V] command */
} mass_command;

typedef struct {
    double noise; /* [m/s] noise of the sensor */
} mass_disturbance;

extern const mass_parameters mass_defaults;

void mass_init(mass_state *state, const mass_parameters *parameters);
void mass_step(mass_state *state, const mass_parameters *parameters, const mass_command *command,
               const mass_disturbance *disturbance);

#endif
"""

SOURCE = """\
#include "mass.h"
#include <math.h>

const mass_parameters mass_defaults = {.growth = 0.5, .first = 0.25, .period = 0.001};

void mass_init(mass_state *state, const mass_parameters *parameters) {
    *state = (mass_state){.plant = {.velocity = parameters->first}, .reading = 0.0, .before = NAN};
}

void mass_step(mass_state *state, const mass_parameters *parameters, const mass_command *command,
               const mass_disturbance *disturbance) {
    const double velocity = parameters->growth * state->plant.velocity + command->u;
    *state = (mass_state){
        .plant = {.velocity = velocity},
        .reading = velocity + disturbance->noise,
        .before = state->reading,
    };
}
"""


def mass() -> CModule:
    """A machine: states that must stay finite beside a sensor whose reading need not."""
    return by_hand(
        "mass",
        'Machine of "a < b & c"',
        1e-3,
        (HEADER, SOURCE),
        parameters=(
            Signal("plant.growth", "growth", "", "factor < 1 & from sample to sample", 0.5),
            Signal("plant.first", "first", "m/s", "velocity at the start", 0.25, fixed=True),
            Signal("simulation.period", "period", "s", "sample period", 1e-3, fixed=True),
        ),
        arguments=(
            Argument("command", (Signal("command.u", "u", "V", "command", 0.0),)),
            Argument("disturbance", (Signal("noise", "noise", "m/s", "noise of the sensor", 0.0),)),
        ),
        states=(
            Signal("plant.velocity", "plant.velocity", "m/s", "velocity", 0.25, integrated=True),
            Signal("sensors.reading", "reading", "m/s", "measured velocity", 0.0),
            Signal("sensors.before", "before", "m/s", "measured velocity before", float("nan")),
        ),
        part=Part.MACHINE,
    )


def unpacked(unit: CModule, version: FmiVersion, folder: Path, *, clocked: bool = False) -> Path:
    """The folder of an export's FMU, which lies beside it."""
    file = write_fmu(unit, folder / "one.fmu", stop_time=1.0, version=version, clocked=clocked)
    return Path(fmpy.extract(str(file), unzipdir=str(folder / "unpacked")))


class Instance:
    """One instance of an unpacked FMU, in the words that both versions share."""

    def __init__(self, folder: Path, name: str = "one", *, log: bool = True) -> None:
        description = fmpy.read_model_description(folder)
        self.version = FmiVersion(str(description.fmiMajorVersion))
        self.references = {one.name: one.valueReference for one in description.modelVariables}
        self.period = float(description.defaultExperiment.stepSize)
        self.messages: list[tuple[str, str]] = []  # category and text
        kind = fmi2.FMU2Slave if self.version is FmiVersion.FMI2 else fmi3.FMU3Slave
        identifier = description.coSimulation.modelIdentifier
        self.slave: Any = kind(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=identifier,
            instanceName=name,
            # FMPy looks for one of FMI 2.0 in linux64 and darwin64 on ARM too.
            libraryPath=str(folder / library_place(self.version, identifier, this_platform())),
        )
        if self.version is FmiVersion.FMI2:
            callbacks = fmi2.fmi2CallbackFunctions()
            callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(
                lambda _, __, ___, category, text: self.heard(category, text)
            )
            self.slave.instantiate(callbacks=callbacks, loggingOn=log)
        else:
            self.slave.instantiate(
                logMessage=lambda _, __, *said: self.heard(*said),
                loggingOn=log,
                eventModeUsed=bool(description.coSimulation.hasEventMode),
            )

    def heard(self, category: bytes, text: bytes) -> None:
        self.messages.append((category.decode(), text.decode()))

    def __enter__(self) -> "Instance":
        return self

    def __exit__(self, *_: object) -> None:
        self.slave.freeInstance()

    def begin(self, start: float = 0.0, stop: float | None = None, **__: object) -> "Instance":
        """Through the initialization."""
        self.enter(start, stop)
        self.slave.exitInitializationMode()
        return self

    def enter(self, start: float = 0.0, stop: float | None = None) -> None:
        if self.version is FmiVersion.FMI2:
            self.slave.setupExperiment(startTime=start, stopTime=stop)
            self.slave.enterInitializationMode()
        else:
            self.slave.enterInitializationMode(startTime=start, stopTime=stop)

    def get(self, *names: str) -> list[float]:
        return self.get_references([self.references[name] for name in names])

    def get_references(self, references: Sequence[int]) -> list[float]:
        slave = self.slave
        return (slave.getReal if self.version is FmiVersion.FMI2 else slave.getFloat64)(references)

    def set(self, values: Mapping[str, float]) -> None:
        references = [self.references[name] for name in values]
        slave = self.slave
        (slave.setReal if self.version is FmiVersion.FMI2 else slave.setFloat64)(
            references, list(values.values())
        )

    def step(self, point: float, size: float | None = None) -> int:
        """One communication step, of a sample period where no other size is given; returns its status."""
        size = self.period if size is None else size
        slave = self.slave
        if self.version is FmiVersion.FMI2:
            return slave.fmi2DoStep(slave.component, point, size, 1)
        results = (fmi3.fmi3Boolean(True), fmi3.fmi3Boolean(True), fmi3.fmi3Boolean(True))
        last = fmi3.fmi3Float64()
        status = slave.fmi3DoStep(
            slave.component, point, size, fmi3.fmi3True, *map(byref, results), byref(last)
        )
        assert not any(one.value for one in results)
        assert last.value == self.get("time")[0]
        return int(status)

    def tick(self, values: Mapping[str, float]) -> None:
        """One sample of a clock, from the event mode on and into the step mode."""
        self.slave.setClock([self.references["sample"]], [True])
        self.set(values)
        self.slave.updateDiscreteStates()
        self.slave.enterStepMode()

    def save(self) -> c_void_p:
        return self.slave.getFMUState()

    def restore(self, state: c_void_p) -> None:
        self.slave.setFMUState(state)


def parts_make_the_run(loop: Loop, data: xr.Dataset, law: Path, axis: Path) -> None:
    """Unpacked FMUs of a controller and a machine, under the loop's demand, give a run's every sample."""
    period = loop.simulation.period
    with Instance(law) as controller, Instance(axis) as machine:
        given = [one for one in controller.references if one.startswith("measurement.")]
        wanted = [one for one in controller.references if one.startswith("demand.")]
        own = [one for one in controller.references if one.startswith("controller.") and one in data]
        its = [one for one in machine.references if one.startswith(MACHINE) and one in data]
        controller.begin()
        machine.begin()
        rows = []
        samples = data["controller.u"].size - 1
        for k in range(samples):
            states = machine.get(*its)
            demand = loop.reference.at(k * period)._asdict()
            controller.set(dict(zip(given, machine.get(*given), strict=True)) if given else {})
            controller.set({one: demand[one.removeprefix("demand.")] for one in wanted})
            assert controller.step(k * period) == 0
            rows.append(controller.get(*own) + states)
            machine.set({"controller.u": controller.get("controller.u")[0]})
            assert machine.step(k * period) == 0
    assert "controller.u" in own
    assert any(one.startswith("plant.") for one in its)
    for one, values in zip([*own, *its], np.array(rows).T, strict=True):
        np.testing.assert_array_equal(values, data[one].values[:samples], err_msg=one)
