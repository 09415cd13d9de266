"""What an instance of an FMU does, call by call, in both versions of FMI."""

import math
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from hydroservo.export.fmu import FmiVersion
from tests.support.export.fmus import Instance
from tests.support.export.toy_fmu import (
    COMMAND,
    DEMAND,
    GAIN,
    INTEGRAL,
    OK,
    VELOCITY,
    WARNING,
    Replica,
    discarded,
    refused,
)


def test_instances_side_by_side_are_independent(pi: Path) -> None:
    draws = np.random.default_rng(1)
    with Instance(pi, "a") as a, Instance(pi, "b") as b:
        a.begin().set({GAIN: 30.0})
        b.begin(start=5.0)
        replicas = Replica(30.0), Replica()
        for k in range(300):
            for instance, replica, start in ((a, replicas[0], 0.0), (b, replicas[1], 5.0)):
                velocity, demand = draws.uniform(-0.3, 0.3, 2)
                instance.set({VELOCITY: velocity, DEMAND: demand})
                assert instance.step(start + k * 1e-5) == OK
                assert tuple(instance.get(COMMAND, INTEGRAL)) == replica.step(velocity, demand)
        assert a.get("time") == [300 * 1e-5]
        assert b.get("time") == [5.0 + 300 * 1e-5]
        assert not a.messages + b.messages


def test_a_step_of_many_periods_holds_the_inputs(one: Instance) -> None:
    one.begin().set({DEMAND: 0.03})
    replica = Replica()
    assert one.step(0.0, 7e-5) == OK
    for _ in range(7):
        expected = replica.step(0.0, 0.03)
    assert tuple(one.get(COMMAND, INTEGRAL)) == expected
    assert one.step(7e-5, 1e-5) == OK


def test_a_reset_instance_is_a_new_one(one: Instance, pi: Path) -> None:
    one.begin().set({DEMAND: 0.03, GAIN: 7.0})
    one.step(0.0)
    one.slave.terminate()
    one.slave.reset()
    with Instance(pi) as new:
        names = list(one.references)
        assert one.get(*names) == new.get(*names)
    one.begin().set({DEMAND: 0.03})
    assert one.step(0.0) == OK
    assert tuple(one.get(COMMAND, INTEGRAL)) == Replica().step(0.0, 0.03)


@pytest.mark.parametrize("size", [0.0, -1e-5, 0.5e-5, 1.5e-5, 1.01e-5, 2.99e-5, 1e300, math.nan, math.inf])
def test_a_step_that_is_no_whole_multiple_is_refused(one: Instance, size: float) -> None:
    one.begin()
    text = refused(one, "step", 0.0, size)
    assert f"a step of {size:.10g} s" in text
    assert "sample period of 1e-05 s" in text
    assert one.get("time") == [0.0]


@pytest.mark.parametrize("point", [0.0, 2e-5, 0.4e-5, math.nan])
def test_a_step_from_another_time_is_refused(one: Instance, point: float) -> None:
    one.begin()
    one.step(0.0)
    text = refused(one, "step", point)
    assert f"{point:.10g} s" in text
    assert "1e-05 s" in text


def test_time_that_an_importer_adds_up_may_drift(one: Instance) -> None:
    one.begin(stop=6e-5)
    assert one.step(2e-7, 2e-5 + 9e-9) == OK
    assert one.step(2e-5 - 2e-7, 3e-5 - 9e-9) == OK
    assert one.step(5e-5 + 4e-6) == OK
    assert one.get("time") == [6 * 1e-5]


def test_no_step_passes_the_stop_time(one: Instance) -> None:
    one.begin(stop=2e-5)
    assert one.step(0.0, 2e-5) == OK
    assert "passes the stop time of 2e-05 s" in refused(one, "step", 2e-5)


def test_start_and_stop_must_be_times(one: Instance) -> None:
    assert "the stop time of 1 s comes before the start time of 2 s" in refused(one, "enter", 2.0, 1.0)
    one.slave.reset()
    assert "a start time of inf s" in refused(one, "enter", math.inf)


def test_unknown_value_references_are_refused(one: Instance) -> None:
    assert "no variable of this type has the value reference 10" in refused(one, "get_references", [7, 10])
    one.slave.reset()
    one.references["beyond"] = 4_294_967_295
    assert "value reference 4294967295" in refused(one, "set", {"beyond": 1.0})


@pytest.mark.parametrize("name", ["time", "period", COMMAND, INTEGRAL])
def test_what_is_not_of_the_importer_cannot_be_set(one: Instance, name: str) -> None:
    text = refused(one, "set", {GAIN: 5.0, name: 1.0})
    assert text.startswith(f"{name} cannot be set: ")
    assert one.get(GAIN) == [100.0]  # nor is what was given with it


def test_fixed_parameters_are_set_before_the_start_alone(machine: Path) -> None:
    with Instance(machine) as one:
        one.set({"plant.first": 0.5})
        assert one.get("plant.velocity") == [0.5]
        one.enter()
        one.set({"plant.first": 0.75})
        assert one.get("plant.velocity") == [0.75]
        one.slave.exitInitializationMode()
        assert one.get("plant.velocity") == [0.75]
        one.set({"plant.growth": 2.0})
        one.step(0.0)
        assert one.get("plant.velocity") == [1.5]
        assert "plant.first cannot be set after the initialization" in refused(
            one, "set", {"plant.first": 1.0}
        )
        assert one.get("plant.first") == [0.75]


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_parameters_are_finite_and_inputs_need_not_be(one: Instance, value: float) -> None:
    one.set({VELOCITY: value})
    text = discarded(one, "set", {GAIN: value})
    assert text == f"{GAIN} stays as it is and is not set to {value:g}: a parameter is a finite number"
    assert one.get(GAIN) == [100.0]


@pytest.mark.parametrize("value", [-1.0, -5e-324, 1e300])
def test_parameters_lie_in_their_ranges(one: Instance, value: float) -> None:
    text = discarded(one, "set", {VELOCITY: 0.5, GAIN: value})
    assert text == f"{GAIN} stays as it is and is not set to {value:.10g}: it lies from 0 to 1000000"
    assert one.get(VELOCITY, GAIN) == [0.0, 100.0]
    one.begin().set({GAIN: 5.0})
    assert one.step(0.0) == OK


def test_a_parameter_may_be_at_the_ends_of_its_range(one: Instance) -> None:
    for value in (0.0, 1e6):
        one.set({GAIN: value})
        assert one.get(GAIN) == [value]


def test_a_command_that_is_lost_warns_once(one: Instance) -> None:
    one.begin().set({VELOCITY: math.nan})
    assert one.step(0.0) == WARNING
    assert one.messages == [("logStatusWarning", f"{COMMAND} is not finite at 1e-05 s")]
    assert one.step(1e-5) == OK
    assert len(one.messages) == 1


def test_a_sensor_that_is_lost_warns_and_one_that_never_was_does_not(machine: Path) -> None:
    with Instance(machine) as one:
        one.begin()
        assert math.isnan(one.get("sensors.before")[0])
        assert one.step(0.0) == OK
        one.set({"noise": math.nan})
        assert one.step(1e-3) == WARNING
        assert one.messages == [("logStatusWarning", "sensors.reading is not finite at 0.002 s")]
        one.set({"noise": 0.0})
        assert one.step(2e-3) == WARNING  # of the reading before
        assert one.step(3e-3) == OK


def test_a_machine_that_diverges_is_an_error(machine: Path) -> None:
    with Instance(machine) as one:
        one.begin().set({"plant.growth": 1e200})
        assert one.step(0.0) == OK
        saved = one.save()
        text = refused(one, "step", 1e-3)
        assert text == "plant.velocity diverged: it is no longer finite at 0.002 s"
        assert one.get("plant.velocity") == [math.inf]
        assert "fmi" in refused(one, "set", {"plant.growth": 1.0})
        one.restore(saved)
        one.set({"plant.growth": 1.0})
        assert one.step(1e-3) == OK
        one.slave.freeFMUState(saved)


@pytest.mark.parametrize(
    ("before", "call"),
    [
        ((), "step"),
        ((), "exit"),
        ((), "terminate"),
        (("enter",), "enter"),
        (("enter",), "step"),
        (("enter", "exit"), "enter"),
        (("enter", "exit"), "exit"),
        (("enter", "exit", "terminate"), "step"),
        (("enter", "exit", "terminate"), "set"),
        (("enter", "exit", "terminate"), "terminate"),
    ],
)
def test_calls_out_of_order_are_refused(one: Instance, before: tuple[str, ...], call: str) -> None:
    calls = {
        "enter": one.enter,
        "exit": one.slave.exitInitializationMode,
        "terminate": one.slave.terminate,
        "step": lambda: one.step(0.0),
        "set": lambda: one.set({DEMAND: 0.0}),
    }
    for name in before:
        calls[name]()
    with pytest.raises(FMICallException):
        calls[call]()
    assert "must not be called" in one.messages[0][1]
    one.get(COMMAND)
    one.slave.reset()
    one.begin()


def test_other_guids_names_and_interfaces_are_refused(pi: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    description = fmpy.read_model_description(pi)
    heard: list[str] = []
    monkeypatch.setattr(Instance, "heard", lambda _, __, text: heard.append(text.decode()))
    with pytest.raises(Exception, match="Failed to instantiate"):
        Instance(pi, "")
    description.guid = "other"
    monkeypatch.setattr(fmpy, "read_model_description", lambda _: description)
    with pytest.raises(Exception, match="Failed to instantiate"):
        Instance(pi)
    assert "must not be empty" in heard[0]
    assert "is not that of this FMU" in heard[1]


def test_variables_of_other_types_are_refused(one: Instance) -> None:
    types = (
        ("Integer", "Boolean", "String")
        if one.version is FmiVersion.FMI2
        else ("Int32", "Float32", "Boolean")
    )
    for name in types:
        getattr(one.slave, f"get{name}")([])
        one.messages.clear()
        with pytest.raises(FMICallException):
            getattr(one.slave, f"get{name}")([7])
        assert one.messages == [("logStatusError", f"no variable is of type {name}")]
        one.slave.reset()


def test_what_is_not_provided_says_so(one: Instance) -> None:
    one.begin()
    name = "getRealOutputDerivatives" if one.version is FmiVersion.FMI2 else "getOutputDerivatives"
    with pytest.raises(FMICallException):
        getattr(one.slave, name)([7], [1])
    assert "derivatives of outputs are not provided" in one.messages[0][1]


def test_null_pointers_are_refused(one: Instance) -> None:
    slave = one.slave
    calls = {
        FmiVersion.FMI2: (
            lambda: slave.fmi2GetReal(slave.component, None, 1, None),
            lambda: slave.fmi2SetReal(None, None, 0, None),
            lambda: slave.fmi2GetFMUstate(slave.component, None),
            lambda: slave.fmi2SetFMUstate(slave.component, None),
            lambda: slave.fmi2DoStep(None, 0.0, 1e-5, 0),
        ),
        FmiVersion.FMI3: (
            lambda: slave.fmi3GetFloat64(slave.component, None, 1, None, 1),
            lambda: slave.fmi3SetFloat64(None, None, 0, None, 0),
            lambda: slave.fmi3GetFMUState(slave.component, None),
            lambda: slave.fmi3SetFMUState(slave.component, None),
            lambda: slave.fmi3GetFloat64(slave.component, None, 0, None, 1),
        ),
    }
    for call in calls[one.version]:
        with pytest.raises(FMICallException):
            call()
        slave.reset()


def test_the_state_of_a_step_in_fmi2(pi: Path, version: FmiVersion) -> None:
    if version is FmiVersion.FMI3:
        pytest.skip("FMI 3.0 has no such functions")
    with Instance(pi) as one:
        one.begin()
        one.step(0.0)
        assert one.slave.getRealStatus(2) == 1e-5  # the last successful time
        assert one.slave.getBooleanStatus(3) is False  # not terminated
        with pytest.raises(FMICallException) as caught:
            one.slave.getStringStatus(1)
        assert caught.value.status == 2  # discarded
        assert one.step(1e-5) == OK


# --- a controller answers its inputs at once


def test_outputs_follow_inputs_before_a_step(one: Instance) -> None:
    one.begin()
    replica = Replica()
    for k in range(20):
        before = one.get(COMMAND, INTEGRAL)
        one.set({VELOCITY: 0.1 * k, DEMAND: 0.3})
        answered = one.get(COMMAND, INTEGRAL)
        assert tuple(answered) == replica.step(0.1 * k, 0.3)
        assert answered != before
        assert one.get(COMMAND, INTEGRAL) == answered  # asking changes nothing
        assert one.step(k * 1e-5) == OK
        assert one.get(COMMAND, INTEGRAL) == answered  # until other inputs come


def test_the_last_inputs_before_a_step_count(one: Instance) -> None:
    one.begin()
    for demand in (5.0, -3.0, 0.25):
        one.set({DEMAND: demand})
        answered = one.get(COMMAND, INTEGRAL)
        assert tuple(answered) == Replica().step(0.0, demand)
    one.step(0.0)
    assert one.get(COMMAND, INTEGRAL) == answered


def test_parameters_are_answered_where_inputs_are(one: Instance) -> None:
    one.begin().set({DEMAND: 0.03})
    one.set({GAIN: 7.0})
    assert tuple(one.get(COMMAND, INTEGRAL)) == Replica(7.0).step(0.0, 0.03)


def test_inputs_are_answered_in_the_initialization(one: Instance) -> None:
    one.set({DEMAND: 0.03})
    assert one.get(COMMAND) == [0.0]  # not before it
    one.enter()
    assert tuple(one.get(COMMAND, INTEGRAL)) == Replica().step(0.0, 0.03)
    one.slave.exitInitializationMode()
    assert tuple(one.get(COMMAND, INTEGRAL)) == Replica().step(0.0, 0.03)


def test_answers_stay_after_the_termination(one: Instance) -> None:
    one.begin().set({DEMAND: 0.03})
    answered = one.get(COMMAND, INTEGRAL)
    one.slave.terminate()
    assert one.get(COMMAND, INTEGRAL) == answered


def test_a_restored_state_answers_its_own_inputs(one: Instance) -> None:
    one.begin().set({DEMAND: 0.03})
    answered, saved = one.get(COMMAND, INTEGRAL), one.save()
    one.set({DEMAND: 0.5})
    assert one.get(COMMAND, INTEGRAL) != answered
    one.restore(saved)
    assert one.get(COMMAND, INTEGRAL) == answered


def test_a_machine_answers_with_a_step_alone(machine: Path) -> None:
    with Instance(machine) as one:
        before = one.begin().get("plant.velocity")
        one.set({"noise": 5.0})
        assert one.get("plant.velocity") == before
