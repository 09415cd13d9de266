"""Linear models on the command line."""

import json
import math

import numpy as np
import pytest

from tests.support.commands.runner import failed, succeeded

pytestmark = pytest.mark.slow  # it runs and draws

RIG = ("linearize", "rig/1khz-pi-sine")


@pytest.mark.parametrize("unit", ["machine", "controller", "loop"])
def test_linearize_json_holds_the_matrices_and_their_names(unit):
    said = json.loads(succeeded(*RIG, "--unit", unit, "--json"))
    assert {"states", "inputs", "outputs", "A", "B", "C", "D", "poles", "frequencies", "damping"} <= set(said)
    n, m, p = (len(said[what]) for what in ("states", "inputs", "outputs"))
    shapes = [np.array(said[name]).shape for name in "ABCD"]
    assert shapes == [(n, n), (n, m), (p, n), (p, m)]
    assert [len(said["units"][what]) for what in ("states", "inputs", "outputs")] == [n, m, p]
    poles = [complex(*pole) for pole in said["poles"]]
    assert len(poles) == len(said["frequencies"]) == len(said["damping"]) == n
    np.testing.assert_allclose(
        np.sort_complex(poles), np.sort_complex(np.linalg.eigvals(said["A"])), rtol=1e-6, atol=1e-7
    )
    assert (said["period"] is None) == (unit == "machine")


def test_linearize_prints_poles_beside_the_textbook():
    text = succeeded(*RIG, "--command", "100 mV")
    assert "natural frequency [Hz]" in text
    assert "By the textbook's formulas: 189.39 Hz" in text
    assert "From differences" not in text


def test_linearize_says_what_is_not_exact():
    text = succeeded("linearize", "axis/position", "--command", "1")
    assert "Some derivatives come from differences" in text
    assert "valve.speed by command" in text


def test_a_command_a_load_and_an_instant_make_the_point():
    def pole(*options):
        poles = json.loads(succeeded(*RIG, *options, "--json"))["poles"]
        return min(real for real, imaginary in poles if imaginary > 0.0)

    assert pole("--command", "0.1V") == pole("--command", "0.1")
    assert pole("--command", "0.1V", "--load", "0.5kN") != pole("--command", "0.1V")
    assert not math.isclose(pole("--at", "250ms"), pole(), rel_tol=1e-3)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--command", "nan"), "start.command = nan: must be a finite number [V]"),
        (("--command", "3 bar"), "--command = '3 bar': does not convert to V"),
        (("--command", "much"), "--command = 'much': is not a quantity such as '1.5 V'"),
        (("--load", "inf"), "force = inf: must be a finite number [N]"),
        (("--at", "100s"), "time = 100.0: must be a finite number at least 0.002 and at most"),
        (("--at", "0.1s", "--command", "1V"), "is of a run, which has a command and a load of its own"),
        (("--unit", "axle"), "'axle' is not one of 'machine', 'controller', 'loop'"),
        (("--set", "plant.masss=3"), "plant.masss"),
    ],
)
def test_what_cannot_be_linearised_is_one_line(words, said):
    assert said in failed(*RIG, *words)
