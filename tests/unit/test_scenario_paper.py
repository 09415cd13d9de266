"""The built-in scenarios reproduce the figures they were written for."""

import pytest

from hydroservo import simulate
from hydroservo.scenario import load_scenario


@pytest.mark.slow
@pytest.mark.parametrize(("law", "rms"), [("pi", 0.266e-3), ("backstepping", 18.1e-3), ("tsmc", 0.240e-3)])
def test_steady_error_on_the_sine(law: str, rms: float) -> None:
    result = simulate(load_scenario(f"paper/sine-{law}"), record=["plant.velocity"])
    assert float(result["steady_rms_error"]) == pytest.approx(rms, rel=0.01)
