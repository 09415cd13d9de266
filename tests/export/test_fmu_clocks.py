"""A controller's FMU with a clock, call by call: its ticks take its samples, and its steps let time pass."""

import math
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy import fmi3
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from hydroservo.core.errors import ParameterError
from hydroservo.export.fmu import FmiVersion, write_fmu
from tests.support.export.fmus import Instance, mass, unpacked
from tests.support.export.toy import toy
from tests.support.export.toy_fmu import (
    COMMAND,
    DEMAND,
    GAIN,
    INTEGRAL,
    OK,
    VELOCITY,
    WARNING,
    Replica,
    refusal,
    refused,
)

CLOCK = "sample"
PERIOD = 1e-5


@pytest.fixture(scope="module")
def clocked_pi(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return unpacked(toy(), FmiVersion.FMI3, tmp_path_factory.mktemp("clocked"), clocked=True)


@pytest.fixture
def one(clocked_pi: Path) -> Iterator[Instance]:
    with Instance(clocked_pi) as instance:
        yield instance


def activate(one: Instance, active: bool = True) -> None:
    one.slave.setClock([one.references[CLOCK]], [active])


def stepping(one: Instance) -> Instance:
    """Past the first tick, in the step mode."""
    one.begin().tick({})
    return one


# --- the file


def test_the_description_says_what_belongs_to_the_clock(clocked_pi: Path) -> None:
    file = clocked_pi.parent / "one.fmu"
    assert validate_fmu(str(file)) == []
    about = fmpy.read_model_description(str(file), validate=True)
    found = {one.name: one for one in about.modelVariables}
    clock = found[CLOCK]
    assert (clock.type, clock.causality) == ("Clock", "input")
    (element,) = re.findall("<Clock .*/>", (clocked_pi / "modelDescription.xml").read_text())
    assert 'intervalVariability="constant" intervalDecimal="1e-05" shiftDecimal="0.0"' in element
    assert about.coSimulation.hasEventMode
    assert about.coSimulation.canHandleVariableCommunicationStepSize
    assert about.coSimulation.fixedInternalStepSize is None
    ticking = {VELOCITY, DEMAND, COMMAND, INTEGRAL, "controller.unlimited"}
    assert {name for name, one in found.items() if one.clocks == [clock]} == ticking
    assert all(one.clocks is None for name, one in found.items() if name not in ticking)
    (output,) = about.outputs
    assert [known.name for known in output.dependencies] == [CLOCK, VELOCITY, DEMAND]
    assert about.initialUnknowns == []


def test_its_own_page_says_how_it_ticks(clocked_pi: Path, tmp_path: Path) -> None:
    page = (clocked_pi / "documentation" / "index.html").read_text()
    assert "with an event mode and a clock, FMI 3.0" in page
    assert f"the input clock <code>{CLOCK}</code>" in page
    assert "whole multiple" not in page


@pytest.mark.parametrize(
    ("unit", "version", "said"),
    [
        (toy(), FmiVersion.FMI2, "clocked = True: FMI 2.0 has no clocks; use FMI 3.0"),
        (
            mass(),
            FmiVersion.FMI3,
            "clocked = True: only a controller can have a clock, and this is of machine",
        ),
    ],
)
def test_what_cannot_have_a_clock_is_said_in_a_line(
    unit: Any, version: FmiVersion, said: str, tmp_path: Path
) -> None:
    with pytest.raises(ParameterError, match=re.escape(said)):
        write_fmu(unit, tmp_path / "one.fmu", stop_time=1.0, version=version, clocked=True)
    assert list(tmp_path.iterdir()) == []


def test_an_importer_without_an_event_mode_is_told_why_there_is_no_instance(clocked_pi: Path) -> None:
    about = fmpy.read_model_description(clocked_pi)
    slave = fmi3.FMU3Slave(
        guid=about.guid, unzipDirectory=str(clocked_pi), modelIdentifier="toy", instanceName="a"
    )
    heard: list[bytes] = []
    with pytest.raises(Exception, match="Failed to instantiate FMU"):
        slave.instantiate(logMessage=lambda *said: heard.append(said[-1]), loggingOn=True)
    assert heard == [b"this FMU has a clock, which needs the event mode (eventModeUsed)"]


# --- samples


def test_a_tick_answers_at_once_and_takes_its_sample(one: Instance) -> None:
    one.begin()
    replica = Replica()
    for k in range(50):
        before = one.get(COMMAND, INTEGRAL)
        activate(one)
        inputs = {VELOCITY: 0.1 * math.sin(k), DEMAND: 0.3}
        one.set({VELOCITY: 5.0})
        one.set(inputs)
        answered = one.get(COMMAND, INTEGRAL)
        assert tuple(answered) == replica.step(*inputs.values())
        assert answered != before
        assert one.get(COMMAND, INTEGRAL) == answered  # asking changes nothing
        one.slave.updateDiscreteStates()
        assert one.get(COMMAND, INTEGRAL) == answered
        one.slave.updateDiscreteStates()  # as it is taken once
        one.slave.enterStepMode()
        assert one.get(COMMAND, INTEGRAL) == answered
        assert one.step(k * PERIOD) == OK
        one.slave.enterEventMode()
    assert one.messages == []


def test_a_tick_takes_inputs_as_they_stand(one: Instance) -> None:
    one.set({DEMAND: 0.02})
    one.begin()
    replica = Replica()
    expected = [replica.step(0.0, 0.02) for _ in range(3)]
    for k in range(3):
        one.tick({})
        assert tuple(one.get(COMMAND, INTEGRAL)) == expected[k]
        one.step(k * PERIOD)
        one.slave.enterEventMode()


def test_inputs_and_parameters_before_the_start_wait_for_the_first_tick(one: Instance) -> None:
    one.enter()
    one.set({DEMAND: 0.02, GAIN: 7.0})
    assert one.get(COMMAND) == [0.0]
    one.slave.exitInitializationMode()
    assert one.get(COMMAND) == [0.0]
    one.tick({})
    assert tuple(one.get(COMMAND, INTEGRAL)) == Replica(7.0).step(0.0, 0.02)


def test_parameters_change_between_ticks_and_in_them(one: Instance) -> None:
    one.begin()
    activate(one)
    one.set({DEMAND: 0.02})
    one.set({GAIN: 7.0})
    assert tuple(one.get(COMMAND, INTEGRAL)) == Replica(7.0).step(0.0, 0.02)
    one.slave.updateDiscreteStates()
    one.set({GAIN: 8.0})
    one.slave.enterStepMode()
    one.set({GAIN: 9.0})
    assert tuple(one.get(COMMAND, INTEGRAL)) == Replica(7.0).step(0.0, 0.02)
    assert one.get(GAIN) == [9.0]


def test_a_tick_that_is_taken_back_never_was(one: Instance) -> None:
    one.begin()
    before = one.get(COMMAND, INTEGRAL)
    activate(one)
    one.set({DEMAND: 0.02})
    assert one.get(COMMAND, INTEGRAL) != before
    activate(one, active=False)
    assert one.get(COMMAND, INTEGRAL) == before
    assert one.slave.getClock([one.references[CLOCK]]) == [False]
    activate(one)
    assert one.slave.getClock([one.references[CLOCK]]) == [True]
    assert tuple(one.get(COMMAND, INTEGRAL)) == Replica().step(0.0, 0.02)


def test_without_a_tick_there_is_no_sample_and_a_warning(one: Instance) -> None:
    stepping(one)
    before = one.get(COMMAND, INTEGRAL)
    assert one.step(0.0) == OK
    assert one.step(PERIOD, 2.5 * PERIOD) == WARNING
    assert one.messages == [
        ("logStatusWarning", "the clock sample was due at 1e-05 s and did not tick: no sample was taken")
    ]
    assert one.get(COMMAND, INTEGRAL) == before
    assert one.step(3.5 * PERIOD, 0.5 * PERIOD) == OK
    one.slave.enterEventMode()
    one.tick({DEMAND: 0.02})
    assert one.get(COMMAND, INTEGRAL) != before


def test_an_output_that_is_lost_is_a_warning(one: Instance) -> None:
    one.begin()
    one.tick({VELOCITY: math.nan})
    assert one.messages == [("logStatusWarning", f"{COMMAND} is not finite at 0 s")]


# --- time


def test_steps_of_any_size_let_time_pass(one: Instance) -> None:
    stepping(one)
    before, time = one.get(COMMAND, INTEGRAL), 0.0
    for part in (0.3, 0.01, 0.69):
        assert one.step(time, part * PERIOD) == OK
        time += part * PERIOD
        assert one.get("time") == [time]
        assert one.get(COMMAND, INTEGRAL) == before
    one.slave.enterEventMode()
    one.tick({})


def test_ticks_come_a_period_after_each_other_by_the_clock_of_the_importer(one: Instance) -> None:
    one.begin(start=5.0)
    time, own = 5.0, PERIOD * (1.0 + 1e-4)  # which loses a whole period in ten thousand
    for _ in range(20_000):
        one.tick({})
        assert one.step(time, own) == OK
        time += own
        one.slave.enterEventMode()
    assert one.messages == []


@pytest.mark.parametrize("size", [0.0, -1e-5, math.nan, math.inf])
def test_a_step_that_lets_no_time_pass_is_refused(one: Instance, size: float) -> None:
    stepping(one)
    assert f"a step of {size:.10g} s is not positive and finite" in refused(one, "step", 0.0, size)


@pytest.mark.parametrize("point", [0.0, 0.9e-5, 2e-5, math.nan])
def test_a_step_from_another_time_is_refused(one: Instance, point: float) -> None:
    stepping(one).step(0.0)
    assert "is not the time of this instance, 1e-05 s" in refused(one, "step", point, 1e-6)


def test_no_step_passes_the_stop_time(one: Instance) -> None:
    one.begin(stop=2e-5).tick({})
    assert one.step(0.0) == OK
    assert "passes the stop time of 2e-05 s" in refused(one, "step", PERIOD, 1.1 * PERIOD)


def test_a_tick_comes_where_it_is_due_and_once(one: Instance) -> None:
    one.begin()
    activate(one)
    one.slave.updateDiscreteStates()
    said = "the clock sample is due at 1e-05 s and cannot tick at"
    assert refusal(one, lambda: activate(one)) == f"{said} 0 s"
    one.slave.reset()
    stepping(one).step(0.0, 0.5 * PERIOD)
    one.slave.enterEventMode()
    assert refusal(one, lambda: activate(one)) == f"{said} 5e-06 s"


def test_the_interval_is_that_of_the_description(one: Instance) -> None:
    one.enter()
    assert interval_of(one) == (PERIOD, 1)  # unchanged, which is all that a constant clock may say
    shift = (fmi3.fmi3Float64 * 1)(1.0)
    one.slave.getShiftDecimal(references(one), shift)
    assert list(shift) == [0.0]
    one.slave.exitInitializationMode()
    activate(one)
    assert interval_of(one) == (PERIOD, 1)


def references(one: Instance) -> Any:
    return (fmi3.fmi3ValueReference * 1)(one.references[CLOCK])


def interval_of(one: Instance) -> tuple[float, int]:
    """And its qualifier."""
    interval, qualifier = (fmi3.fmi3Float64 * 1)(), (fmi3.fmi3IntervalQualifier * 1)()
    one.slave.getIntervalDecimal(references(one), interval, qualifier)
    return interval[0], qualifier[0]


# --- what is refused


@pytest.mark.parametrize("name", [VELOCITY, DEMAND])
def test_inputs_are_set_while_the_clock_is_active_alone(one: Instance, name: str) -> None:
    one.begin()
    said = f"{name} cannot be set while its clock, sample, is not active"
    assert refusal(one, lambda: one.set({name: 0.1})) == said
    one.slave.reset()
    stepping(one)
    assert refusal(one, lambda: one.set({GAIN: 5.0, name: 0.1})) == said
    assert one.get(GAIN) == [100.0]


REACHED: dict[str, Callable[[Instance], object]] = {
    "before the initialization mode": lambda _: None,
    "in the initialization mode": lambda one: one.enter(),
    "in the event mode": lambda one: one.begin(),
    "while the clock is active": lambda one: activate(one.begin()),
    "in the step mode": stepping,
    "after the termination": lambda one: one.begin().slave.terminate(),
}
CALLS: dict[str, tuple[Callable[[Instance], object], tuple[str, ...]]] = {
    "fmi3EnterEventMode": (lambda one: one.slave.enterEventMode(), ("step",)),
    "fmi3EnterStepMode": (lambda one: one.slave.enterStepMode(), ("event",)),
    "fmi3UpdateDiscreteStates": (lambda one: one.slave.updateDiscreteStates(), ("event", "active")),
    "fmi3SetClock": (activate, ("event", "active")),
    "fmi3DoStep": (lambda one: one.step(0.0), ("step",)),
    "fmi3GetIntervalDecimal": (interval_of, ("initialization mode", "event", "active")),
}


@pytest.mark.parametrize("where", REACHED)
@pytest.mark.parametrize("name", CALLS)
def test_calls_come_where_fmi_has_them(one: Instance, name: str, where: str) -> None:
    call, allowed = CALLS[name]
    REACHED[where](one)
    if any(word in where for word in allowed) and not where.startswith("before"):
        call(one)
        assert one.messages == []
    else:
        assert refusal(one, lambda: call(one)) == f"{name} must not be called {where}"


def test_what_a_constant_clock_does_not_do(one: Instance) -> None:
    wanted, whole = (fmi3.fmi3Float64 * 1)(1e-3), (fmi3.fmi3UInt64 * 1)(1)
    slave, clock = one.slave, references(one)
    for call, said in (
        (lambda: slave.setIntervalDecimal(clock, wanted), "are constant"),
        (lambda: slave.fmi3SetShiftDecimal(slave.component, clock, 1, wanted), "are constant"),
        (lambda: slave.getIntervalFraction(clock, whole, whole, None), "not fractions"),
        (lambda: slave.fmi3EvaluateDiscreteStates(slave.component), "not by a call"),
    ):
        one.slave.reset()
        one.begin()
        assert said in refusal(one, call)


def test_no_other_reference_is_that_of_the_clock(one: Instance) -> None:
    for wrong in (one.references[COMMAND], 11):
        one.slave.reset()
        one.begin()
        text = refusal(one, partial(one.slave.setClock, [wrong], [True]))
        assert text == f"no clock has the value reference {wrong}"
    said = "no variable of this type has the value reference 10"
    assert refusal(one, lambda: one.get(CLOCK)) == said
    one.slave.reset()
    one.begin()
    nothing = partial(one.slave.fmi3SetClock, one.slave.component, None, 1, None)
    assert "a null pointer" in refusal(one, nothing)


def test_fmpys_own_loop_which_knows_no_clocks_is_refused(clocked_pi: Path) -> None:
    signals = np.array([(0.0, 0.1), (5e-3, 0.1)], dtype=[("time", float), (VELOCITY, float)])
    with pytest.raises(FMICallException, match="fmi3SetFloat64 failed with status 3"):
        fmpy.simulate_fmu(str(clocked_pi), stop_time=5e-3, input=signals, use_event_mode=True)


# --- saved states


def test_a_state_saved_in_a_tick_is_restored_in_it(one: Instance, clocked_pi: Path) -> None:
    stepping(one).step(0.0)
    one.slave.enterEventMode()
    activate(one)
    one.set({DEMAND: 0.02})
    saved, answered = one.save(), one.get(COMMAND, INTEGRAL, "time")
    data = one.slave.serializeFMUState(saved)
    one.set({DEMAND: 0.5})
    one.slave.updateDiscreteStates()
    one.slave.enterStepMode()
    one.step(PERIOD)
    one.restore(saved)
    assert one.get(COMMAND, INTEGRAL, "time") == answered
    one.slave.freeFMUState(saved)
    with Instance(clocked_pi, "other") as other:
        again = other.slave.deserializeFMUState(data)
        other.restore(again)
        assert other.slave.getClock([other.references[CLOCK]]) == [True]
        other.slave.updateDiscreteStates()
        other.slave.enterStepMode()
        assert other.get(COMMAND, INTEGRAL, "time") == answered
        assert other.step(PERIOD) == OK
        other.slave.freeFMUState(again)


def test_a_reset_instance_begins_anew(one: Instance) -> None:
    one.begin(start=3.0)
    one.tick({DEMAND: 0.02})
    one.step(3.0)
    one.slave.reset()
    one.begin()
    assert one.get(COMMAND, "time") == [0.0, 0.0]
    one.tick({DEMAND: 0.02})
    assert tuple(one.get(COMMAND, INTEGRAL)) == Replica().step(0.0, 0.02)
