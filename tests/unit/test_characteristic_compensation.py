"""The inverse of a valve's characteristic against the characteristic, and what it refuses."""

from pathlib import Path

import numpy as np
import pytest

from hydroservo import simulate
from hydroservo.control.controllers import PID, CharacteristicCompensation, Saturation
from hydroservo.core.curve import Curve
from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.scenario import load_scenario

COMMANDS = np.array([-10.0, -7.0, -4.0, -2.0, -1.0, -0.45, 0.0, 0.3, 0.6, 1.5, 3.0, 6.0, 10.0])
FLOWS = 1e-4 * np.array([-6.0, -4.6, -2.3, -0.7, -0.2, 0.0, 0.0, 0.0, 0.1, 0.5, 1.6, 4.9, 8.0])
FULL, THRESHOLD = 10.0, 0.05


def compensation(
    commands=COMMANDS, flows=FLOWS, threshold=THRESHOLD, full=FULL
) -> CharacteristicCompensation:
    curve = Curve.from_samples(commands, flows)
    return CharacteristicCompensation.from_flow(PID(1.0, 0.0), curve, FULL, threshold)


def test_the_flow_goes_with_the_command_of_the_law() -> None:
    inverse, flow = compensation().inverse, Curve.from_samples(COMMANDS, FLOWS)
    for wish in [*np.linspace(-7.4, -0.1, 60), *np.linspace(0.1, 9.9, 60)]:
        assert flow.value(inverse.value(wish)) == pytest.approx(8e-4 * wish / FULL, abs=0.01 * 8e-4)


def test_the_dead_band_is_passed_within_the_threshold() -> None:
    inverse = compensation().inverse
    assert inverse.value(THRESHOLD) == pytest.approx(0.3 + 0.3 * THRESHOLD / 0.125)
    assert inverse.value(-THRESHOLD) == pytest.approx(-0.45 - 0.55 * THRESHOLD / 0.25)
    middle = 0.5 * (inverse.value(THRESHOLD) + inverse.value(-THRESHOLD))
    assert inverse.value(0.0) == pytest.approx(middle, abs=0.01)


def test_without_a_dead_band_the_null_offset_is_put_out() -> None:
    inverse = compensation(np.array([-10.0, 0.5, 10.0]), np.array([-1e-3, 0.0, 1e-3]), threshold=0.0).inverse
    assert inverse.value(0.0) == pytest.approx(0.5)
    between = compensation(np.array([-10.0, 10.0]), np.array([-3e-4, 1e-3]), threshold=0.0).inverse
    assert between.value(0.0) == pytest.approx(-10.0 + 20.0 * 3.0 / 13.0)


def test_a_curve_from_0_is_that_of_both_directions() -> None:
    inverse = compensation(np.array([0.0, 0.4, 10.0]), np.array([0.0, 0.0, 1e-3])).inverse
    assert inverse.value(-5.0) == -inverse.value(5.0)
    assert inverse.value(5.0) > 5.0


def test_the_law_learns_of_its_own_command() -> None:
    loop = load_scenario("axis/position", {"simulation.duration": "0.4 s"})
    inner = loop.controller
    straight = Curve.from_samples([-10.0, 10.0], [-1e-3, 1e-3])
    wrapped = loop._replace(controller=CharacteristicCompensation.from_flow(inner, straight, 10.0))
    np.testing.assert_allclose(
        simulate(wrapped)["plant.position"], simulate(loop)["plant.position"], rtol=0.0, atol=1e-9
    )


@pytest.mark.parametrize(
    ("commands", "flows", "threshold", "said"),
    [
        ([-1.0, 0.0, 1.0], [-1.0, 0.5, 0.4], 0.1, "falls from 0 to 1 V"),
        ([-1.0, 1.0], [0.1, 0.4], 0.1, "must go from below 0 to above 0"),
        ([-1.0, -0.1, 0.1, 1.0], [-1.0, 0.0, 0.0, 1.0], 0.0, "dead band from -0.1 to 0.1 V"),
        ([-1.0, 1.0], [-1.0, 1.0], 10.0, "must be below 10 V"),
        (np.linspace(-1.0, 1.0, 513), np.linspace(-1.0, 1.0, 513), 0.1, "at most 512"),
    ],
)
def test_what_is_refused(commands, flows, threshold, said) -> None:
    with pytest.raises(ParameterError, match=said):
        compensation(np.asarray(commands), np.asarray(flows), threshold)


def test_a_table_of_one_point_or_another_unit_is_refused(tmp_path: Path) -> None:
    for text, said in (
        ("command [V],flow [L/min]\n1,2\n", "flow.csv"),
        ("command [V],flow [bar]\n-1,-2\n1,2\n", "does not convert to"),
    ):
        (tmp_path / "flow.csv").write_text(text)
        with pytest.raises(ScenarioError, match=said):
            load_scenario("axis/position", {"controller": table(tmp_path / "flow.csv")})


def table(file: Path) -> dict[str, object]:
    return {
        "type": "CharacteristicCompensation.from_flow",
        "flow": {"file": str(file), "over": "command", "column": "flow"},
        "full_command": "10 V",
        "threshold": "0.05 V",
        "controller": {"type": "PID", "proportional_gain": "200 V/m", "integral_gain": "0 V/(m s)"},
    }


def test_it_is_a_table_of_a_scenario(tmp_path: Path) -> None:
    rows = "\n".join(f"{u},{60e3 * q}" for u, q in zip(COMMANDS, FLOWS, strict=True))
    (tmp_path / "flow.csv").write_text(f"command [V],flow [L/min]\n{rows}\n")
    law = load_scenario("axis/position", {"controller": table(tmp_path / "flow.csv")}).controller
    expected = compensation().inverse
    assert law.saturation == Saturation()
    np.testing.assert_allclose(law.inverse.knots, expected.knots, rtol=1e-12)
    np.testing.assert_allclose(law.inverse.samples, expected.samples, rtol=1e-9, atol=1e-12)
