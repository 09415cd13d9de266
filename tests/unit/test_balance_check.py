"""Logs whose signals contradict each other, in closed form, and logs that only look so."""

import numpy as np
import pytest

from hydroservo.identification.log import read_logs
from hydroservo.identification.log_check import Resistance, balance_problem, pressure_problem
from hydroservo.identification.segments import understand_log

TIME = np.arange(0.0, 20.0, 5e-3)
UNEQUAL, EQUAL = (12e-4, 8e-4), (10e-4, 10e-4)
FRICTION, MASS = 300.0, 200.0


def log(areas, load=0.0, **others):
    """A sine of the position against friction, mass and a load, with a rod side that has a back pressure."""
    w, reach = 2.0 * np.pi * 0.2, 0.05
    v = reach * w * np.cos(w * TIME)
    force = MASS * -reach * w * w * np.sin(w * TIME) + FRICTION * np.sign(v) + 500.0 * v + load
    pressure_b = np.where(v > 0.0, 5e5 + 6e8 * v**2, 60e5 - 6e8 * v**2)
    noise = np.random.default_rng(0).normal(size=(4, TIME.size))
    return {
        "time": TIME,
        "command": 10.0 * v + 1e-3 * noise[0],
        "position": 0.2 + reach * np.sin(w * TIME) + 2e-6 * noise[1],
        "pressure_a": (force + areas[1] * pressure_b) / areas[0] + 1e4 * noise[2],
        "pressure_b": pressure_b + 1e4 * noise[3],
    } | others


def swapped(given):
    return given | {"pressure_a": given["pressure_b"], "pressure_b": given["pressure_a"]}


def backwards(given):
    return given | {"position": 0.4 - given["position"]}


def against(given):
    return given | {"command": -given["command"]}


def without(name):
    return lambda given: {key: row for key, row in given.items() if key != name}


def problem(given, areas, driven=True):
    (read,) = read_logs([given], {}, ("time",))
    return balance_problem(understand_log(read).segments, areas, driven=driven)


@pytest.mark.parametrize("areas", [UNEQUAL, EQUAL])
@pytest.mark.parametrize(
    ("fault", "cause"),
    [
        (lambda given: given, ""),
        (without("command"), ""),
        (swapped, "pressure_a and pressure_b are swapped: as they are, they give a friction of -"),
        (backwards, "position is reversed: the piston moves against command and pressures"),
        (against, "command is reversed: the piston goes in as the command rises"),
    ],
)
def test_the_cause_is_named(areas, fault, cause):
    found = problem(fault(log(areas)), areas)
    assert found.startswith(cause) if cause else not found


def test_without_a_command_unequal_areas_tell_pressures_from_position():
    given = without("command")(log(UNEQUAL))
    assert "pressure_b are swapped: as" in problem(swapped(given), UNEQUAL)
    assert "position is reversed: the piston moves against the press" in problem(backwards(given), UNEQUAL)
    both = problem(swapped(backwards(given)), UNEQUAL)
    assert both == "pressure_a and pressure_b are swapped, and position is reversed"


def test_without_a_command_equal_areas_leave_two_causes():
    given = swapped(without("command")(log(EQUAL)))
    assert "are swapped, or position is reversed: together they give" in problem(given, EQUAL)


def test_a_command_counts_only_where_it_drives():
    assert problem(against(log(UNEQUAL)), UNEQUAL, driven=False) == ""


@pytest.mark.parametrize(
    "load",
    [-4000.0, 4000.0, -4e4 * 0.05 * np.sin(2.0 * np.pi * 0.2 * TIME), 2000.0 * np.sin(3.7 * TIME)],
    ids=["overrunning", "weight", "spring that pushes", "load that no one recorded"],
)
def test_a_load_of_any_sign_is_no_contradiction(load):
    assert problem(log(UNEQUAL, load), UNEQUAL) == ""


def test_a_recorded_load_along_the_motion_is_no_contradiction():
    drives = -1000.0 * np.sign(np.cos(2.0 * np.pi * 0.2 * TIME))
    given = log(UNEQUAL, drives)
    assert "pressure_b are swapped" in problem(given, UNEQUAL) or "reversed" in problem(given, UNEQUAL)
    assert problem(given | {"external_force": drives}, UNEQUAL) == ""


def test_a_velocity_against_the_position_is_said():
    given = log(UNEQUAL)
    given["velocity"] = -np.gradient(given["position"], TIME)
    assert "velocity and position contradict each other" in problem(given, UNEQUAL)


def test_a_piston_at_rest_says_nothing():
    given = log(UNEQUAL)
    still = given | {"position": 0.2 + 1e-6 * np.random.default_rng(1).normal(size=TIME.size)}
    assert problem(still, UNEQUAL) == ""


@pytest.mark.parametrize(
    ("follows", "cause"),
    [
        (-0.9, "velocity is reversed"),
        (0.9, "pressure_a and pressure_b are swapped: as they are"),
        (0.0, "pressure_a and pressure_b are swapped, or velocity is reversed"),
    ],
)
def test_where_both_would_explain_it_the_command_names_the_cause(follows, cause):
    measured = Resistance((-595.0, 20.0), (-80.0, 1.0), swing=2000.0, scatter=900.0)
    exchanged = Resistance((1600.0, 20.0), (40.0, 1.0), swing=2200.0, scatter=800.0)
    assert pressure_problem(measured, exchanged, "velocity", follows).startswith(cause)
