"""Frequency responses: those measured on the simulation are those of the linear model, with its margins."""

import math

import numpy as np
import pytest
import xarray as xr

from hydroservo import Loop, ParameterError, bode, load_scenario, replace
from hydroservo.control.controlled import Command
from hydroservo.control.controllers import PI, OpenLoop, Saturation
from hydroservo.control.holds import DelayedHold
from hydroservo.figures.bode import plot_bode
from hydroservo.linear import margins
from hydroservo.linear.bode import bode_over
from hydroservo.linear.excitation import ExcitationChirp
from hydroservo.linear.finding import bode_finding
from hydroservo.linear.measurement import measured_margins
from hydroservo.linear.operating_point import operating_point
from hydroservo.linear.system import part_slopes
from hydroservo.linear.view import responses
from hydroservo.show import Mark
from tests.support.brink import at_the_brink

pytestmark = pytest.mark.slow  # it runs and draws

MEASURED = ("machine", "open", "closed", "compliance", "open_compliance")
CLEAN = 0.999  # coherence
DECIBEL = math.log(10.0) / 20.0


def rig(**changes: object) -> Loop:
    return replace(load_scenario("rig/1khz-pi-sine"), changes)


@pytest.fixture(scope="module")
def found() -> xr.Dataset:
    return bode(rig())


def model_at_tones(loop: Loop, data: xr.Dataset) -> dict[str, np.ndarray]:
    point = operating_point(loop, None)
    parts, _, _ = part_slopes(point)
    return dict(responses(point, parts, 2.0 * math.pi * data["tone"].values).curves)


def compare(loop: Loop, data: xr.Dataset) -> None:
    """Within 0.1 dB and 1 degree wherever the coherence is high, which it nearly everywhere is."""
    model = model_at_tones(loop, data)
    for name in MEASURED:
        clean = data[f"{name}_coherence"].values > CLEAN
        assert clean.mean() > 0.8
        ratio = data[f"{name}_measured"].values[clean] / model[name][clean]
        assert np.abs(np.log(np.abs(ratio))).max() < 0.1 * DECIBEL, name
        assert np.abs(np.angle(ratio)).max() < math.radians(1.0), name


def test_measured_and_linear_responses_agree(found: xr.Dataset) -> None:
    compare(rig(), found)


def test_a_chirp_measures_the_same() -> None:
    data = bode(rig(), excitation="chirp")
    compare(rig(), data)
    assert not data.identical(bode(rig()))


def test_a_chirp_has_the_derivatives_that_it_says() -> None:
    chirp = ExcitationChirp(1.3, 5.0, math.log(180.0), 2.0, 0.7)
    step = 1e-6
    for t in np.linspace(0.0005, 3.9, 400).tolist():
        before, after = chirp.at(t - step), chirp.at(t + step)
        here = chirp.at(t)
        assert here.rate == pytest.approx((after.value - before.value) / (2.0 * step), abs=1e-3)
        assert here.second_rate == pytest.approx((after.rate - before.rate) / (2.0 * step), abs=1.0)
    assert chirp.at(0.0) == pytest.approx((0.0, 0.0, chirp.at(2.0).second_rate), abs=1e-9)


def test_a_loop_with_a_computing_delay_agrees_too() -> None:
    loop = rig(hold=DelayedHold(4e-4))
    compare(loop, bode(loop, amplitude=5e-3))


def test_the_open_loop_has_the_margins(found: xr.Dataset) -> None:
    own = margins(rig())
    assert float(found["phase_margin"]) == own.phase_margin
    w = 2.0 * math.pi * found["frequency"].values
    crossover = own.gain_crossovers[-1]
    assert np.interp(crossover, w, np.abs(found["open"])) == pytest.approx(1.0, rel=1e-3)
    np.testing.assert_allclose(found["sensitivity"], 1.0 / (1.0 + found["open"]), rtol=1e-12)
    assert float(np.abs(found["sensitivity"]).max()) == pytest.approx(own.sensitivity_peak, rel=1e-3)


def test_the_bandwidth_is_where_the_closed_loop_falls(found: xr.Dataset) -> None:
    f, closed = found["frequency"].values, found["closed"].values
    at = np.interp(float(found["bandwidth"]), f, np.abs(closed))
    assert at == pytest.approx(math.sqrt(0.5) * abs(closed[0]), rel=1e-3)
    late = np.interp(float(found["bandwidth_90"]), f, np.unwrap(np.angle(closed)))
    assert late == pytest.approx(-0.5 * math.pi, abs=2e-3)


def test_the_bandwidth_is_that_of_the_loop_whatever_the_picture_shows(found: xr.Dataset) -> None:
    narrow = bode(rig(), band=(20.0, 30.0), measure=False)
    assert narrow["frequency"].values[[0, -1]].tolist() == [20.0, 30.0]
    for name in ("bandwidth", "bandwidth_90"):
        assert float(narrow[name]) == pytest.approx(float(found[name]), rel=1e-12)


def test_substeps_that_are_chosen_once_give_what_each_run_would_choose() -> None:
    chosen = bode(rig(**{"simulation.substeps": "auto"}), realisations=2)
    fine = bode(rig(**{"simulation.substeps": 40}), realisations=2)
    for name in MEASURED:
        apart = chosen[f"{name}_measured"].values / fine[f"{name}_measured"].values
        assert np.abs(apart - 1.0).max() < 1e-3, name


def test_the_picture_of_an_unstable_loop_says_so_in_place_of_margins() -> None:
    fig = plot_bode(bode(rig(controller=PI(30.0, 600.0)), measure=False))
    said = [text.get_text() for axis in fig.axes for text in axis.texts]
    assert "unstable for small motions" in said
    assert not any("margin" in one for one in said)


def test_the_held_machine_gives_way_as_its_leakage_does() -> None:
    """dv/dF = 1/(b + A^2/C_tl) for slow motions of a closed valve: the leak is all that lets the oil go."""
    loop = rig()
    data = bode(loop, band=(0.01, 10.0), measure=False)
    plant = operating_point(loop, 0.0).loop.plant
    expected = 1.0 / (plant.damping + plant.piston_area**2 / plant.leakage)
    assert complex(data["open_compliance"][0]) == pytest.approx(expected, rel=1e-3)
    assert abs(complex(data["compliance"][0])) < 1e-2 * expected


def test_noise_takes_the_coherence_away() -> None:
    data = bode(replace(load_scenario("rig/noisy-1khz-pi-sine"), {}), amplitude=1e-4)
    assert float(data["open_coherence"].min()) < 0.5


def test_large_tones_meet_what_is_not_linear(found: xr.Dataset) -> None:
    """A saturated command gives the loop less than its linear gain."""
    loop = rig(controller=PI(3.0, 600.0, saturation=Saturation(0.01)))
    small, large = bode(loop, amplitude=1e-3), bode(loop, amplitude=0.03)
    assert np.abs(large["open_measured"][1]) < 0.8 * np.abs(small["open_measured"][1])
    assert float(large["open_coherence"].min()) < float(small["open_coherence"].min())


def test_a_kink_is_said_and_measured_all_the_same() -> None:
    """The piston creeps at rest, its bristles bent as far as they bear, for the valve leaks to one side."""
    data = bode(load_scenario("cases/stick-slip"), measure=False)
    assert "a valve's hysteresis leaves no slope here" in data.attrs["warning"]
    assert (
        "small motions are unstable under 0 V, but the loop itself oscillates from 11.8 dB"
        in data.attrs["warning"]
    )
    assert math.isnan(data["gain_margin"])


def decibels(factor: xr.DataArray) -> float:
    return 20.0 * math.log10(float(factor))


def test_hysteresis_passes_all_of_the_command_where_it_alone_is_the_kink() -> None:
    """Single runs of axis/force with its gains raised begin to oscillate at 4.25 to 4.5 dB."""
    loop = at_the_brink("axis/force")
    data, smooth = (bode(one, measure=False) for one in (loop, replace(loop, {"valve.hysteresis": 0.0})))
    assert "a valve's hysteresis leaves no slope here" in data.attrs["warning"]
    assert float(data["gain_margin"]) == float(smooth["gain_margin"])
    assert decibels(data["gain_margin"]) == pytest.approx(4.4, abs=0.5)
    assert decibels(data["oscillation_gain"]) == pytest.approx(4.4, abs=0.25)


@pytest.mark.parametrize("scenario", ["axis/position", "axis/pump-controlled"])
def test_no_gain_margin_is_said_that_the_runs_contradict(scenario: str) -> None:
    """28.3 dB of the mean slopes at rest, and 8.22 dB of small motions, where it oscillates from 3.5 dB."""
    data = bode(at_the_brink(scenario), measure=False)
    assert 3.0 < decibels(data["oscillation_gain"]) < 5.1
    assert "but the loop oscillates from 3." in data.attrs["warning"]
    for name in (
        "gain_margin",
        "phase_margin",
        "delay_margin",
        "disk_margin",
        "sensitivity_peak",
        "bandwidth",
    ):
        assert math.isnan(data[name]), name


def test_margins_at_a_kink_are_the_worst_of_those_at_rest_and_while_moving() -> None:
    loop = load_scenario("rig/1khz-pi-square")
    data = bode(loop, measure=False)
    moving = min(
        margins(loop, command=sign * share * 0.2133).gain_margin
        for sign in (-1, 1)
        for share in (0.01, 0.1, 0.5)
    )
    assert "worst under" in data.attrs["warning"]
    assert float(data["gain_margin"]) == pytest.approx(moving, rel=1e-3)
    beyond = decibels(data["oscillation_gain"]) - decibels(data["gain_margin"])
    assert 0.0 <= beyond <= 0.5


def test_a_point_that_is_asked_for_outside_the_overlap_has_its_own_margins() -> None:
    loop = load_scenario("axis/position")
    data, smooth = bode(loop, command=2.4, measure=False), replace(loop, {"valve.hysteresis": 0.0})
    assert float(data["gain_margin"]) == pytest.approx(margins(smooth, command=2.4).gain_margin, rel=1e-9)


def test_measured_margins_are_those_of_the_linear_model(found: xr.Dataset) -> None:
    gain, phase = measured_margins(found)
    assert gain.margin == pytest.approx(float(found["gain_margin"]), rel=0.03)
    assert phase.margin == pytest.approx(float(found["phase_margin"]), rel=0.03)


def test_nothing_is_measured_of_a_crossover_without_coherence(found: xr.Dataset) -> None:
    data = found.assign(open_coherence=found["open_coherence"] * 0.5)
    gain, phase = measured_margins(data)
    assert math.isnan(gain.margin)
    assert math.isnan(phase.margin)
    assert gain.remark.startswith("coherence 0.50 at ")
    assert gain.remark.endswith("Hz; try a larger --amplitude or another --band")


def test_a_loop_that_oscillates_as_it_stands_has_no_margins() -> None:
    data = bode(at_the_brink("axis/crane"), measure=False)
    assert float(data["oscillation_gain"]) == 1.0
    assert not bool(data["stable"])
    assert math.isnan(data["gain_margin"])


def test_the_same_call_gives_the_same_bits(found: xr.Dataset) -> None:
    again = bode(rig())
    assert again.identical(found)


def test_the_picture_shows_lines_and_dots(found: xr.Dataset) -> None:
    fig = plot_bode(found)
    axes = fig.axes
    assert len(axes) == 9
    assert [axis.get_title(loc="left") for axis in axes[:3]] == [
        "(a) open loop",
        "(b) closed loop",
        "(c) compliance",
    ]
    assert all(axis.get_xscale() == "log" for axis in axes)
    shown = axes[0].lines[0]
    np.testing.assert_allclose(shown.get_ydata(), 20.0 * np.log10(np.abs(found["open"])))
    assert axes[0].collections[0].get_offsets().shape == (found.sizes["tone"], 2)


def test_several_points_lie_side_by_side() -> None:
    loops = {mass: rig(**{"plant.mass": mass}) for mass in (4.0, 8.0)}
    data = bode_over(loops, "plant.mass", "kg")
    assert data["point"].values.tolist() == [4.0, 8.0]
    assert float(data["phase_margin"][0]) > float(data["phase_margin"][1])
    assert len(plot_bode(data).axes) == 6
    (table,) = bode_finding(data).tables
    assert [one.heading for one in table.columns] == ["plant.mass", "4 kg", "8 kg", "unit"]
    rows = {str(row[0].value): row[1:3] for row in table.rows}
    assert [cell.value for cell in rows["phase margin"]] == data["phase_margin"].values.tolist()
    assert {cell.unit for cell in rows["phase margin"]} == {"rad"}
    decibels = 20.0 * np.log10(data["gain_margin"].values)
    np.testing.assert_allclose([cell.value for cell in rows["gain margin"]], decibels, rtol=1e-12)


def test_of_an_unstable_loop_there_is_the_linear_model() -> None:
    data = bode(rig(controller=PI(30.0, 600.0)))
    assert not bool(data["stable"])
    assert math.isnan(data["bandwidth"])
    assert "tone" not in data.coords
    assert data.attrs["warning"] == "the loop is unstable here: nothing settles that could be measured"


def test_a_table_names_why_a_margin_is_missing() -> None:
    oscillating = bode(rig(controller=PI(30.0, 600.0)), measure=False)
    for data, why, lead in (
        (oscillating, "oscillates", "The loop oscillates as it stands, so it has no margins."),
        (
            oscillating.assign(oscillation_gain=math.nan),
            "unstable",
            "The loop is unstable for small motions, so it has no margins.",
        ),
    ):
        found = bode_finding(data)
        assert [row[1].value for row in found.tables[0].rows[:5]] == [why] * 5
        assert (str(found.lead[0]), found.lead[0].mark) == (lead, Mark.BAD)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"amplitude": 1e3}, "not measured with 1000 V: the loop "),
        ({"command": 1.0}, "left its stroke, moving at "),
    ],
)
def test_a_loop_that_is_lost_while_it_is_measured_keeps_its_linear_model(
    asked: dict[str, float], said: str
) -> None:
    data = bode(rig(), **asked)
    assert said in data.attrs["warning"]
    assert "open" in data
    assert "open_measured" not in data


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda: bode("rig"), "must be a Loop"),
        (lambda: bode(rig(), band=(1.0, 500.0)), "band = 500.0: must be below Nyquist's frequency, 500 [Hz]"),
        (lambda: bode(rig(), band=(10.0, 1.0)), "must rise from the lowest to the highest"),
        (lambda: bode(rig(), band=(math.nan, 1.0)), "band = nan: must be a finite number above 0 [Hz]"),
        (lambda: bode(rig(), amplitude=0.0), "amplitude = 0.0: must be a finite number at least 1e-12 [V]"),
        (lambda: bode(rig(), periods=0), "periods = 0: must be"),
        (lambda: bode(rig(), excitation="sweep"), "excitation = 'sweep': must be"),
        (lambda: bode(rig(), force=math.nan), "force = nan: must be a finite number [N]"),
        (lambda: bode(rig(controls=Command(), controller=OpenLoop())), "closes no loop here"),
    ],
)
def test_what_has_no_response_says_so_in_one_line(ask, said: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ParameterError) as caught:
        ask()
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
