"""How late a log may be, and what is said of it."""

from types import SimpleNamespace

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.identification.conclusions import delay_remarks
from hydroservo.identification.search import best_lag, remaining_variance
from tests.support.axes import AXIS
from tests.support.commanded_logs import LOADED, fit, moves

pytestmark = pytest.mark.slow  # it runs and draws

LAG = {"valve.time_constant": "5..200 ms"}
BELIEVED = {"valve.time_constant": "50 ms"}


@pytest.fixture(scope="module")
def log():
    return moves(late=60)


def test_a_long_delay_is_told_from_a_lag(log):
    found = fit(log, LAG, BELIEVED)
    assert found.logs[0].delay[0] == pytest.approx(0.3, abs=1e-4)
    assert found.parameters["valve.time_constant"].value == pytest.approx(0.03, rel=2e-2)
    assert not any("an end of" in line for line in found.remarks)


@pytest.mark.parametrize(
    ("delay", "end"), [("0..200 ms", 0.2), ("-100..-20 ms", -0.02), ("0.35..0.5 s", 0.35)]
)
def test_a_delay_at_an_end_of_its_range_is_said(log, delay, end):
    found = fit(log, LAG | {"delay": delay}, BELIEVED)
    assert found.logs[0].delay[0] == pytest.approx(end, rel=1e-2)
    assert any("its delay lies at an end of what is sought" in line for line in found.remarks)
    assert "delay" not in found.parameters


def test_a_range_reaches_beyond_a_tenth_of_the_log():
    short = moves(late=60, samples=400)
    assert fit(short, LAG, BELIEVED).logs[0].delay[0] == pytest.approx(0.2, rel=1e-2)
    assert fit(short, LAG | {"delay": "0..1 s"}, BELIEVED).logs[0].delay[0] == pytest.approx(0.3, abs=1e-3)


def test_each_log_has_a_delay_of_its_own(log):
    other = moves(late=4)
    both = hs.identify(AXIS, [log, other], LAG, changes=LOADED | BELIEVED, threads=1)
    assert [fit.delay[0] for fit in both.logs] == pytest.approx([0.3, 0.02], abs=1e-4)


@pytest.mark.parametrize(("delay", "lines"), [(-1.45, 1), (-1.3, 0), (3.0, 0), (999.95, 1)])
def test_a_delay_of_a_few_samples_is_not_at_the_end_of_a_long_range(delay, lines):
    log = SimpleNamespace(
        delay=(1e-3 * delay, 0.0), understood=SimpleNamespace(segments=[SimpleNamespace(period=1e-3)])
    )
    assert len([*delay_remarks(log, SimpleNamespace(low=-1.5, high=1000.0, scale=1e-3))]) == lines


def test_a_range_of_delays_that_is_none_is_one_line(log):
    with pytest.raises(ParameterError, match=r"delay = 5\.0: must begin below 3\.995 s"):
        fit(log, LAG | {"delay": "5..9 s"})
    with pytest.raises(ScenarioError, match="does not convert to s"):
        fit(log, LAG | {"delay": "5..9 mm"})


@pytest.mark.parametrize("least", [-1, 0, 3])
def test_the_lag_that_leaves_least_is_that_of_all_that_are_tried(least):
    rng = np.random.default_rng(4)
    shown = {"velocity": np.cumsum(rng.normal(size=300)), "position": rng.normal(size=300)}
    measured = {name: np.roll(values, 9) + 5.0 for name, values in shown.items()}
    measured["position"][40:60] = np.nan
    weights = {"velocity": 1.0, "position": 3.0}
    every = [remaining_variance(measured, shown, weights, shift) for shift in range(least, 31)]
    assert best_lag(measured, shown, weights, least, 30) == least + int(np.argmin(every)) == 9


def test_a_motion_to_and_fro_is_not_taken_to_come_a_period_later():
    rng = np.random.default_rng(5)
    shown = np.sin(2.0 * np.pi * np.arange(2000) / 100.0)
    measured = np.concatenate([np.zeros(7), shown[:-7]]) + 0.3 * rng.normal(size=2000)
    assert best_lag({"position": measured}, {"position": shown}, {"position": 1.0}, -1, 200) == 7
