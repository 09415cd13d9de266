"""One function for the picture of whatever a simulation returned."""

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.testing.examples import example

SHORT = hs.Simulation(duration=0.01)


@pytest.fixture(scope="module")
def run():
    return hs.simulate(example(hs.Loop, SHORT), compiled=False)


def labels(figure):
    return [text.get_text() for text in figure.axes[0].get_legend().get_texts()]


def test_a_run(run):
    assert hs.plot(run).axes[0].get_title("left") == "PI"


def test_several_runs_are_named_by_their_controllers(run):
    tsmc = hs.simulate(example(hs.Loop, SHORT, controller=example(hs.controllers.TSMC)), compiled=False)
    assert {"PI", "TSMC"} <= set(labels(hs.plot([run, tsmc])))
    assert {"PI 1", "PI 2", "TSMC"} <= set(labels(hs.plot([run, run, tsmc])))


def test_several_runs_with_names_of_ones_own(run):
    assert {"before", "after"} <= set(labels(hs.plot({"before": run, "after": run})))


def test_a_table_shows_a_metric_against_what_varied():
    masses = {"plant.mass": np.array([5.0, 6.0, 7.0]), "simulation.seed": np.arange(3)}
    table = hs.simulate_batch(example(hs.Loop, SHORT), masses)
    figure = hs.plot(table, "max_error")
    assert len(figure.axes) == 2  # one number, and the distribution
    with pytest.raises(hs.HydroservoError, match="metric = 'speed': must be one of rms_error, "):
        hs.plot(table, "speed")


def test_a_notebook_shows_it(run):
    assert hs.plot(run)._repr_png_().startswith(b"\x89PNG")
