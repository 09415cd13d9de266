import numpy as np
import pytest

import hydroservo as hs
from hydroservo.core.block import value_at
from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.identification.conclusions import log_remarks
from hydroservo.identification.experiment import experiment, predict_traces
from hydroservo.identification.identify import sought_variations
from hydroservo.identification.log import OUTPUTS, log_of_arrays
from hydroservo.identification.observer import shift_signals, slope_of_shift
from hydroservo.identification.problem_setup import fit_problem
from hydroservo.identification.quality import unfit_reason, whiteness
from hydroservo.identification.regression import long_run_covariance
from hydroservo.identification.search import best_lag
from hydroservo.identification.segments import understand_log
from hydroservo.identification.uncertainty import group_sums
from hydroservo.runs.provenance import scenario_hash
from hydroservo.scenario.load import assemble
from hydroservo.scenario.ranges import as_entries
from tests.support.synthetic_logs import (
    LATE,
    NOISE,
    RANGES,
    SCENARIO,
    SHORT,
    SILENT,
    TOGETHER,
    WRONG,
    exact_log,
    recorded,
)

BRIEF = SHORT | {"simulation.duration": "0.5 s", "reference.period": "0.2 s"}
CERTAIN = ("plant.mass", "valve.time_constant")


@pytest.fixture(scope="module")
def found():
    return hs.identify(SCENARIO, recorded(exact_log(BRIEF), 0), RANGES, changes=BRIEF | WRONG, threads=1)


def test_a_recorded_command_makes_the_machine_do_what_it_did():
    log = log_of_arrays(exact_log(BRIEF), "log")
    loop = hs.load_scenario(SCENARIO, BRIEF)
    (segment,) = understand_log(log).segments
    played = experiment(loop, segment, tuple(RANGES), 3)
    began = {path: np.full(2, log.signals[path.rpartition(".")[2]][0]) for path in played.start}
    shown = predict_traces(played, {"plant.mass": np.array([6.0, 7.0]), **began}, 1)
    places = list(OUTPUTS)
    for name in ("velocity", "hydraulic_force"):
        np.testing.assert_allclose(
            shown[:, places.index(name), 0],
            log.signals[name],
            rtol=0.0,
            atol=1e-9 * np.ptp(log.signals[name]),
        )
    assert np.abs(shown[:, 0, 1] - log.signals["velocity"]).max() > 1e-4


def test_what_is_told_is_found_and_the_rest_is_not_claimed(found):
    truth = hs.load_scenario(SCENARIO, BRIEF)
    for path in CERTAIN:
        one = found.parameters[path]
        assert one.identifiable
        assert one.low < value_at(truth, path) < one.high
        assert one.high - one.low < 0.2 * one.value
    for path in (*TOGETHER, SILENT):
        assert not found.parameters[path].identifiable
    said = "\n".join(found.remarks)
    assert f"{SILENT}: has hardly any influence" in said
    assert f"{TOGETHER[0]}: the logs cannot tell it apart from {TOGETHER[1]}" in said


def test_delay_outliers_and_noise_are_found(found):
    (fit,) = found.logs
    late, unsure = fit.delay
    assert abs(late - 1e-3 * LATE) < 4.0 * unsure < 1e-3
    assert fit.signals["velocity"].noise == pytest.approx(NOISE["velocity"], rel=0.2)
    assert fit.signals["velocity"].whiteness > 1e-3
    assert any("out of line" in line for line in found.remarks)
    assert any("later than of the model" in line for line in found.remarks)


def test_a_signal_of_something_else_is_said(found):
    (fit,) = found.logs
    wrong = fit.signals["velocity"]._replace(explained=0.2, whiteness=0.0, correlation=0.9)
    problem = "the model explains 20 % of its variance; check its unit, its sign and its column"
    assert unfit_reason(wrong, 0.0) == problem
    of_fit = fit._replace(signals={"velocity": wrong._replace(problem=problem)})
    assert f"the model does not fit velocity: {problem}" in list(log_remarks(of_fit))


def test_a_model_fits_where_only_rounding_or_the_sensors_noise_is_left(found):
    good = found.logs[0].signals["velocity"]
    assert found.fits
    assert good.problem == unfit_reason(good, good.noise) == ""
    rounding = good._replace(explained=1.0, whiteness=0.0, correlation=0.9)
    assert unfit_reason(rounding, 0.0) == ""
    assert "is not white noise" in unfit_reason(rounding._replace(explained=1.0 - 1e-7), 0.0)
    assert "rms is left, and its sensor has a noise of" in unfit_reason(good, 0.7 * good.noise)


def test_the_scenario_written_is_the_machine_found(found, tmp_path):
    path = tmp_path / "scenario.toml"
    path.write_text(found.toml(tmp_path), encoding="utf-8")
    again = hs.load_scenario(path)
    assert scenario_hash(again) == scenario_hash(found.loop)
    one = found.parameters["plant.mass"]
    assert value_at(again, "plant.mass") == one.value
    far = hs.load_scenario(path, {"uncertainty.scale": 1.0})
    assert value_at(far, "plant.mass") == pytest.approx(one.value + 0.5 * (one.high - one.low))


def test_only_numbers_of_the_machine_are_sought():
    log = exact_log(BRIEF)
    with pytest.raises(ScenarioError, match="must be of the machine"):
        hs.identify(SCENARIO, log, {"controller.integral_gain": (1.0, 2.0)})
    with pytest.raises(ParameterError, match="must name a number"):
        hs.identify(SCENARIO, log, {})


def test_a_shift_is_exact_for_cubics_and_its_slope_too():
    k = np.arange(50.0)
    values = 1.0 + k - 0.1 * k**2 + 0.003 * k**3
    late = shift_signals(values, 3.3)
    at = k - 3.3
    np.testing.assert_allclose(late[6:], (1.0 + at - 0.1 * at**2 + 0.003 * at**3)[6:], rtol=1e-12)
    assert late[0] == values[0]
    slope = -(1.0 - 0.2 * at + 0.009 * at**2)
    np.testing.assert_allclose(slope_of_shift(values, 3.3)[6:], slope[6:], rtol=1e-3, atol=1e-4)


def test_a_lag_is_told():
    rng = np.random.default_rng(0)
    shown = {"velocity": np.cumsum(rng.normal(size=500))}
    measured = {"velocity": np.concatenate([np.zeros(7), shown["velocity"][:-7]]) + 3.0}
    assert best_lag(measured, shown, {"velocity": 1.0}, -1, 20) == 7


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_the_covariance_of_a_sum_knows_autocorrelation(rho):
    rng = np.random.default_rng(1)
    noise = rng.normal(size=40_000)
    rows = np.empty_like(noise)
    rows[0] = noise[0]
    for k in range(1, noise.size):
        rows[k] = rho * rows[k - 1] + noise[k]
    found = long_run_covariance([rows[:15_000, np.newaxis], rows[15_000:, np.newaxis]])
    assert found[0, 0] / rows.size == pytest.approx(1.0 / (1.0 - rho) ** 2, rel=0.1)


def test_a_signal_measured_more_rarely_has_the_same_part_in_a_sum():
    rng = np.random.default_rng(3)
    rows = np.zeros((20_000, 1))
    for k in range(2, len(rows), 2):
        rows[k] = 0.8 * rows[k - 2] + rng.normal()
    dense = long_run_covariance([rows[::2]])
    np.testing.assert_array_equal(long_run_covariance([group_sums(rows, 2)]), dense)
    assert long_run_covariance([rows])[0, 0] < 0.5 * dense[0, 0]  # zeros between hide what hangs together


def test_arguments_of_constructors_are_sought_from_the_scenarios_own_values():
    assembly = assemble("axis/position")
    varied = sought_variations(assembly, as_entries({"valve.orifice.rated_flow": "-50%..+100%"}))
    time = 1e-3 * np.arange(50)
    log = understand_log(
        log_of_arrays({"time": time, "command": np.sin(time), "position": 0.1 + time}, "log")
    )
    problem = fit_problem(assembly, varied, [], [log], 1)
    own = problem.columns(problem.space.values(problem.usual[np.newaxis, :1]))
    assert own["valve.orifice.area_gradient"] == pytest.approx(assembly.loop.valve.orifice.area_gradient)


def test_whiteness_tells_noise_from_what_is_left_of_a_signal():
    rng = np.random.default_rng(2)
    noise = [rng.normal(size=2000), rng.normal(size=1000)]
    assert whiteness(noise) > 0.01
    assert whiteness([one + 0.3 * np.sin(0.05 * np.arange(one.size)) for one in noise]) < 1e-6
