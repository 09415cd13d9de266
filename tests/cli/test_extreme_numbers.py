"""Numbers that are legal and beyond any machine: a result or one line, and no warning of a library."""

import pytest

from tests.support.commands.runner import SHORT, failed, succeeded

pytestmark = pytest.mark.slow  # it runs and draws

RIG = "rig/1khz-pi-sine"
WIDE = ("--set", "valve.orifice.area_gradient=1e300", "--command", "1e200")
PRESSED = ("--set", "supply.supply_pressure=1e30", "--command", "1")
SINE = "laws/internal-model-sine"


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (("linearize", "axis/pump-controlled", "--command", "1e12"), "has no steady state under 1e+12 V"),
        (
            ("linearize", "axis/pump-controlled", "--load", "1e300"),
            "has no steady state under 0 V",
        ),
        (("linearize", RIG, "--command", "1e12", "--unit", "loop"), "has no operating point under 1e+12 V"),
        (("linearize", "axis/position", "--unit", "loop", *PRESSED), "a number is lost near it"),
        (("bode", RIG, "--linear", "--set", "plant.mass=1e-40"), "answers too strongly within 0.001 s"),
        (("bode", RIG, "--linear", "--set", "plant.bulk_modulus=1e60"), "answers too strongly within"),
        (("bode", "rig/10khz-tsmc-square", "--linear", *WIDE), "has no operating point under 1e+200 V"),
        (("bode", RIG, "--amplitude", "1e-308"), "must be a finite number at least 1e-12 [V]"),
    ],
)
def test_numbers_too_large_for_what_follows_are_refused(words, problem):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hydroservo.cli.options.warn_of_sizes", lambda *_: None)  # the warning of an odd size
        assert problem in failed(*words)


@pytest.mark.parametrize(
    "words",
    [
        ("linearize", "rig/1khz-tsmc-sine", "--command", "1e-308", "--unit", "loop"),
        ("bode", RIG, "--linear", "--set", "controller.integral_gain=1e300"),
        ("audit", RIG, *SHORT, "--set", "load.amplitude=1e300"),
        ("audit", SINE, *SHORT, "--set", "reference.amplitude=1e200"),
    ],
)
def test_numbers_that_stay_finite_give_results(words):
    assert succeeded(*words)


def test_a_response_of_nothing_is_drawn(tmp_path):
    words = ("bode", RIG, "--linear", "--set", "valve.time_constant=1e300", "--out", tmp_path / "bode.png")
    succeeded(*words)
    assert (tmp_path / "bode.png").exists()


def test_a_run_alone_is_drawn_against_its_number(tmp_path):
    out = tmp_path / "run.png"
    succeeded("batch", RIG, "--runs", "1", *SHORT, "--vary", "plant.mass=4..8kg", "--out", out)
    assert out.exists()
