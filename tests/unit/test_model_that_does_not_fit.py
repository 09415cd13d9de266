"""What is said of a model that does not fit, and of numbers that are uncertain but not sought."""

import math

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.core.block import value_at
from hydroservo.identification.finding import UNFIT, identified_finding
from hydroservo.identification.quality import rounded_noise, whiteness
from hydroservo.identification.result import Identified
from tests.support.synthetic_logs import NOISE, Signals

pytestmark = pytest.mark.slow  # each fits a log

AXIS = "axis/position"
RUN_OF_AXIS = {
    "uncertainty.scale": 0.0,
    "simulation.duration": "2 s",
    "simulation.substeps": 12,
    "load.type": "Constant",
    "plant.start_position": "150 mm",
    "controls.type": "Command",
    "controller.type": "OpenLoop",
    "reference.type": "Multisine",
    "reference.amplitude": "3 V",
    "reference.frequency": "1 Hz",
}
RIG = "rig/1khz-pi-square"
RUN_OF_RIG = {
    "uncertainty.scale": 0.0,
    "simulation.duration": "1 s",
    "simulation.record_period": "1 ms",
    "simulation.substeps": 3,
    "reference.type": "Multisine",
    "reference.amplitude": "60 mm/s",
    "reference.frequency": "1 Hz",
}
NOISE_OF_AXIS = {"position": 2e-6, "pressure_a": 1e4, "pressure_b": 1e4}


def log_of(scenario: str, changes: dict[str, object], noise: dict[str, float]) -> Signals:
    """A log of a scenario with noise."""
    run = hs.simulate(hs.load_scenario(scenario, changes))
    rng = np.random.default_rng(5)
    log = {"time": run.time.values, "command": run["controller.u"].values}
    for name, rms in noise.items():
        log[name] = run[f"plant.{name}"].values + rng.normal(scale=rms, size=run.time.size)
    return log


@pytest.fixture(scope="module")
def without_hysteresis() -> Identified:
    """A model that lacks the hysteresis of the valve, 40 mV."""
    log = log_of(AXIS, RUN_OF_AXIS, NOISE_OF_AXIS)
    sought = {"plant.mechanism.mass": "-40%..+70%", "valve.gain": "-40%..+70%"}
    return hs.identify(AXIS, log, sought, changes=RUN_OF_AXIS | {"valve.hysteresis": "0 mm"}, threads=1)


def test_no_number_of_a_model_that_does_not_fit_is_told(without_hysteresis: Identified) -> None:
    found = without_hysteresis
    assert not found.fits
    assert not any(one.identifiable for one in found.parameters.values())
    assert found.remarks[0] == UNFIT
    assert f"# {UNFIT}" in found.toml()
    assert UNFIT in found._repr_html_()
    (sought, *_) = identified_finding(found).tables
    ends = [cell.value for row in sought.rows for cell in row[2:4]]
    assert len(ends) == 2 * (len(found.parameters) + len(found.uncertain))
    assert all(isinstance(one, float) and math.isnan(one) for one in ends)
    assert "mass" not in found.tables["uncertainty"].get("plant", {})


def test_the_effect_that_is_missing_is_named_with_its_size(without_hysteresis: Identified) -> None:
    first = without_hysteresis.effects[0]
    assert first.name == "valve hysteresis"
    assert first.amount == pytest.approx(0.04, rel=0.1)
    assert any("what is left looks most like valve hysteresis" in line for line in without_hysteresis.remarks)


def test_a_log_with_swapped_pressures_is_refused() -> None:
    log = log_of(AXIS, RUN_OF_AXIS, NOISE_OF_AXIS)
    swapped = log | {"pressure_a": log["pressure_b"], "pressure_b": log["pressure_a"]}
    with pytest.raises(hs.ScenarioError, match=r"^log 1: pressure_a and pressure_b are swapped"):
        hs.identify(AXIS, swapped, {"plant.mechanism.mass": "-40%..+70%"}, changes=RUN_OF_AXIS)


def test_a_number_that_is_off_within_its_uncertainty_moves_no_other() -> None:
    """Damping 8 % off moves the mass by more than its interval where damping is taken for known."""
    log = log_of(RIG, RUN_OF_RIG | {"plant.damping": "54 N s/m"}, NOISE)
    sought = {"plant.mass": "-40%..+70%", "valve.time_constant": "-40%..+70%"}
    found = hs.identify(RIG, log, sought, changes=RUN_OF_RIG, threads=1)
    assert found.fits
    for path, truth in (("plant.mass", 6.0), ("valve.time_constant", 0.01)):
        one = found.parameters[path]
        assert one.identifiable
        assert one.low < truth < one.high
    damping = found.uncertain["plant.damping"]
    assert damping.low < 54.0 < damping.high
    assert value_at(found.loop, "plant.damping") == damping.value


def test_rounding_is_no_sign_of_a_wrong_model() -> None:
    rng = np.random.default_rng(0)
    shown = [np.sin(0.002 * np.arange(3000.0))]
    noisy = [one + 0.0005 * rng.normal(size=one.size) for one in shown]
    step = 0.01
    read = [step * np.round(one / step) for one in noisy]
    left = [one - own for one, own in zip(read, shown, strict=True)]
    size = math.sqrt(float(np.mean(left[0] ** 2)))
    left, measured = [one / size for one in left], [one / size for one in read]
    assert whiteness(left) < 1e-6
    assert whiteness(left, 1, rounded_noise(left, measured, step / size)) > 1e-3
    wrong = [one + 2.0 * np.sin(0.01 * np.arange(one.size)) for one in left]
    assert whiteness(wrong, 1, rounded_noise(wrong, measured, step / size)) < 1e-6
