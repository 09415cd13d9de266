"""Controllers with a clock beside a machine that steps: the bits of a strict simulation, and of steps."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from hydroservo import simulate
from hydroservo.control.loop import Loop
from hydroservo.export.fmu import FmiVersion
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.scenario import load_scenario
from tests.support.export.fmus import Instance, unpacked

SAMPLES = 1000
PERIOD = 1e-3
TSMC, PI = "rig/1khz-tsmc-sine", "rig/1khz-pi-sine"
COMMAND, VELOCITY = "controller.u", "plant.velocity"


@cache
def short(name: str, period: float) -> Loop:
    """A loop of few samples, each of which is recorded."""
    loop = load_scenario(name, {"simulation.period": period})
    brief = loop.simulation._replace(duration=SAMPLES * period, record_period=period)
    return loop._replace(simulation=brief)


def fmu(folder: Path, name: str, period: float = PERIOD, part: Part = Part.CONTROLLER, **clock: bool) -> Path:
    unit = exported_unit(short(name, period), part, prefix="unit", title=f"{part} of {name}")
    return unpacked(unit, FmiVersion.FMI3, folder, **clock)


def seen(controller: Instance, machine: Instance, t: float) -> dict[str, float]:
    """What a controller is given at a sample."""
    demand = short(TSMC, PERIOD).reference.at(t)._asdict()
    measured = [name for name in controller.references if name.startswith("measurement.")]
    wanted = [name for name in controller.references if name.startswith("demand.")]
    values = dict(zip(measured, machine.get(*measured), strict=True))
    return values | {name: demand[name.removeprefix("demand.")] for name in wanted}


@pytest.mark.slow  # it builds two FMUs
def test_a_clocked_controller_and_a_machine_make_the_loop(tmp_path_factory: pytest.TempPathFactory) -> None:
    data = simulate(short(TSMC, PERIOD), strict=True)
    law = fmu(tmp_path_factory.mktemp("law"), TSMC, clocked=True)
    body = fmu(tmp_path_factory.mktemp("body"), TSMC, part=Part.MACHINE)
    with Instance(law) as controller, Instance(body) as machine:
        own = [name for name in controller.references if name.startswith("controller.") and name in data]
        its = [name for name in machine.references if name.startswith(("plant.", "valve.")) and name in data]
        controller.begin()
        machine.begin()
        laws, machines = [], []
        for k in range(SAMPLES):
            machines.append(machine.get(*its))
            controller.slave.setClock([controller.references["sample"]], [True])
            controller.set(seen(controller, machine, k * PERIOD))
            machine.set({COMMAND: controller.get(COMMAND)[0]})
            controller.slave.updateDiscreteStates()
            controller.slave.enterStepMode()
            laws.append(controller.get(*own))
            assert (machine.step(k * PERIOD), controller.step(k * PERIOD)) == (0, 0)
            controller.slave.enterEventMode()
    assert {COMMAND, VELOCITY, "controller.controller.observer.d1"} <= {*own, *its}
    for names, rows in ((own, laws), (its, machines)):
        for name, values in zip(names, np.array(rows).T, strict=True):
            np.testing.assert_array_equal(values, data[name].values[:SAMPLES], err_msg=name)


@pytest.mark.nightly  # it builds five FMUs
def test_two_clocks_beside_steps_of_another_size(tmp_path_factory: pytest.TempPathFactory) -> None:
    """A machine of 2 kHz, its controller of 1 kHz, and one of 500 Hz that watches it: as without clocks."""
    body = fmu(tmp_path_factory.mktemp("body"), TSMC, 0.5 * PERIOD, Part.MACHINE)
    found = [
        run(
            body,
            fmu(tmp_path_factory.mktemp("law"), TSMC, clocked=clocked),
            fmu(tmp_path_factory.mktemp("watch"), PI, 2.0 * PERIOD, clocked=clocked),
        )
        for clocked in (False, True)
    ]
    np.testing.assert_array_equal(*found)
    assert np.all(np.ptp(found[0], axis=0) > 0.0)


def run(body: Path, law: Path, watch: Path) -> np.ndarray:
    """Velocity and commands at every millisecond; with clocks all take steps of half of one."""
    rows = []
    with Instance(body) as machine, Instance(law) as controller, Instance(watch) as other:
        both, clocked = {1: controller, 2: other}, "sample" in controller.references
        for one in (machine, controller, other):
            one.begin()
        for k in range(SAMPLES):
            t = k * PERIOD
            for every, one in both.items():
                if k % every == 0 and clocked:
                    one.tick(seen(one, machine, t))
                elif k % every == 0:
                    one.set(seen(one, machine, t))
                    assert one.step(t, every * PERIOD) == 0
            machine.set({COMMAND: controller.get(COMMAND)[0]})
            rows.append([*machine.get(VELOCITY), *controller.get(COMMAND), *other.get(COMMAND)])
            if clocked:
                halves(t, machine, controller, other)
                for every, one in both.items():
                    if (k + 1) % every == 0:
                        one.slave.enterEventMode()
            else:
                assert machine.step(t, PERIOD) == 0
    return np.array(rows)


def halves(t: float, *instances: Instance) -> None:
    """Two steps of half a period each."""
    for part in range(2):
        for one in instances:
            assert one.step(t + 0.5 * PERIOD * part, 0.5 * PERIOD) == 0
