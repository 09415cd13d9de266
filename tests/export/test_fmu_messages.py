"""What FMUs say, and when, in both versions of FMI."""

import math
from ctypes import c_char_p
from pathlib import Path

import pytest

from hydroservo.export.fmu import FmiVersion
from tests.support.export.fmus import Instance
from tests.support.export.toy_fmu import OK, VELOCITY, WARNING, refused


def test_messages_are_those_asked_for(pi: Path) -> None:
    with Instance(pi, log=False) as one:
        one.begin().set({VELOCITY: math.nan})
        one.step(0.0)
        assert not one.messages
        one.slave.setDebugLogging(True, ["logStatusError"])
        one.set({VELOCITY: 0.0})
        one.step(1e-5)
        assert not one.messages


def test_errors_are_said_in_any_case(pi: Path) -> None:
    with Instance(pi, log=False) as one:
        assert "99" in refused(one, "get_references", [99])


@pytest.mark.parametrize("on", [True, False])
def test_an_unknown_log_category_warns_and_changes_nothing(one: Instance, on: bool) -> None:
    one.begin()
    one.slave.setDebugLogging(True, ["logStatusWarning", "logStatusError"])
    assert log(one, on, "logStatusError", "%s") == WARNING
    ((category, text),) = one.messages
    assert category == "logStatusWarning"
    assert "a log category is not one of the model description" in text
    assert one.step(0.0) == OK
    one.set({VELOCITY: math.nan})
    assert one.step(1e-5) == WARNING
    assert "is not finite" in one.messages[1][1]
    assert "99" in refused(one, "get_references", [99])


def test_an_unknown_log_category_stays_silent_where_messages_are_off(pi: Path) -> None:
    with Instance(pi, log=False) as one:
        assert log(one, True, "other") == WARNING
        assert not one.messages


def log(one: Instance, on: bool, *categories: str) -> int:
    """The status of a choice of messages."""
    slave = one.slave
    set_logging = slave.fmi2SetDebugLogging if one.version is FmiVersion.FMI2 else slave.fmi3SetDebugLogging
    names = (c_char_p * len(categories))(*(name.encode() for name in categories))
    return int(set_logging(slave.component, on, len(categories), names))
