"""One loop in, one trajectory out: chunks, decimation, what is recorded, what is refused."""

import math
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
import xarray as xr

from hydroservo import LoopError, ParameterError, Simulation, replace, simulate
from hydroservo.control.controllers import PI
from hydroservo.runs.results import metrics_of
from hydroservo.runs.trace import instants, trace_size, whole_ratio
from hydroservo.testing.examples import example
from tests.support.runs import EVERY_SAMPLE, LOOP, PATHS, trace


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return simulate(LOOP, record=PATHS)


@pytest.mark.parametrize("chunk", [1, 7, 10, 499, 500, 501, 10_000])
def test_chunks_do_not_change_a_bit(monkeypatch: pytest.MonkeyPatch, run: xr.Dataset, chunk: int) -> None:
    monkeypatch.setattr("hydroservo.runs.run.CHUNK", chunk)
    assert simulate(LOOP, record=PATHS).identical(run)


@pytest.mark.parametrize("stride", [1, 3, 10, 250, 500, 501, 2000])
def test_decimation_picks_rows_and_leaves_metrics_alone(stride: int) -> None:
    full = simulate(EVERY_SAMPLE, record=PATHS)
    thinned = simulate(replace(LOOP, {"simulation.record_period": stride * 1e-4}), record=PATHS)
    assert thinned.time.values == pytest.approx(np.arange(0, 501, stride) * 1e-4, abs=1e-15)
    assert np.array_equal(trace(thinned), trace(full)[::stride])
    assert all(thinned[name].equals(full[name]) for name in metrics_of(full))


def test_instants_are_the_floats_that_a_user_types() -> None:
    assert instants(1001, 1, 1e-3).tolist() == [k / 1000 for k in range(1001)]
    assert instants(401, 3, 2.5e-4).tolist() == [float(f"{0.75 * k:.2f}e-3") for k in range(401)]
    assert instants(4, 2, 1.0 / 3000.0).tolist() == [k * 2 * (1.0 / 3000.0) for k in range(4)]


def test_a_record_period_below_the_sample_period_records_every_sample() -> None:
    assert simulate(replace(LOOP, {"simulation.record_period": 1e-6}), record=PATHS).sizes["time"] == 501


def test_only_what_is_asked_for_is_recorded(run: xr.Dataset) -> None:
    traces = {name for name, variable in run.data_vars.items() if variable.dims == ("time",)}
    assert traces == set(PATHS)
    everything = simulate(LOOP)
    assert np.array_equal(trace(everything), trace(run))
    assert {"plant.position", "controller.integral", "reference.rate", "load.force"} <= set(
        everything.data_vars
    )


def test_nothing_may_be_recorded_and_metrics_still_come(run: xr.Dataset) -> None:
    nothing = simulate(LOOP, record=[])
    assert set(nothing.data_vars) == set(metrics_of(run))
    assert all(nothing[name].equals(run[name]) for name in metrics_of(run))


def test_every_variable_has_unit_and_name() -> None:
    result = simulate(LOOP)
    for variable in (result.time, *result.data_vars.values()):
        assert "units" in variable.attrs
        assert variable.attrs["long_name"], variable.name


def test_attributes_say_what_was_run(run: xr.Dataset) -> None:
    assert set(run.attrs) == {"scenario", "hash", "version", "seed", "diverged_by"}
    other = simulate(replace(LOOP, {"plant.mass": 7.0}), record=PATHS)
    assert other.attrs["hash"] != run.attrs["hash"]


def test_a_whole_number_for_a_parameter_is_the_same_as_a_float() -> None:
    whole_numbers, floats = (
        LOOP._replace(controller=example(PI, *gains)) for gains in ((90, 10), (90.0, 10.0))
    )
    assert simulate(whole_numbers, record=PATHS).identical(simulate(floats, record=PATHS))


def test_threads_do_not_change_a_bit(run: xr.Dataset) -> None:
    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(lambda _: simulate(LOOP, record=PATHS), range(8)))
    assert all(result.identical(run) for result in results)


def test_the_first_row_is_the_start() -> None:
    first = simulate(LOOP).isel(time=0)
    assert float(first["plant.position"]) == 0.039
    assert float(first["plant.velocity"]) == float(first["controller.u"]) == 0.0


@pytest.mark.parametrize(
    ("record", "says"),
    [
        ("plant.speed", "no 'speed' there; the names are velocity, hydraulic_force, pos"),
        ("motor.speed", "no 'motor' there; the names are plant, valve, supply, "),
        ("plant", "not a number but a group; name one number in it"),
        ("plant.velocity.x", "no 'x' there; the names are none: it is a number"),
        ("", "no '' there; the names are plant"),
    ],
)
def test_an_unknown_path_is_refused(record: str, says: str) -> None:
    with pytest.raises(ParameterError) as error:
        simulate(LOOP, record=[record])
    assert error.value.path == "record"
    assert says in str(error.value)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"simulation.period": 3e-4}, "simulation.period = 0.0003: must divide the duration of 0.05 s into"),
        ({"simulation.period": 0.1}, "simulation.period = 0.1: must divide the duration of 0.05 s into"),
        (
            {"simulation.period": 1e-300},
            "simulation.period = 1e-300: must be a finite number at least 1e-12 [s]",
        ),
        (
            {"simulation.period": 5e-324},
            "simulation.period = 5e-324: must be a finite number at least 1e-12 [s]",
        ),
        ({"simulation.duration": 1e300}, "simulation.duration = 1e+300: must be less than 2^51 periods of"),
        ({"simulation.duration": 1e-320}, "simulation.period = 0.0001: must divide the duration"),
        ({"simulation.duration": 2.0**51 * 1e-4}, "must be less than 2^51 periods of 0.0001 s, 2.25e+11 s"),
        ({"simulation.record_period": 1e308}, "must be a whole number of sample periods of 0.0001 s"),
        ({"simulation.record_period": 1.5e-4}, "must be a whole number of sample periods of 0.0001 s"),
        ({"simulation.substeps": 0}, "simulation.substeps = 0: must be a whole number at least 1"),
        ({"plant.mass": -1.0}, "plant.mass = -1.0: must be a finite number above 0 [kg]"),
        ({"controller.proportional_gain": math.nan}, "controller.proportional_gain = nan: must be a finite"),
    ],
)
def test_wrong_parameters_are_refused(changes: dict[str, Any], says: str) -> None:
    with pytest.raises(ParameterError) as error:
        simulate(replace(LOOP, changes))
    assert says in str(error.value)


@pytest.mark.parametrize(
    ("ratio", "number"),
    [(8.0 / 1e-5, 800_000), (0.3 / 0.1, 3), (1.5, None), (0.0, 0), (math.inf, None), (math.nan, None)],
)
def test_whole(ratio: float, number: int | None) -> None:
    assert whole_ratio(ratio) == number


def test_a_large_trace_is_refused_before_it_is_made() -> None:
    large = replace(LOOP, {"simulation": Simulation(1e4, 1e-5, 1, 1e-5)})
    with pytest.raises(LoopError, match=r"would take [\d.]+ GiB; raise simulation.record_period"):
        simulate(large)


def test_trace_size_is_what_the_trace_takes(run: xr.Dataset) -> None:
    assert trace_size(LOOP, PATHS) == trace(run).nbytes + run.time.nbytes


def test_progress_rises_to_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hydroservo.runs.run.CHUNK", 100)
    seen: list[float] = []
    simulate(LOOP, record=PATHS, progress=seen.append)
    assert seen == pytest.approx([100 / 501, 200 / 501, 300 / 501, 400 / 501, 500 / 501, 1.0])


def test_an_interrupt_goes_through_and_leaves_nothing_behind(
    monkeypatch: pytest.MonkeyPatch, run: xr.Dataset
) -> None:
    monkeypatch.setattr("hydroservo.runs.run.CHUNK", 100)
    seen: list[float] = []

    def interrupt(done: float) -> None:
        seen.append(done)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(LOOP, record=PATHS, progress=interrupt)
    assert len(seen) == 1
    assert simulate(LOOP, record=PATHS).identical(run)


def test_a_run_whose_state_overflows_is_a_result() -> None:
    """A period at which the integration itself is unstable: h omega is 11."""
    coarse = replace(LOOP, {"simulation": Simulation(20.0, 1e-2, 1, 1e-2)})
    seen: list[float] = []
    result = simulate(coarse, record=PATHS, strict=True, progress=seen.append)
    assert bool(result.diverged)
    lost = np.isnan(result["plant.velocity"].values)
    first = int(lost.argmax())
    assert 1 < first < lost.size
    assert lost[first:].all()
    assert not lost[:first].any()
    assert seen == []
    assert simulate(coarse, record=PATHS, compiled=False).identical(result)


def test_a_run_that_stays_finite_has_not_diverged(run: xr.Dataset) -> None:
    assert not bool(run.diverged)
    assert np.isfinite(trace(run)).all()
