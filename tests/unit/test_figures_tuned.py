"""The front of a search for gains: what is on it, what is marked, what is left out."""

import math
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from hydroservo.figures.tuned import plot_front
from hydroservo.runs.tuned import TriedValues

FRONT = [(1e-3, 100.0), (4e-3, 10.0), (2e-3, 20.0)]  # error [m] and activity [V]


def tried(error, activity, within=True):
    return TriedValues({"controller.proportional_gain": 1.0}, error, activity, within)


def found(front=FRONT, own=(5e-3, 50.0), best=(1e-3, 100.0), guess=(6e-3, 12.0)):
    points = {"own": own, "best": best, "guess": guess}
    return SimpleNamespace(
        front=[tried(*one) for one in front],
        metric="rms_error",
        tables=[xr.Dataset({"rms_error": ((), 0.0, {"units": "m"})})],
        **{name: one and tried(*one) for name, one in points.items()},
    )


def points(fig):
    """What is drawn, by its label: activities and errors."""
    lines = fig.axes[0].lines
    return {line.get_label(): [tuple(one) for one in np.round(line.get_xydata(), 6)] for line in lines}


def legend(fig):
    return [text.get_text() for text in fig.axes[0].get_legend().get_texts()]


def test_a_front_is_a_stair_of_rising_activity_with_what_is_compared():
    fig = plot_front(found())
    assert points(fig) == {
        "least error": [(10.0, 4.0), (20.0, 2.0), (100.0, 1.0)],  # mm
        "before": [(50.0, 5.0)],
        "first guess": [(12.0, 6.0)],
        "after": [(100.0, 1.0)],
    }
    axis = fig.axes[0]
    assert (
        axis.lines[0].get_drawstyle() == "steps-post"
    )  # at an activity, the error of the last that has less
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("total variation of the command [V]", "rms error [mm]")
    assert (axis.get_xscale(), axis.get_yscale()) == ("log", "log")
    assert legend(fig) == ["least error", "before", "first guess", "after"]


def test_what_is_outside_the_bounds_is_hollow():
    fig = plot_front(found(FRONT, own=(5e-3, 50.0, False)))
    line, before, guess, _ = fig.axes[0].lines
    assert line.get_xydata()[-1].tolist() == [100.0, 1.0]
    assert before.get_markerfacecolor() == "white"
    assert guess.get_markerfacecolor() == guess.get_color()
    assert legend(fig)[-1] == "outside the bounds"


def test_what_diverged_or_is_missing_or_still_is_left_out():
    fig = plot_front(found([*FRONT, (1e-3, 0.0), (math.inf, 1.0)], own=(math.inf, math.inf), guess=None))
    assert list(points(fig)) == ["least error", "after"]
    assert len(points(fig)["least error"]) == len(FRONT)


@pytest.mark.parametrize(
    "front",
    [
        [],
        [(1e-3, 100.0)],
        [(1e-3, 100.0), (1.001e-3, 99.9)],
        [(10.0**-k, 10.0 ** (k - 2)) for k in range(7)],
        [(1e-3 * (1.0 + 60.0 / a), a) for a in np.geomspace(8.0, 400.0, 30).tolist()],
    ],
)
def test_each_axis_holds_all_points_and_has_ticks_that_do_not_overlap(front, tmp_path):
    last = front[-1] if front else (1e-3, 100.0)
    fig = plot_front(found(front, own=last, best=last, guess=None))
    fig.save(tmp_path / "front.png")
    axis = fig.axes[0]
    for line in axis.lines:
        for way, (low, high) in zip(line.get_xydata().T, (axis.get_xlim(), axis.get_ylim()), strict=True):
            assert low < way.min() <= way.max() < high
    for one, low, high in ((axis.xaxis, "x0", "x1"), (axis.yaxis, "y0", "y1")):
        begin, end = sorted(one.get_view_interval())
        texts = [tick.label1 for tick in one.get_major_ticks() if begin <= tick.get_loc() <= end]
        boxes = sorted((text.get_window_extent() for text in texts), key=lambda box: getattr(box, low))
        assert len(boxes) >= 2
        assert all(getattr(a, high) < getattr(b, low) for a, b in pairwise(boxes))


def test_a_search_in_which_everything_diverged_has_empty_axes():
    lost = (math.inf, math.inf)
    fig = plot_front(found([], own=lost, best=lost, guess=lost))
    assert points(fig) == {}
