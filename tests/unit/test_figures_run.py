import math
import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import hydroservo
from hydroservo import HydroservoError, Simulation, controllers
from hydroservo.control.controllers import PI, TSMC
from hydroservo.control.loop import Loop
from hydroservo.control.references import Square
from hydroservo.figures.panels import (
    Panel,
    SignalCurve,
    axis_unit,
    beyond_text,
    enlarged_panels,
    length_shown,
    observer_path,
    panel_limits,
    trace_of,
)
from hydroservo.figures.run import distinct_colours, literal_label, plot_comparison, plot_run, unequal_remark
from hydroservo.figures.style import COLOURS, PALETTE, figure, style
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.supplies import IdealSupply, PumpSupply
from hydroservo.runs.run_finding import controller_name
from hydroservo.show.files import write_figure
from hydroservo.testing.examples import example

pytestmark = pytest.mark.slow  # it runs and draws


def short_run(controller, **parts):
    simulation = Simulation(duration=0.02, period=1e-5, record_period=5e-5)
    return hydroservo.simulate(
        example(Loop, simulation=simulation, controller=controller, **parts), compiled=False
    )


@pytest.fixture(scope="module")
def pi():
    return short_run(example(PI))


@pytest.fixture(scope="module")
def tsmc():
    return short_run(example(TSMC))


def labels(fig):
    return [axis.get_ylabel() for axis in fig.axes]


def curve(axis, i):
    return np.asarray(axis.lines[i].get_ydata())


def test_run_without_observer_has_velocity_error_and_command(pi):
    fig = plot_run(pi)
    assert labels(fig) == ["velocity [mm/s]", "error [mm/s]", "command [mV]"]
    velocity, demand = pi["controlled.value"].values, pi["reference.value"].values
    np.testing.assert_array_equal(curve(fig.axes[0], 0), 1e3 * velocity)
    np.testing.assert_array_equal(curve(fig.axes[0], 1), 1e3 * demand)
    np.testing.assert_array_equal(curve(fig.axes[1], 0), 1e3 * (demand - velocity))
    np.testing.assert_array_equal(curve(fig.axes[2], 0), 1e3 * pi["controller.u"].values)
    assert fig.axes[-1].get_xlabel() == "time [ms]"
    assert fig.axes[-1].get_xlim() == pytest.approx((0.0, 20.0))


def test_run_with_observer_shows_both_disturbances_and_estimates(tsmc):
    fig = plot_run(tsmc)
    assert labels(fig)[-2:] == ["$d_{L1}$ [m/s²]", "$d_{L2}$ [N/s]"]
    for i, axis in enumerate(fig.axes[-2:], start=1):
        np.testing.assert_array_equal(curve(axis, 0), tsmc[f"controller.observer.d{i}"].values)
        np.testing.assert_array_equal(curve(axis, 1), tsmc[f"disturbance.d{i}"].values)


@pytest.mark.parametrize(
    "supply", [IdealSupply(40e5), example(PumpSupply)], ids=lambda one: type(one).__name__
)
def test_a_run_with_chambers_shows_their_pressures_and_the_supply_s(supply):
    data = short_run(example(PI), plant=example(Cylinder), supply=supply)
    fig = plot_run(data)
    assert labels(fig) == ["velocity [mm/s]", "error [mm/s]", "command [mV]", "pressure [bar]"]
    line = data["supply.pressure"].values if "supply.pressure" in data else 40e5
    for i, values in enumerate((data["plant.pressure_a"].values, data["plant.pressure_b"].values, line)):
        np.testing.assert_allclose(curve(fig.axes[3], i), 1e-5 * values)
    names = [text.get_text() for text in fig.axes[3].get_legend().get_texts()]
    assert names == ["chamber A", "chamber B", "supply"]
    assert "pressure [bar]" not in labels(plot_run(data.drop_vars("plant.pressure_b")))


def test_pressures_stand_above_the_estimates():
    fig = plot_run(short_run(example(TSMC), plant=example(Cylinder)))
    assert labels(fig)[-3:-1] == ["pressure [bar]", "$d_{L1}$ [m/s²]"]


def test_controllers_have_their_own_colours(pi, tsmc):
    assert plot_run(pi).axes[0].lines[0].get_color() == COLOURS["PI"]
    assert plot_run(tsmc).axes[0].lines[0].get_color() == COLOURS["TSMC"]
    assert controller_name(tsmc) == "TSMC"
    assert set(COLOURS) - {"demand"} <= set(controllers.__all__)


def test_plotting_a_run_imports_no_paper() -> None:
    code = """
import sys
import numpy as np
import xarray as xr
from hydroservo.figures.batch import plot_batch
from hydroservo.figures.run import plot_comparison
from hydroservo.figures.panels import axis_unit
from hydroservo.figures.run import plot_run
names = ("reference.value", "controlled.value", "controller.u")
run = xr.Dataset(
    {**dict.fromkeys(names, ("time", np.arange(4.0))), "diverged": False},
    coords={"time": np.arange(4.0)},
    attrs={"scenario": '[controller]\\ntype = "PI"\\n[simulation]\\nperiod = 1.0\\n'},
)
plot_run(run)
print(*(name for name in sys.modules if name.startswith("hydroservo.papers")))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "\n"


def test_legends_lie_above_their_axes(tsmc, tmp_path):
    fig = plot_run(tsmc)
    write_figure(fig, tmp_path / "run", "abc")  # lays the figure out
    legends = [axis.get_legend() for axis in fig.axes if axis.get_legend()]
    assert len(legends) == 3
    for legend in legends:
        assert legend.get_window_extent().y0 >= legend.axes.get_window_extent().y1 - 1.0


def test_peaks_that_press_a_curve_flat_bring_an_enlarged_panel(pi):
    error = 3e-4 * np.sin(np.linspace(0.0, 50.0, pi["time"].size))
    error[5:10] = 0.06
    peaks = pi.assign({"controlled.value": pi["reference.value"] - error})
    fig = plot_run(peaks)
    assert labels(fig)[1:3] == ["error [mm/s]", "error [mm/s]\n(enlarged)"]
    whole, enlarged = fig.axes[1:3]
    assert whole.get_ylim()[1] > 60.0
    low, high = enlarged.get_ylim()
    assert -0.4 < low < -0.3
    assert 0.3 < high < 0.4
    np.testing.assert_array_equal(curve(enlarged, 0), curve(whole, 0))


def panel(*signals):
    time = np.linspace(0.0, 1.0, signals[0].size)
    return Panel("error", "m/s", [SignalCurve(str(i), time, signal, "k") for i, signal in enumerate(signals)])


def test_an_enlarged_panel_fits_runs_of_like_size_only():
    t = np.linspace(0.0, 1.0, 1001)
    small, twice, huge = np.sin(20 * t), 2.0 * np.sin(20 * t), 100.0 * np.sin(20 * t)
    assert enlarged_panels(panel(small, twice)) == []
    assert enlarged_panels(panel(huge)) == []
    (close,) = enlarged_panels(panel(small, huge, twice))
    assert close.fitted == ["0", "2"]
    low, high = panel_limits(close)
    assert -3.0 < low < -2.0
    assert 2.0 < high < 3.0
    assert enlarged_panels(panel(1e-12 * small, huge)) == []  # rounding is not worth a panel
    assert enlarged_panels(panel(np.full(3, math.nan), np.array([1.0, 2.0, 99.0]))) == []
    assert enlarged_panels(panel(np.zeros(3))) == []


def test_every_curve_is_seen_in_some_panel():
    """Each that is pressed flat, also by a curve that an enlarged panel shows; still ones change nothing."""
    t = np.linspace(0.0, 1.0, 1001)
    sizes = (1.0, 20.0, 400.0, 0.0, 25.0)
    whole = panel(*(size * np.sin(20 * t) for size in sizes))
    wide, close = enlarged_panels(whole)
    assert wide.fitted == ["0", "1", "4"]
    assert 25.0 < panel_limits(wide)[1] < 35.0
    assert close.fitted == ["0"]
    assert 1.0 < panel_limits(close)[1] < 1.5
    assert [beyond_text(one) for one in (whole, wide, close)] == ["", "beyond: 2", "beyond: 1, 2, 4"]


def test_an_enlarged_error_panel_shows_zero(pi):
    error = np.full(pi["time"].size, 3e-4)
    error[5:10] = 0.06
    fig = plot_run(pi.assign({"controlled.value": pi["reference.value"] - error}))
    low, high = fig.axes[2].get_ylim()
    assert low < 0.0
    assert 0.3 < high < 0.4


@pytest.mark.parametrize(
    ("names", "path"),
    [
        (["controller.d1", "controller.d2"], "controller"),
        (["controller.a.d1", "controller.b.d1", "controller.b.d2"], "controller.b"),
        (["controller.a.d1"], ""),
        (["disturbance.d1", "disturbance.d2", "controller.id1", "controller.id2"], ""),
    ],
)
def test_estimates_are_found_by_their_names(names, path):
    assert observer_path(xr.Dataset(dict.fromkeys(names, ("time", np.zeros(2))))) == path


def test_diverged_run_is_shown_until_it_is_lost(pi):
    lost = pi.copy(deep=True)
    lost["controlled.value"][100:] = math.nan
    lost["diverged"] = ((), True)
    trace = trace_of(lost)
    assert trace.time.size == 100
    assert plot_run(lost).axes[0].get_title(loc="left") == "PI, diverged at 0.00495 s"
    assert "PI (diverged)" in legend_of(plot_comparison([pi, lost], ["one", "PI"]))


@given(st.lists(st.floats(width=32), min_size=2, max_size=20))
def test_length_shown_ends_before_the_first_lost_sample(velocity):
    velocity = np.array(velocity)
    size = length_shown(velocity)
    assert 2 <= size <= velocity.size
    assert np.all(np.isfinite(velocity[2:size]))
    assert size in (velocity.size, 2) or not np.isfinite(velocity[size])


def test_a_signal_that_was_not_recorded_is_named(pi):
    with pytest.raises(HydroservoError, match=r"controller\.u, which this run did not record"):
        plot_run(pi.drop_vars("controller.u"))


def legend_of(fig):
    return [text.get_text() for text in fig.axes[0].get_legend().get_texts()]


def test_comparison_overlays_runs_and_draws_a_common_demand_once(pi, tsmc):
    fig = plot_comparison([pi, tsmc], ["one", "other"])
    assert legend_of(fig) == ["one", "other", "demand"]
    assert len(fig.axes[0].lines) == 3
    np.testing.assert_array_equal(curve(fig.axes[0], 1), 1e3 * tsmc["controlled.value"].values)
    widths = [line.get_linewidth() for line in fig.axes[0].lines]
    assert widths == sorted(widths, reverse=True)


def test_comparison_draws_each_demand_that_differs(pi):
    fig = plot_comparison([pi, short_run(example(PI), reference=example(Square))], ["sine", "square"])
    assert len(fig.axes[0].lines) == 4
    assert legend_of(fig).count("demand") == 1


def test_comparison_says_what_else_differs(pi, tsmc):
    assert plot_comparison([pi, tsmc], ["one", "other"]).get_supxlabel() == ""
    other = short_run(example(PI), reference=example(Square))
    assert plot_comparison([pi, other], ["one", "other"]).get_supxlabel() == "unequal conditions: reference"
    assert (
        unequal_remark([f"plant.number_{i}" for i in range(9)] + ["hold"])
        == "unequal conditions in plant, hold"
    )


def test_comparison_of_one_run(pi):
    assert legend_of(plot_comparison([pi], ["one"])) == ["one", "demand"]


def test_runs_have_distinct_colours():
    assert distinct_colours(["TSMC", "PI"]) == [COLOURS["TSMC"], COLOURS["PI"]]
    names = ["PI", "PI", "Mine", "PI"]
    colours = distinct_colours(names)
    assert colours[0] == COLOURS["PI"]
    assert len(set(colours)) == len(colours)
    assert len(distinct_colours(["PI"] * 20)) == 20


def test_labels_are_shown_as_they_are(pi):
    assert literal_label("a$b") == r"a\$b"
    fig = plot_comparison([pi, pi], ["_mine", "$"])
    assert len(fig.axes[0].get_legend().get_texts()) == 3


def test_style_leaves_no_trace():
    before = dict(mpl.rcParams)
    with style():
        assert mpl.rcParams["axes.prop_cycle"].by_key()["color"] == list(PALETTE)
    assert dict(mpl.rcParams) == before


def test_saving_gives_both_formats_and_always_the_same_bytes(pi, tmp_path):
    first = write_figure(plot_run(pi), tmp_path / "a" / "run.1", "abc")
    second = write_figure(plot_run(pi), tmp_path / "b" / "run.1", "abc")
    assert [path.name for path in first] == ["run.1.png", "run.1.svg"]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()
    assert first[0].read_bytes().startswith(b"\x89PNG")
    assert b"<svg" in first[1].read_bytes()
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == ["run.1.png", "run.1.svg"]


@pytest.mark.parametrize(("size", "pixels"), [(20_000, False), (20_001, True)])
def test_only_long_curves_become_pixels_in_an_svg(size, pixels):
    noise = np.random.default_rng(0).normal(size=size)
    names = ("reference.value", "controlled.value", "controller.u")
    data = xr.Dataset(
        {**dict.fromkeys(names, ("time", noise)), "diverged": False},
        coords={"time": np.arange(size) * 1e-3},
        attrs={"scenario": '[controller]\ntype = "PI"\n[simulation]\nperiod = 1e-3\n'},
    )
    lines = [line for axis in plot_run(data).axes for line in axis.lines]
    assert len(lines) == 4
    assert {bool(line.get_rasterized()) for line in lines} == {pixels}


def test_figure_has_the_width_of_a_text_page():
    with style():
        assert tuple(figure(2.0).get_size_inches()) == (6.3, 2.0)


def test_what_chatters_is_drawn_beneath_what_does_not(pi):
    chatter = pi.assign({"controller.u": pi["controller.u"] + 0.01 * (-1.0) ** np.arange(pi["time"].size)})
    for runs in ([pi, chatter], [chatter, pi]):
        command = plot_comparison(runs, ["one", "other"]).axes[-1]
        calm, band = sorted(command.lines, key=lambda line: np.abs(np.diff(line.get_ydata())).sum())
        drawn = sorted(command.lines, key=lambda line: line.get_zorder())
        assert drawn == [band, calm]


def test_the_demand_stays_on_top_of_noise(pi):
    noise = 1e-3 * (-1.0) ** np.arange(pi["time"].size)
    noisy = pi.assign({"controlled.value": pi["controlled.value"] + noise})
    velocity = plot_comparison([pi, noisy], ["a", "b"]).axes[0]
    run, band, demand = (line.get_zorder() for line in velocity.lines)
    assert band < run < demand


def test_a_peak_beyond_a_panel_does_not_make_a_curve_lively(pi):
    signs = (-1.0) ** np.arange(pi["time"].size)
    calm, band = np.full(signs.size, 1e-5), 1e-4 * signs
    calm[5:8] = 0.2, -0.2, 0.2
    runs = [pi.assign({"controlled.value": pi["reference.value"] + error}) for error in (calm, band)]
    enlarged = plot_comparison(runs, ["calm", "band"]).axes[2]
    assert enlarged.lines[0].get_zorder() > enlarged.lines[1].get_zorder()


def test_a_wrapped_law_has_its_name_and_its_colour(pi):
    wrapped = short_run(controllers.Delay(controller=example(PI)))
    fig = plot_run(wrapped)
    assert fig.axes[0].get_title("left").startswith("PI in Delay")
    assert fig.axes[0].lines[0].get_color() == COLOURS["PI"]


def test_powers_of_ten_go_into_the_unit():
    assert axis_unit("m/s", 1e-6) == ("µm/s", 1e6)
    assert axis_unit("m/s^2", 1e-6) == ("10⁻³ m/s²", 1e3)
