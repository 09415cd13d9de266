"""One function for the picture of whatever a simulation returned."""

import math

import numpy as np
import pytest
import xarray as xr

import hydroservo as hs
from hydroservo.audits import Audit, BlockAssumptions
from hydroservo.core.assumptions import above
from hydroservo.figures.style import PALETTE
from hydroservo.limits import Limits
from hydroservo.linear.linearization import Linearization, Quantity
from hydroservo.runs.tuned import TriedValues, Tuned
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


def marks(figure):
    """Where the crosses of a figure are."""
    lines = [line for line in figure.axes[0].get_lines() if line.get_marker() == "x"]
    return np.sort_complex(np.concatenate([line.get_xdata() + 1j * line.get_ydata() for line in lines]))


@pytest.mark.parametrize("unit", ["machine", "loop"])
def test_a_linear_model_is_its_poles(unit):
    model = hs.linearize(hs.load_scenario("rig/1khz-pi-sine"), unit, command=0.1)
    np.testing.assert_allclose(marks(hs.plot(model)), np.sort_complex(model.poles))


def test_poles_that_are_not_stable_stand_out():
    quantity = (Quantity("x", "m"),)
    ones = np.ones((1, 1))
    model = Linearization("machine", quantity, quantity, quantity, 3.0 * ones, ones, ones, 0.0 * ones, 0.0)
    marked = [line for line in hs.plot(model).axes[0].get_lines() if line.get_marker() == "x"]
    assert [line.get_color() for line in marked if len(line.get_xdata())] == [PALETTE[1]]


def test_a_search_is_its_metric_before_and_after(run):
    runs = xr.Dataset({"rms_error": ("run", [1e-3], {"units": "m/s"})}, attrs=run.attrs)
    own = TriedValues({}, math.inf, math.nan, within=True)
    found = Tuned(
        {}, [math.inf, 2e-3], [3e-3, 1e-3], 1e-3, 64, [], [runs, runs], ["$a", "b"], "rms_error", own, own
    )
    axis = hs.plot(found).axes[0]
    dots = [line for line in axis.get_lines() if len(line.get_xdata()) == 1]
    assert [line.get_marker() for line in dots] == [">", "o", "o", "o"]
    assert dots[0].get_xdata() == axis.get_xlim()[1]  # it diverged
    assert [float(line.get_xdata()[0]) for line in dots[1:]] == pytest.approx([3.0, 2.0, 1.0])
    assert axis.get_xlabel() == "rms error [mm/s]"


def test_an_audit_is_drawn_by_its_margins():
    held = above("D_1", "D_1 is above the largest d_L1", 30.0, 15.0, "m/s^2")
    failed = above("D_2", "D_2 is above the largest d_L2", 10.0, 1e6, "N/s")
    untold = above("rest", "it cannot be told", math.nan, math.nan)
    found = Audit(
        (BlockAssumptions("controller", "TSMC", (held, failed, untold)),), False, None, "no steady state"
    )
    (axis,) = hs.plot(found).axes
    dots = [line for line in axis.get_lines() if line.get_marker() in "o<>"]
    assert [(line.get_marker(), line.get_xdata()[0]) for line in dots] == [("o", 2.0), ("<", 1e-3)]
    assert [text.get_text() for text in axis.get_yticklabels()] == [held.meaning, failed.meaning]


def test_limits_are_drawn_beside_the_law(run):
    best = run.assign_attrs(iterations=7, converged=True)
    assert {"law", "causal", "clairvoyant"} <= set(labels(hs.plot(Limits(run, best, best))))
