"""A record that hides what the command does between its samples says so, as do pictures of it."""

import numpy as np
import pytest
import xarray as xr

from hydroservo import HydroservoWarning, Loop, Simulation, simulate
from hydroservo.control.controllers import TSMC
from hydroservo.figures.run import plot_comparison, plot_run
from hydroservo.runs.cautions.run import record_caution, unrecorded_command
from hydroservo.testing.examples import example

PERIOD, STRIDE = 1e-4, 10
SCENARIO = f"""
type = "Loop"
controller = {{ type = "PI" }}
simulation = {{ type = "Simulation", period = {PERIOD} }}
"""


def recorded(command, stride=STRIDE):
    """A run with this command at all samples, of which it recorded some."""
    shown = command[::stride]
    signals = {"controlled.value": 0.0 * shown, "reference.value": 0.0 * shown, "controller.u": shown}
    metrics = {
        "control_total_variation": np.abs(np.diff(command)).sum(),
        "control_rms": np.sqrt(np.mean(command**2)),
        "control_max": np.abs(command).max(),
        "diverged": False,
        "diverged_at": np.nan,
    }
    return xr.Dataset(
        {name: ("time", values) for name, values in signals.items()} | metrics,
        coords={"time": np.arange(shown.size) * stride * PERIOD},
        attrs={"scenario": SCENARIO},
    )


def times(count=10_001):
    return np.arange(count) * PERIOD


def alternating(size=1.0):
    return np.sin(times()) + size * (-1.0) ** np.arange(times().size)


def test_a_command_that_alternates_between_recorded_samples_is_said():
    data = recorded(alternating())
    assert unrecorded_command(data, PERIOD).change == pytest.approx(2.0, rel=1e-3)
    said = record_caution(data, PERIOD)
    assert "changes by 2.00 V a sample" in said
    assert 'simulation.record_period = "0.0001 s"' in said


@pytest.mark.parametrize(
    "command",
    [
        np.sin(times()),
        np.random.default_rng(0).normal(size=times().size),  # looks the same at each rate
        alternating(1e-3),  # thinner than the line
        np.where(times() < 0.5, 0.0, 1.0),
        np.zeros(times().size),
    ],
    ids=["smooth", "noise", "thin", "step", "zero"],
)
def test_a_record_that_shows_it_says_nothing(command):
    assert record_caution(recorded(command), PERIOD) == ""


def test_a_record_of_each_sample_says_nothing():
    assert record_caution(recorded(alternating(), stride=1), PERIOD) == ""


def test_a_run_without_these_metrics_says_nothing():
    assert record_caution(recorded(alternating()).drop_vars("control_rms"), PERIOD) == ""


def notes(fig):
    return [note for axis in fig.axes if (note := axis.get_title(loc="right"))]


def test_a_picture_says_what_it_does_not_show():
    peak = np.sin(times())
    peak[5005] = 1.4
    hidden, peaked, plain = map(recorded, (alternating(), peak, np.sin(times())))
    changes, top = "changes of 2.00 V a sample", "a peak of 1.40 V"
    assert notes(plot_run(plain)) == []
    assert notes(plot_run(hidden)) == [f"between recorded samples, not shown: {changes}"]
    assert notes(plot_run(peaked)) == [f"between recorded samples, not shown: {top}"]
    assert notes(plot_comparison([plain, hidden, peaked], ["a", "b", "c"])) == [
        f"between recorded samples, not shown: {changes} (b), {top} (c)"
    ]
    many = plot_comparison([hidden] * 5, [f"run {i}" for i in range(5)])
    assert notes(many) == ["not all is shown between recorded samples"]


def test_a_limit_cycle_of_the_paper_is_said():
    simulation = Simulation(duration=0.05, period=1e-4, record_period=1e-3)
    loop = example(Loop, simulation=simulation, controller=example(TSMC))
    with pytest.warns(HydroservoWarning) as caught:
        data = simulate(loop, compiled=False)
    assert "the record hides a fast motion" in data.attrs["warning"]
    assert any("the record hides" in str(one.message) for one in caught)
