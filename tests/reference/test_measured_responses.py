"""Measured and linear responses of the built-in machines that have a smooth point agree."""

import math
from typing import Any

import numpy as np
import pytest

from hydroservo import ParameterError, bode, load_scenario, replace
from hydroservo.linear.operating_point import operating_point
from hydroservo.linear.system import part_slopes
from hydroservo.linear.view import responses
from tests.support.tiers import mostly

CLEAN = 0.9995  # coherence: of 32 spectra or more a response spreads by 0.02 dB and 0.2 degrees then
LIVELY = {
    "controller.controller.proportional_gain": 1994.0,
    "controller.controller.integral_gain": 9648.5,
    "controller.controller.rate_feedforward": 77.85,
}
MIDDLE = {"plant.start_position": 0.039}  # of the stroke, away from its ends
RESPONSES = ("machine", "open", "closed", "compliance")
SMOOTH: list[tuple[str, dict[str, Any], dict[str, Any]]] = [
    ("rig/10khz-pi-sine", MIDDLE, {"amplitude": 5e-3}),
    ("rig/noisy-1khz-pi-sine", MIDDLE, {"amplitude": 0.01}),
    ("rig/noisy-10khz-pi-sine", MIDDLE, {"amplitude": 0.01}),
    ("rig/encoder-pi-sine", MIDDLE, {"amplitude": 5e-3, "realisations": 32}),
    *(
        (f"laws/{law}-sine", MIDDLE, {"amplitude": 0.01})
        for law in ("pi", "industrial", "adrc-1", "adrc-2", "h-infinity", "lqi", "lq", "internal-model")
    ),
    *(
        (f"laws/{law}-sine", MIDDLE, {"amplitude": 0.01})
        for law in ("backstepping", "linear", "super-twisting")
    ),
    ("laws/pi-square", MIDDLE, {"amplitude": 0.01}),
    ("cases/drift", {}, {"amplitude": 5e-3}),
    ("cases/encoder", MIDDLE, {"amplitude": 5e-3}),
    ("cases/limits", MIDDLE, {"amplitude": 0.01}),
    ("cases/load-step", MIDDLE, {"amplitude": 5e-3, "command": 0.0525}),
    (
        "axis/pump-controlled",
        LIVELY,
        {"amplitude": 0.05, "command": 0.3034, "band": (5.0, 100.0)},
    ),
]
WITHOUT = {  # built-in machines that have none, and what is said of their points
    "laws/adaptive-robust-sine": "has no operating point",  # its law switches at rest
    "laws/rise-sine": "has no operating point",
    "rig/10khz-tsmc-square": "has no operating point",
}
SLIDING = ("axis/position", "axis/position-adrc", "axis/position-lq", "axis/force", "cases/dead-band")


def assert_agree(name: str, changes: dict[str, Any], asked: dict[str, Any]) -> None:
    """Within 0.1 dB and 1 degree wherever the coherence is high, the machine's at a fifth of the tones."""
    loop = replace(load_scenario(name), changes)
    data = bode(loop, **{"realisations": 16, **asked})
    assert "slope" not in data.attrs.get("warning", "")
    point = operating_point(loop, asked.get("command"))
    model = responses(point, part_slopes(point)[0], 2.0 * math.pi * data["tone"].values).curves
    for curve in RESPONSES:
        clean = data[f"{curve}_coherence"].values > CLEAN
        assert curve != "machine" or clean.mean() > 0.2
        ratio = data[f"{curve}_measured"].values[clean] / model[curve][clean]
        decibel, degrees = 20.0 * np.log10(np.abs(ratio)), np.degrees(np.angle(ratio))
        assert np.abs(decibel).max(initial=0.0) < 0.1, curve
        assert np.abs(degrees).max(initial=0.0) < 1.0, curve


def test_the_paper_machine_measures_as_its_linear_model_says() -> None:
    assert_agree("paper/sine-pi", {}, {"amplitude": 2e-3})


@pytest.mark.slow  # a machine each
@pytest.mark.parametrize(("name", "changes", "asked"), SMOOTH, ids=[one[0] for one in SMOOTH])
def test_a_machine_measures_as_its_linear_model_says(
    name: str, changes: dict[str, Any], asked: dict[str, Any]
) -> None:
    assert_agree(name, changes, asked)


@pytest.mark.parametrize(("name", "said"), WITHOUT.items())
def test_a_machine_without_a_point_says_why(name: str, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        bode(load_scenario(name))


@pytest.mark.parametrize("name", mostly(pytest.mark.slow, SLIDING, ["cases/dead-band"]))
def test_a_machine_whose_valve_has_hysteresis_says_that_it_leaves_no_slope(name: str) -> None:
    assert "no slope here" in bode(load_scenario(name), measure=False).attrs["warning"]
