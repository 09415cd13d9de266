import math

import numpy as np
import pytest
import xarray as xr

from hydroservo import HydroservoError
from hydroservo.figures.batch import (
    DOTS,
    MARKS,
    axis_label,
    metric_extent,
    plot_batch,
    resistant_slope,
    spans_decades,
    unit_scale,
)

PATHS = {
    "plant.mass": ("kg", "moving mass m"),
    "plant.leakage": ("m^3/(s Pa)", "total leakage coefficient C_tl"),
    "load.amplitude": ("N", "amplitude"),
    "reference.amplitude": ("m/s", "amplitude"),
    "controller.model.plant.mass": ("kg", "moving mass m"),
    "plant.bulk_modulus": ("Pa", "effective bulk modulus beta_e"),
    "valve.orifice.density": ("kg/m^3", "oil density rho"),
}


def runs_of(count, paths=("plant.mass",), lost=0, error=lambda x, noise: 1e-3 * (2.0 + x + 0.1 * noise)):
    """A table of made-up runs, whose error depends on the first number that varied."""
    rng = np.random.default_rng(0)
    columns = {path: rng.uniform(1.0, 2.0, count) for path in paths}
    first = next(iter(columns.values()), np.zeros(count))
    values = error(first, rng.normal(size=count))
    values[:lost] = math.inf
    about = {path: dict(zip(("units", "long_name"), PATHS[path], strict=True)) for path in paths}
    return xr.Dataset(
        {path: ("run", column, about[path]) for path, column in columns.items()}
        | {
            "rms_error": ("run", values, {"units": "m/s", "long_name": "rms of the velocity error"}),
            "diverged": ("run", np.arange(count) < lost),
        }
    )


def legend(fig):
    return [text.get_text() for text in fig.legends[0].get_texts()]


def test_each_number_has_a_panel_and_the_distribution_stands_beside_them():
    data = runs_of(300, ["plant.mass", "plant.leakage"])
    fig = plot_batch(data, ["plant.mass", "plant.leakage"], "rms_error")
    mass, leakage, beside = fig.axes
    assert mass.get_xlabel() == "moving mass $m$ [kg]"
    assert mass.get_ylabel() == "rms of the velocity\nerror [mm/s]"
    assert leakage.get_ylabel() == ""
    np.testing.assert_array_equal(mass.lines[0].get_xdata(), data["plant.mass"])
    np.testing.assert_array_equal(mass.lines[0].get_ydata(), 1e3 * data["rms_error"])
    assert sum(bar.get_width() for bar in beside.patches) == 300
    assert mass.get_ylim() == leakage.get_ylim() == beside.get_ylim()
    assert legend(fig) == ["300 runs", "median", "5 % and 95 %"]


def trends(fig):
    axis = next(axis for axis in fig.axes if axis.get_xlabel() != "runs")
    return {line.get_linestyle() + str(i): line for i, line in enumerate(axis.lines[-3:])}.values()


def test_the_running_quantiles_follow_the_runs():
    fig = plot_batch(runs_of(2000), ["plant.mass"], "rms_error")
    for line, offset in zip(trends(fig), (-0.1645, 0.0, 0.1645), strict=True):
        x, y = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        np.testing.assert_allclose(y, 2.0 + x + offset, atol=0.06)


def test_a_steep_trend_does_not_widen_the_band():
    fig = plot_batch(runs_of(400, error=lambda x, _: x * 1e-3), ["plant.mass"], "rms_error")
    for line in trends(fig):
        np.testing.assert_allclose(line.get_ydata(), line.get_xdata(), rtol=1e-12)


def error_with_peaks(x, noise):
    return 1e-3 * (x + 1e-3 * noise + 3.0 * (np.arange(x.size) % 100 == 0))


def test_no_line_leaves_the_runs_it_stands_for():
    data = runs_of(500, error=error_with_peaks)
    x, y = data["plant.mass"].values, 1e3 * data["rms_error"].values
    parts = np.array_split(np.argsort(x), 12)
    for line in trends(plot_batch(data, ["plant.mass"], "rms_error")):
        for at, part in zip(line.get_ydata(), parts, strict=True):
            assert y[part].min() <= at <= y[part].max()


@pytest.mark.parametrize("paths", [(), ("plant.mass",)])
def test_quantiles_of_few_runs_are_left_out_and_the_legend_says_so(paths):
    few, enough = (plot_batch(runs_of(count, paths), paths, "rms_error") for count in (39, 40))
    assert legend(few) == ["39 runs; fewer than 40 show no quantiles"]
    assert few.axes[-1].lines[:] == []
    assert legend(enough)[-2:] == ["median", "5 % and 95 %"]
    assert len(enough.axes[-1].lines) == 3


def test_the_outermost_dots_lie_inside_their_panel():
    data = runs_of(20)
    low, high = plot_batch(data, ["plant.mass"], "rms_error").axes[0].get_xlim()
    assert low < data["plant.mass"].min() < data["plant.mass"].max() < high


def test_few_runs_have_no_running_quantiles():
    fig = plot_batch(runs_of(100), ["plant.mass"], "rms_error")
    axis = next(axis for axis in fig.axes if axis.get_xlabel() != "runs")
    assert len(axis.lines) == 1


@pytest.mark.parametrize("count", [DOTS, DOTS + 1])
def test_many_runs_are_counted_in_cells(count):
    fig = plot_batch(runs_of(count), ["plant.mass"], "rms_error")
    cells = [cloud for axis in fig.axes for cloud in axis.collections if cloud.get_array() is not None]
    if count <= DOTS:
        assert cells == []
    else:
        assert cells[0].get_array().sum() == count
        assert fig.axes[-1].get_ylabel() == f"runs in a cell, of {count:,}"


@pytest.mark.parametrize("lost", [3, MARKS + 1])
def test_runs_that_diverged_are_marked_above_and_left_out(lost):
    fig = plot_batch(runs_of(500, lost=lost), ["plant.mass"], "rms_error")
    assert legend(fig)[0] == f"{500 - lost} runs"
    assert legend(fig)[-1] == f"diverged: {lost} of 500"
    axis = next(axis for axis in fig.axes if axis.get_xlabel() != "runs")
    if lost <= MARKS:
        assert axis.lines[-1].get_xdata().size == lost
        assert min(axis.lines[-1].get_ydata()) > 1.0
    else:
        assert axis.collections[0].get_array().max() <= 1.0
    assert axis.get_ylim()[1] < 6.0


@pytest.mark.parametrize("paths", [(), ("plant.mass",)])
@pytest.mark.parametrize(
    "data",
    [
        {"lost": 9},
        {"error": lambda x, _: np.full(x.size, math.nan)},
        {"error": lambda x, _: np.zeros(x.size)},
        {"error": lambda x, _: np.full(x.size, 2e-4)},
    ],
)
def test_runs_that_all_diverged_or_agree_make_a_picture(tmp_path, paths, data):
    fig = plot_batch(runs_of(9, paths, **data), paths, "rms_error")
    assert fig.save(tmp_path / "runs.png", origin="abc").stat().st_size > 1000


def test_a_metric_over_decades_has_a_logarithmic_axis_with_plain_numbers(tmp_path):
    data = runs_of(3000, error=lambda x, _: 10.0 ** (-8.0 + 3.0 * x))
    fig = plot_batch(data, ["plant.mass"], "rms_error")
    fig.save(tmp_path / "runs.png", origin="abc")
    axis = next(axis for axis in fig.axes if axis.get_xlabel().startswith("moving"))
    assert axis.get_yscale() == "log"
    assert {"0.1", "1"} <= {tick.get_text() for tick in axis.get_yticklabels()}


def test_many_numbers_fill_rows_of_three(tmp_path):
    fig = plot_batch(runs_of(50, PATHS), list(PATHS), "rms_error")
    fig.save(tmp_path / "runs.png", origin="abc")
    labels = [axis.get_xlabel().replace("\n", " ") for axis in fig.axes]
    assert len(labels) == len(set(labels)) == 1 + len(PATHS)
    assert {"load: amplitude [N]", "model: moving mass $m$ [kg]"} <= set(labels)
    assert sum(axis.get_ylabel() != "" for axis in fig.axes) == 3
    boxes = [axis.get_window_extent() for axis in fig.axes]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


def test_seeds_alone_show_the_distribution():
    fig = plot_batch(runs_of(200, ()), [], "rms_error")
    (axis,) = fig.axes
    assert axis.get_xlabel() == "rms of the velocity error [mm/s]"
    assert axis.get_ylabel() == "runs"
    assert sum(bar.get_height() for bar in axis.patches) == 200


def test_the_same_runs_always_give_the_same_bytes(tmp_path):
    for ending, start in ((".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")):
        contents = []
        for name in ("one", "other"):
            fig = plot_batch(runs_of(200), ["plant.mass"], "rms_error")
            contents.append(fig.save(tmp_path / f"{name}{ending}", origin="abc").read_bytes())
        assert contents[0] == contents[1]
        assert contents[0].startswith(start)


def test_a_picture_that_cannot_be_written_is_one_line(tmp_path):
    (tmp_path / "runs.png").mkdir()
    fig = plot_batch(runs_of(9), ["plant.mass"], "rms_error")
    with pytest.raises(HydroservoError, match="cannot be written"):
        fig.save(tmp_path / "runs.png", origin="abc")


@pytest.mark.parametrize(
    ("unit", "largest", "expected"),
    [
        ("m^3/(s Pa)", 5e-11, ("10⁻¹² m³/(s Pa)", 1e12)),
        ("Pa", 7e8, ("bar", 1e-5)),
        ("1/s", 2e6, ("10⁶ 1/s", 1e-6)),
        ("", 0.62, ("", 1.0)),
        ("", 6.2e-5, ("10⁻⁶", 1e6)),
        ("kg", 0.0, ("kg", 1.0)),
    ],
)
def test_axes_have_numbers_that_are_neither_tiny_nor_huge(unit, largest, expected):
    label, factor = unit_scale(unit, np.array([0.0, -largest]))
    assert (label, factor) == (expected[0], pytest.approx(expected[1], rel=1e-12))


@pytest.mark.parametrize(
    ("meaning", "unit", "label"),
    [
        ("moving mass m", "kg", "moving mass $m$ [kg]"),
        ("total leakage coefficient C_tl", "m³/(s Pa)", "total leakage coefficient $C_{tl}$ [m³/(s Pa)]"),
        ("effective bulk modulus beta_e", "bar", "effective bulk modulus $\\beta_{e}$ [bar]"),
        ("oil density rho", "kg/m³", "oil density $\\rho$ [kg/m³]"),
        ("gain delta_1 [(m/s)^(1-a1)/s]", "1/s", "gain $\\delta_{1}$ [1/s]"),
        ("exponent a = p/q", "", "exponent a = p/q"),
        ("boundary layer phi_1 on s1", "m/s", "boundary layer $\\phi_{1}$ on s1 [m/s]"),
        ("cost in $_{ and $, by p_s", "V", "cost in \\$_{ and \\$, by $p_{s}$ [V]"),
    ],
)
def test_symbols_in_labels_are_set_as_symbols(meaning, unit, label):
    assert axis_label(meaning, unit, 100) == label


def test_a_label_breaks_between_words_only():
    lines = axis_label("total leakage coefficient C_tl", "10⁻¹² m³/(s Pa)", 12).split("\n")
    assert lines == [
        "total",
        "leakage",
        "coefficient",
        "$C_{tl}$ [10⁻¹² m³/(s Pa)]",
    ]


def test_the_slope_is_that_of_most_runs():
    x = np.sort(np.random.default_rng(1).normal(size=30))
    y = 3.0 * x
    y[3] = 1e3
    assert resistant_slope(x, y) == pytest.approx(3.0, rel=0.15)
    assert abs(np.polyfit(x, y, 1)[0]) > 30.0  # the line of least squares
    assert resistant_slope(np.ones(30), y) == 0.0


def test_a_range_holds_all_runs():
    assert metric_extent(np.array([1.0, 30.0])) == pytest.approx((1.0 / 1.2, 36.0))
    low, high = metric_extent(np.array([1.0, 2.0]))
    assert low < 1.0
    assert high > 2.0
    assert not spans_decades(np.array([0.0, 30.0]))
    assert not spans_decades(np.array([]))


def test_noise_alone_does_not_tilt_a_line():
    """Quantiles of like runs that no trend spreads are quantiles of these very runs."""
    data = runs_of(500, error=lambda _, noise: 1e-3 * (5.0 + noise))
    x, y = data["plant.mass"].values, 1e3 * data["rms_error"].values
    parts = np.array_split(np.argsort(x), 12)
    lines = trends(plot_batch(data, ["plant.mass"], "rms_error"))
    for line, quantile in zip(lines, (0.05, 0.5, 0.95), strict=True):
        np.testing.assert_allclose(line.get_ydata(), [np.quantile(y[part], quantile) for part in parts])
