"""States of FMUs are saved, restored and serialised, in both versions of FMI."""

from ctypes import byref
from pathlib import Path

import pytest
from fmpy.fmi1 import FMICallException

from hydroservo.export.fmu import FmiVersion
from tests.support.export.fmus import Instance
from tests.support.export.toy_fmu import COMMAND, DEMAND, GAIN, INTEGRAL, refused


def test_a_saved_state_gives_the_same_bits_again(one: Instance, pi: Path) -> None:
    one.begin().set({DEMAND: 0.03, GAIN: 20.0})
    one.step(0.0)
    saved = one.save()
    data = one.slave.serializeFMUState(saved)
    one.step(1e-5)
    expected = one.get(COMMAND, INTEGRAL, "time", GAIN)
    one.set({GAIN: 1.0})
    one.step(2e-5)
    one.restore(saved)
    one.step(1e-5)
    assert one.get(COMMAND, INTEGRAL, "time", GAIN) == expected
    one.slave.freeFMUState(saved)
    assert not saved.value
    with Instance(pi, "other") as other:
        again = other.slave.deserializeFMUState(data)
        other.restore(again)
        other.step(1e-5)
        assert other.get(COMMAND, INTEGRAL, "time", GAIN) == expected
        other.slave.freeFMUState(again)


def test_a_saved_state_can_be_saved_into_again(one: Instance) -> None:
    one.begin().set({DEMAND: 0.03})
    saved = one.save()
    place = saved.value
    one.step(0.0)
    kept = one.get(INTEGRAL)
    save = one.slave.fmi2GetFMUstate if one.version is FmiVersion.FMI2 else one.slave.fmi3GetFMUState
    save(one.slave.component, byref(saved))
    assert saved.value == place
    one.step(1e-5)
    one.restore(saved)
    assert one.get(INTEGRAL) == kept
    one.slave.freeFMUState(saved)


def test_states_of_others_and_damaged_ones_are_refused(one: Instance, machine: Path) -> None:
    one.begin()
    saved = one.save()
    data = one.slave.serializeFMUState(saved)
    one.slave.freeFMUState(saved)
    damaged = data[:40] + b"\xff" + data[41:]
    with Instance(machine) as other:
        theirs = other.save()
        assert "no saved state of this FMU" in refused(one, "restore", theirs)
        other.slave.freeFMUState(theirs)
    for wrong, said in (
        (data[:-1], "no saved"),
        (b"x" + data[1:], "no saved"),
        (damaged, "damaged"),
    ):
        one.messages.clear()
        with pytest.raises(FMICallException):
            one.slave.deserializeFMUState(wrong)
        assert said in one.messages[0][1]
