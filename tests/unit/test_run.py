"""One loop in, one trajectory out: chunks, decimation, what is recorded, what goes wrong."""

import math
import re
import traceback
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
import xarray as xr

from hydroservo import (
    HydroservoError,
    Loop,
    LoopError,
    ParameterError,
    Simulation,
    ops,
    replace,
    simulate,
)
from hydroservo.block import Block, Field
from hydroservo.controllers import PI
from hydroservo.holds import ZeroOrderHoldState
from hydroservo.references import Step
from hydroservo.runs.results import metrics_of
from hydroservo.runs.run import trace_size, whole
from hydroservo.signals import Demand, Measurement
from hydroservo.testing.examples import example
from hydroservo.valves import Orifice

PATHS = ["plant.velocity", "controller.u", "plant.load_force"]

LOOP = example(Loop, simulation=Simulation(0.05, 1e-4, 1, 1e-3), controller=PI(0.3, 100.0))
EVERY_SAMPLE = replace(LOOP, {"simulation.record_period": 1e-4})


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return simulate(LOOP, record=PATHS)


def trace(result: xr.Dataset) -> np.ndarray:
    return np.column_stack([result[path].values for path in PATHS])


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
        ("plant.speed", "no 'speed' there; the names are velocity, load_force, pos"),
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
    assert whole(ratio) == number


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


class UserState(NamedTuple):
    u: Annotated[float, Field("V", "command")]


class OtherState(NamedTuple):
    voltage: float


class LongState(NamedTuple):
    u: float
    more: float


START = UserState(0.0)


class User(NamedTuple):
    """What a user might write in a file of their own."""

    gain: Annotated[float, Field("V s/m", "gain", "this test")] = 10.0

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(self.gain * (r.value - y.velocity))


class Misspelt(User):
    """A law that reads a parameter it does not have."""

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(self.gian * r.value)  # type: ignore[attr-defined]


def twice(x: float) -> float:
    return 2.0 * x


class Helped(NamedTuple):
    """A law that calls a function of its module, and reads a property."""

    helped: bool = True

    @property
    def gain(self) -> float:
        return 2.0

    def init(self) -> UserState:
        return START

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(twice(r.value))


class Read(Helped):
    """The same, with the property alone."""

    def init(self) -> UserState:
        return START

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(self.gain * r.value)


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (
            Helped(),
            "twice is a function of a module, which compiled code cannot call: make it a method of the block",
        ),
        (Read(), "gain is no field and no method of Read"),
    ],
)
def test_what_compiled_code_cannot_reach_is_said_in_plain_words(law: Block, says: str) -> None:
    with pytest.raises(LoopError, match=f"cannot be compiled: .*{re.escape(says)}"):
        simulate(LOOP._replace(controller=law))


class Odd(NamedTuple):
    """A load, a demand and a supply that return what their roles do not."""

    def force(self, t: float) -> Any:
        return None

    def next_jump(self, t: float) -> float:
        return math.inf

    def at(self, t: float) -> Any:
        return 1.0

    def init(self) -> Any:
        return 0.0

    def deriv(self, s: Any, drawn: float) -> Any:
        return s

    def pressures(self, s: Any) -> Any:
        return START


@pytest.mark.parametrize(
    ("place", "says"),
    [
        ("load", "the load Odd: force returns None; it must return a float ("),
        ("reference", "the reference Odd: at returns 1.0; it must return a Demand ("),
        (
            "supply",
            "the supply Odd: init returns 0.0; it must return the first state, a NamedTuple of floats (",
        ),
    ],
)
def test_what_a_method_must_return_is_said_with_its_file(place: str, says: str) -> None:
    with pytest.raises(LoopError, match=re.escape(says) + r".*test_run.py, line \d+\)$"):
        simulate(LOOP._replace(**{place: Odd()}))


class Short(User):
    """A law that forgot the sample period."""

    def step(self, s: UserState, y: Measurement, r: Demand) -> UserState:  # type: ignore[override]
        return s


def user_with(law: Callable[[Measurement], Any], start: Any) -> Block:
    """A user's controller that starts so and returns this."""

    class Law(NamedTuple):
        def init(self) -> Any:
            return start

        def step(self, s: Any, y: Measurement, r: Demand, dt: float) -> Any:
            return law(y)

    return Law()


def test_a_controller_of_the_users_own_runs() -> None:
    result = simulate(LOOP._replace(controller=User()), strict=True)
    assert result["controller.u"].attrs == {"units": "V", "long_name": "command"}
    assert result.identical(simulate(LOOP._replace(controller=User()), compiled=False))


@pytest.mark.parametrize(
    ("controller", "says"),
    [
        (Misspelt(), "'gian'"),
        (Short(), "takes 4 positional arguments but 5 were given"),
        (user_with(lambda y: UserState(y.temperature), START), "'temperature'"),
        (user_with(lambda _: UserState(gain), START), "'gain' is not defined"),  # noqa: F821
        (user_with(lambda _: UserState(1), START), "state controller.u must be a float (1.0, not 1)"),
        (user_with(lambda _: START, UserState(0)), "state controller.u must be a float (1.0, not 1)"),
        (
            user_with(lambda _: UserState(None), START),
            "step returns UserState(u=None), whose u is no number (",
        ),
        (user_with(lambda _: OtherState(1.0), START), "it must return a UserState, as init does: a step ret"),
        (
            user_with(lambda _: START, OtherState(1.0)),
            "init returns OtherState(voltage=1.0); it must have u (",
        ),
        (user_with(lambda _: LongState(1.0, 2.0), START), "a step returns its state's type"),
        (user_with(lambda _: 1.0, START), "the controller Law: step returns 1.0; it must return a UserState"),
        (user_with(lambda _: None, START), "test_run.py, line "),
    ],
)
@pytest.mark.parametrize("compiled", [True, False])
def test_a_controller_that_does_not_fit_is_told_so_in_one_line(
    controller: Block, says: str, compiled: bool
) -> None:
    with pytest.raises(LoopError) as error:
        simulate(LOOP._replace(controller=controller), compiled=compiled)
    assert says in str(error.value)
    assert "\n" not in str(error.value)


class Lost(NamedTuple):
    """A law whose command overflows once the piston has moved a little."""

    not_a_number: bool = False
    huge: float = 1e300

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        infinity = self.huge * self.huge
        lost = ops.where(self.not_a_number, infinity - infinity, infinity)
        return UserState(ops.where(y.position > 0.0391, lost, 0.1))


def test_a_command_that_is_not_a_number_loses_the_machine() -> None:
    """The sample at which it comes is recorded, the rest is nan."""
    loop = EVERY_SAMPLE._replace(controller=Lost(not_a_number=True), reference=Step(0.0, 0.1, 0.0))
    result = simulate(loop, record=PATHS)
    assert float(result.max_error) < 0.2  # so that it is not the error that tells
    assert bool(result.diverged)
    velocity, command = result["plant.velocity"].values, result["controller.u"].values
    last = int(np.isfinite(velocity).sum()) - 1
    assert 0 < last < velocity.size - 1
    assert np.isnan(velocity[last + 1 :]).all()
    assert np.isfinite(command[:last]).all()
    assert np.isnan(command[last:]).all()


def test_an_infinite_command_is_a_divergence() -> None:
    loop = EVERY_SAMPLE._replace(controller=Lost())
    result = simulate(loop, strict=True)
    assert float(result.control_max) == math.inf
    assert bool(result.diverged)
    assert result.attrs["diverged_by"] == "controller.u"
    before = round(float(result.diverged_at) / loop.simulation.period) + 1
    assert np.isfinite(result["plant.velocity"].values[:before]).all()
    assert result.identical(simulate(loop, compiled=False))


class Stumbling(NamedTuple):
    """A law that raises at its first sample, or once the piston has moved, or calls itself for ever."""

    later: bool = False
    endless: bool = False

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        if self.endless:
            return self.step(s, y, r, dt)
        if not self.later or y.position > 0.0391:
            raise RuntimeError("one\ntwo")
        return UserState(0.1)


class Sketch(NamedTuple):
    """A valve and a plant that lack what a loop asks of them, or stumble over it."""

    gain: float = 1.0
    orifice: Orifice = example(Orifice)
    stroke: float = 1.0

    def init(self) -> ZeroOrderHoldState:
        return ZeroOrderHoldState()

    def opening(self, s: ZeroOrderHoldState, u: float) -> float:
        return u + math.sqrt(-1.0)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"plant": 3}, "plant = 3: must be a block: a NamedTuple with the methods of its role"),
        ({"valve": 3.0}, "valve = 3.0: must be a block: a NamedTuple with the methods of its role"),
        ({"plant": Sketch()}, "the plant Sketch: init returns ZeroOrderHoldState(); it must have velocity ("),
        ({"valve": Sketch()}, "the valve Sketch does not fit this loop: math domain error"),
        (
            {"load": example(Orifice)},
            "the load Orifice does not fit this loop: 'Orifice' object has no attribute",
        ),
    ],
)
def test_what_does_not_fit_is_named(changes: dict[str, object], says: str) -> None:
    with pytest.raises(HydroservoError) as error:
        simulate(EVERY_SAMPLE._replace(**changes), compiled=False)  # type: ignore[arg-type]
    assert str(error.value).startswith(says)


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (
            Stumbling(),
            r"the controller Stumbling does not fit this loop: one\\ntwo \(.*test_run.py, line \d+\)",
        ),
        (
            Stumbling(endless=True),
            "the controller Stumbling does not fit this loop: maximum recursion depth exceeded .*",
        ),
        (Stumbling(later=True), r".*Stumbling stopped: RuntimeError: one\\ntwo \(.*run.py, line \d+\)"),
    ],
)
def test_whatever_a_law_raises_is_one_line(law: Stumbling, says: str) -> None:
    with pytest.raises(LoopError) as error:
        simulate(EVERY_SAMPLE._replace(controller=law), compiled=False)
    assert re.fullmatch(says, str(error.value))
    assert "\n" not in str(error.value)


class Sorting(NamedTuple):
    """A law that plain Python runs and no compiler takes."""

    def init(self) -> UserState:
        return UserState(0.0)

    def least(self, x: float) -> float:
        return sorted({"x": x}.values())[0]

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(self.least(y.velocity))


class Writing(NamedTuple):
    """Another, of which the compiler names no line."""

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(float(f"{y.velocity}"))


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (Sorting(), r"Sorting.least \(.*test_run.py, line \d+\): compiled code has no sorted\(.*\); methods"),
        (Writing(), r"Writing.step \(.*test_run.py, line \d+\): .*; methods call only ops"),
    ],
)
def test_a_law_that_cannot_be_compiled_is_named_with_its_line_and_nothing_of_the_compiler(
    law: Block, says: str
) -> None:
    with pytest.raises(LoopError, match=f"cannot be compiled: {says}") as error:
        simulate(LOOP._replace(controller=law))
    lines = "".join(traceback.format_exception(error.value)).splitlines()
    assert len(lines) < 30
    assert not any("numba" in line for line in lines)
