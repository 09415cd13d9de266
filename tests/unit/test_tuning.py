"""The search for gains: it finds what a fine grid finds, and counts as it says."""

import math
from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from scipy.stats import qmc

from hydroservo import (
    Aim,
    Field,
    HydroservoError,
    Loop,
    ParameterError,
    Simulation,
    ops,
    replace,
    simulate,
    simulate_batch,
)
from hydroservo.control.controllers import PI, Backstepping
from hydroservo.control.controllers.pi import PIState
from hydroservo.control.metrics import judged_by
from hydroservo.control.monitors import CommandEnergy, IntegralCriteria
from hydroservo.core.block import Block
from hydroservo.core.signals import Demand, Measurement
from hydroservo.runs import objective
from hydroservo.runs.tuned import Tuned
from hydroservo.runs.tuning import latin_hypercube, search_gains
from hydroservo.scenario import load_scenario
from hydroservo.scenario.tuning import tune as bounded_tune
from hydroservo.testing.examples import example

pytestmark = pytest.mark.slow  # each searches

tune = partial(bounded_tune, bounded=False)

GAIN, INTEGRAL = "controller.controller.proportional_gain", "controller.controller.integral_gain"
LAG = "valve.time_constant"
GIVEN = {
    "simulation.duration": "0.1 s",
    "simulation.period": "1 ms",
    "simulation.substeps": 4,
    "simulation.seed": 5,
    "valve.type": "FirstOrderValve",
    "valve.time_constant": "10 ms",
    "sensors.type": "NoisySensors",
    "sensors.velocity_noise": "0.5 mm/s",
    "sensors.hydraulic_force_noise": "5 N",
}


class FragileState(NamedTuple):
    u: Annotated[float, Field("V", "command")]
    controller: PIState


class Fragile(NamedTuple):
    """A PI that has no command any more once the error would cross the stroke in a second."""

    controller: PI = example(PI)

    def init(self) -> FragileState:
        return FragileState(0.0, self.controller.init())

    def step(self, s: FragileState, y: Measurement, r: Demand, dt: float) -> FragileState:
        own = self.controller.step(s.controller, y, r, dt)
        return FragileState(ops.where(ops.absolute(r.value - y.velocity) > 0.078, math.nan, own.u), own)


def fragile(demand: str) -> Loop:
    loop = load_scenario(f"paper/{demand}-pi", GIVEN)
    return loop._replace(controller=Fragile(loop.controller))


SINE, SQUARE = fragile("sine"), fragile("square")
WIDE = {GAIN: (0.3, 300.0)}  # in its upper half the loop diverges


def metric_of(loop: Loop, parameters: dict[str, float], seeds: int = 1, metric: str = "rms_error") -> float:
    """The mean of a metric over single runs."""
    first = loop.simulation.seed
    runs = [replace(loop, parameters | {"simulation.seed": first + i}) for i in range(seeds)]
    return float(np.mean([simulate(run, record=())[metric] for run in runs]))


@pytest.fixture(scope="module")
def both() -> Tuned:
    return tune(Aim([SINE, SQUARE], [1.0, 3.0], seeds=2), WIDE, candidates=128, seed=3)


def test_it_finds_what_a_fine_grid_finds() -> None:
    grid = np.geomspace(0.3, 300.0, 5000)
    runs = simulate_batch(SINE, {GAIN: grid})
    errors = np.where(runs["diverged"], np.inf, runs["rms_error"])
    assert np.isinf(errors).sum() > 1000
    found = tune(Aim([SINE], [1.0]), WIDE, candidates=512)
    assert found.cost == pytest.approx(errors.min(), rel=1e-4)
    assert found.parameters[GAIN] == pytest.approx(grid[errors.argmin()], rel=0.02)  # a flat minimum
    assert found.runs == 512
    assert not found.edges


def test_metrics_are_means_over_seeds_and_their_weighted_geometric_mean(both: Tuned) -> None:
    own = {GAIN: SINE.controller.controller.proportional_gain}
    assert both.before == [math.inf, math.inf]
    assert bool(simulate(replace(SINE, own), record=())["diverged"])
    sine, square = (metric_of(loop, dict(both.parameters), seeds=2) for loop in (SINE, SQUARE))
    assert both.after == pytest.approx([sine, square], rel=1e-9)
    assert both.cost == pytest.approx((sine * square**3) ** 0.25, rel=1e-9)
    assert both.runs == 128 * 2 * 2
    for table in both.tables:
        assert table["simulation.seed"].values.tolist() == [5, 6]
        assert set(judged_by([SINE])) < set(table.data_vars)
        assert table[GAIN].values.tolist() == [both.parameters[GAIN]] * 2


def test_before_is_the_metric_with_each_loops_own_values() -> None:
    loops = [replace(SINE, {GAIN: gain}) for gain in (1.0, 2.0)]
    found = tune(Aim(loops, [1.0, 1.0]), {GAIN: (1.0, 2.0)}, candidates=64)
    assert found.before == pytest.approx([metric_of(loop, {}) for loop in loops], rel=1e-9)


def test_a_heavier_weight_serves_its_loop_more() -> None:
    ranges = {GAIN: (0.3, 30.0), INTEGRAL: (1.0, 1e4)}
    for_sine = tune(Aim([SINE, SQUARE], [1.0, 0.01]), ranges, candidates=256)
    for_square = tune(Aim([SINE, SQUARE], [0.01, 1.0]), ranges, candidates=256)
    assert for_sine.after[0] < for_square.after[0]
    assert for_sine.after[1] > for_square.after[1]
    doubled = tune(Aim([SINE, SQUARE], [2.0, 0.02]), ranges, candidates=256)
    assert doubled.parameters == for_sine.parameters


@pytest.mark.parametrize("threads", [1, 3])
def test_the_same_seed_finds_the_same_bits_on_any_number_of_threads(both: Tuned, threads: int) -> None:
    aim = Aim([SINE, SQUARE], [1.0, 3.0], seeds=2)
    again = tune(aim, WIDE, candidates=128, seed=3, threads=threads)
    unlike = {"tables": (), "own": None}  # whose activity is nan, which is not itself
    assert again._replace(**unlike) == both._replace(**unlike)


def test_another_seed_searches_elsewhere(both: Tuned) -> None:
    other = tune(Aim([SINE, SQUARE], [1.0, 3.0], seeds=2), WIDE, candidates=128, seed=4)
    assert other.parameters != both.parameters
    assert other.cost == pytest.approx(both.cost, rel=0.01)


def test_no_weight_makes_up_for_a_run_that_diverges() -> None:
    slow = replace(SINE, {LAG: 0.1})
    best_alone = tune(Aim([slow], [1.0]), WIDE, candidates=256).parameters
    assert bool(simulate(replace(SINE, best_alone), record=())["diverged"])
    found = tune(Aim([SINE, slow], [1e-6, 1.0]), WIDE, candidates=256)
    assert not any(table["diverged"].any() for table in found.tables)
    assert max(found.after) < 0.03


def test_nothing_but_divergence_is_said() -> None:
    with pytest.raises(HydroservoError, match="with each of 128 candidates some run diverged") as caught:
        tune(Aim([SINE], [1.0]), {GAIN: (200.0, 300.0)}, candidates=128)
    assert not isinstance(caught.value, ParameterError)


def test_progress_tells_the_best_so_far() -> None:
    seen: list[tuple[float, float]] = []
    found = tune(
        Aim([SINE, SQUARE], [1.0, 1.0]), WIDE, candidates=256, progress=lambda *told: seen.append(told)
    )
    fractions, best = zip(*seen, strict=True)
    assert fractions == (0.25, 0.5, 0.75, 1.0)
    assert list(best) == sorted(best, reverse=True)
    assert best[-1] == pytest.approx(found.cost, rel=1e-3)  # before its rounding


def test_an_interrupt_leaves_the_best_so_far() -> None:
    def interrupt(fraction: float, _best: float) -> None:
        if fraction == 0.5:
            raise KeyboardInterrupt

    found = tune(Aim([SINE], [1.0]), WIDE, candidates=256, progress=interrupt)
    assert found.interrupted
    assert found.runs == 128
    assert found.after == tune(Aim([SINE], [1.0]), WIDE, candidates=128).after or found.after < found.before


class Strict:
    """Bounds that only a closer look sees, beyond which all of the best candidates lie."""

    def __init__(self, most: float) -> None:
        self.most = most

    def violations(self, candidates: Mapping[str, Any]) -> Any:
        return np.zeros(candidates[GAIN].size)

    def objections(self, parameters: Mapping[str, float]) -> list[str]:
        return [] if parameters.get(GAIN, 0.0) <= self.most else ["too much"]


@pytest.mark.parametrize("dimensions", [0, 1, 7])
def test_first_candidates_are_those_of_scipys_latin_hypercube(dimensions: int) -> None:
    """To the bit, for what a seed finds begins with them."""
    expected = qmc.LatinHypercube(dimensions, rng=np.random.default_rng(5)).random(63)
    np.testing.assert_array_equal(latin_hypercube(63, dimensions, 5), expected)


def test_candidates_far_from_the_best_are_looked_at_too() -> None:
    """The least error has a gain of about 6, around which hundreds of candidates lie."""
    search = (Aim([SINE], [1.0]), {GAIN: (0.3, 30.0)}, 1024, 0, None, None)
    assert search_gains(*search, Strict(4.0)).parameters[GAIN] <= 4.0
    with pytest.raises(HydroservoError, match=r"keeps the bounds at a closer look\. Nearest is .*: too much"):
        search_gains(*search, Strict(0.0))


def test_an_interrupt_before_anything_is_found_is_one() -> None:
    def interrupt(_fraction: float, _best: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):  # with each candidate some run diverges
        tune(Aim([SINE], [1.0]), {GAIN: (200.0, 300.0)}, progress=interrupt)


@pytest.mark.parametrize(("wanted", "tried"), [(1, 64), (64, 64), (65, 128), (300, 320)])
def test_candidates_are_rounded_up_to_whole_generations(wanted: int, tried: int) -> None:
    assert tune(Aim([SINE], [1.0]), WIDE, candidates=wanted).runs == tried


def test_a_parameter_that_changes_nothing_does_not_end_the_search() -> None:
    idle = {"controller.controller.anti_windup": (1.0, 2.0)}  # the command is never limited
    calm = replace(SINE, {GAIN: 3.0})
    found = tune(Aim([calm], [1.0]), idle, candidates=256)
    assert found.runs == 256
    assert found.after == pytest.approx(found.before, rel=1e-9)


def test_a_metric_that_is_0_with_all_candidates_is_refused() -> None:
    calm = {GAIN: (1.0, 2.0)}
    assert metric_of(SINE, {GAIN: 1.5}, metric="overshoot") == 0.0  # its demand has no jump
    with pytest.raises(ParameterError, match=r"^metric = 'overshoot': is 0 with each of 128 candidates, "):
        tune(Aim([SINE], [1.0], "overshoot"), calm, candidates=128)


def test_a_metric_that_is_0_with_some_candidates_is_no_trouble() -> None:
    """A share of time at a limit, which small gains do not reach."""
    share = {"power": CommandEnergy(limit=1.0)}
    ends = {GAIN: (1.0, 100.0)}
    least, most = (
        float(simulate(replace(SINE, {GAIN: gain}), metrics=share)["saturation_share"]) for gain in ends[GAIN]
    )
    assert least == 0.0 < most
    found = tune(Aim([SINE], [1.0], "saturation_share", metrics=share), ends, candidates=64)
    assert found.after == [0.0]
    assert found.cost < 1e-20


def test_values_at_an_end_are_said_to_be_there() -> None:
    low, high = (tune(Aim([SINE], [1.0]), {GAIN: ends}, candidates=256) for ends in ((0.3, 1.0), (6.0, 8.0)))
    assert list(low.edges) == list(high.edges) == [GAIN]
    assert (low.parameters[GAIN], high.parameters[GAIN]) == pytest.approx((1.0, 6.0), rel=0.02)
    one = tune(Aim([SINE], [1.0]), {GAIN: (0.3, 30.0), INTEGRAL: (1.0, 20.0)}, candidates=1024)
    assert list(one.edges) == [INTEGRAL]


def test_what_a_law_believes_can_be_searched() -> None:
    """Of a loop from Python too, whose law is given its model before a run."""
    mass = "controller.model.plant.mass"
    loop = example(Loop, Simulation(0.02, 1e-3, 20), controller=Backstepping(500.0, 500.0))
    found = tune(Aim([loop]), {mass: (2.0, 20.0)}, candidates=64)
    assert 2.0 < found.parameters[mass] < 20.0
    assert found.after < found.before
    assert found.before == pytest.approx([metric_of(loop, {})], rel=1e-9)


def test_what_is_found_has_five_digits_and_stays_in_its_range(both: Tuned) -> None:
    assert both.parameters[GAIN] == float(f"{both.parameters[GAIN]:.5g}")
    narrow = (1.2345678, 1.2345679)
    found = tune(Aim([SINE], [1.0]), {GAIN: narrow}, candidates=64)
    assert narrow[0] <= found.parameters[GAIN] <= narrow[1]


@pytest.fixture
def tried(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The columns of all batches that a search simulates."""
    seen: list[Any] = []

    def spy(loop: Loop, columns: Any, **options: Any) -> Any:
        seen.append(columns)
        return simulate_batch(loop, columns, **options)

    monkeypatch.setattr(objective, "simulate_batch", spy)
    return seen


@pytest.mark.parametrize(
    ("path", "low", "high", "logarithmic"),
    [
        (GAIN, 0.3, 30.0, True),
        (GAIN, 0.0, 30.0, False),
        ("load.offset", -50.0, 100.0, False),
        ("load.offset", -50.0, 0.0, False),
        ("load.offset", -50.0, -0.5, True),
    ],
)
def test_ranges_that_hold_0_are_searched_evenly_others_in_their_logarithm(
    tried: list[Any], path: str, low: float, high: float, logarithmic: bool
) -> None:
    tune(Aim([replace(SINE, {GAIN: 1.0})], [1.0]), {path: (low, high)}, candidates=64)
    values = tried[1][path]  # of the first generation, after the loop's own value
    share = np.log(values / low) / np.log(high / low) if logarithmic else (values - low) / (high - low)
    assert sorted(np.floor(64.0 * share)) == list(range(64))  # a Latin hypercube: one in each part


def test_each_candidate_meets_each_seed(tried: list[Any]) -> None:
    tune(Aim([SINE], [1.0], seeds=3), WIDE, candidates=64)
    first = tried[1]
    assert first["simulation.seed"].tolist() == [5, 6, 7] * 64
    assert [*map(len, map(set, first[GAIN].reshape(64, 3)))] == [1] * 64
    assert len(set(first[GAIN])) == 64


class ComputedState(NamedTuple):
    u: Annotated[float, Field("V", "command")]


class Computed(NamedTuple):
    """A proportional law whose gain is computed before a run, and only for moderate wishes."""

    wish: Annotated[float, Field("V s/m", "wish", above=0)] = 1.0
    gain: Annotated[float, Field("V s/m", "gain", derived=True)] = 0.0

    def init(self) -> ComputedState:
        return ComputedState(0.0)

    def step(self, s: ComputedState, y: Measurement, r: Demand, dt: float) -> ComputedState:
        return ComputedState(self.gain * (r.value - y.velocity))

    def designed(self, model: Block, period: float) -> "Computed":
        if self.wish > 2.0:
            raise ParameterError("Computed", self.wish, "is too much")
        return self._replace(gain=self.wish)


def test_candidates_that_allow_no_controller_do_not_win_and_do_not_end_the_search() -> None:
    loop = replace(SINE, {"controller": Computed()})
    found = tune(Aim([loop], [1.0]), {"controller.wish": (0.1, 10.0)}, candidates=128)
    assert found.runs == 128
    assert found.parameters["controller.wish"] == pytest.approx(2.0, rel=0.05)  # more is better, 2 the most
    assert found.parameters["controller.wish"] <= 2.0
    with pytest.raises(ParameterError, match="is too much"):
        tune(Aim([loop], [1.0]), {"controller.wish": (3.0, 10.0)}, candidates=64)


def test_an_aim_takes_monitors_that_its_loops_do_not_have() -> None:
    ranges: dict[str, tuple[float, float]] = {GAIN: (0.3, 30.0)}
    aim = Aim([SINE], metric="iae", metrics=[IntegralCriteria()])
    found = tune(aim, ranges, candidates=64)
    best = replace(SINE, found.parameters)
    assert found.after == [simulate(best, record=(), metrics=[IntegralCriteria()])["iae"].item()]
    with pytest.raises(ParameterError, match="metric = 'iae': must be one of rms_error, "):
        tune(aim._replace(metrics=None), ranges)
    with pytest.raises(ParameterError, match="metrics = 3: must be a list of monitors"):
        tune(aim._replace(metrics=3), ranges)  # type: ignore[arg-type]


def test_a_metric_that_a_loop_does_not_have_is_refused() -> None:
    with pytest.raises(ParameterError, match="metric = 'estimate_rms_error_1': must be one of rms_error, "):
        tune(Aim([SINE, SQUARE], [1.0, 1.0], "estimate_rms_error_1"), {GAIN: (1.0, 2.0)})


@pytest.mark.parametrize(
    ("aim", "ranges", "message"),
    [
        (Aim([SINE], [1.0], "rms"), WIDE, "metric = 'rms': must be one of rms_error, max_error, "),
        (Aim([SINE], [1.0], "diverged"), WIDE, "metric = 'diverged': must be one of"),
        (Aim([SINE], [1.0], "position_min"), WIDE, "metric = 'position_min': must be one of"),
        (Aim([], []), WIDE, "loops = .*: must be at least one"),
        (Aim([SINE], [1.0, 2.0]), WIDE, r"weights = \[1.0, 2.0\]: must be a number above 0 for each loop"),
        (Aim([SINE], [0.0]), WIDE, "weights"),
        (Aim([SINE], [math.inf]), WIDE, "weights"),
        (Aim([SINE], [math.nan]), WIDE, "weights"),
        (Aim([SINE], [1.0], seeds=0), WIDE, "seeds = 0: must be a whole number from 1 to 10000"),
        (Aim([SINE], [1.0]), {}, "must name at least one parameter"),
        (Aim([SINE], [1.0]), {"controller.gain": (1.0, 2.0)}, "no 'gain' there"),
        (Aim([SINE], [1.0]), {"controller": (1.0, 2.0)}, "must be the path of a float"),
        (Aim([SINE], [1.0]), {"simulation.seed": (1.0, 2.0)}, "must be the path of a float"),
        (
            Aim([SINE], [1.0]),
            {"simulation.period": (1e-3, 2e-3)},
            "outside simulation, hold and metrics, or the seed",
        ),
        (Aim([SINE], effort=True), WIDE, "effort = True: must be a finite number, at least 0"),
        (Aim([SINE], metric=[1]), WIDE, r"metric = \[1\]: must be the name of a metric"),
        (Aim([SINE], [1.0]), {GAIN: (2.0, 1.0)}, r"proportional_gain = \(2.0, 1.0\): must be a"),
        (Aim([SINE], [1.0]), {GAIN: (1.0, 1.0)}, "must be a range of allowed values, low before high"),
        (Aim([SINE], [1.0]), {GAIN: (-1.0, 1.0)}, "must be a range of allowed values"),
        (Aim([SINE], [1.0]), {GAIN: (1.0, math.inf)}, "must be a range of allowed values"),
        (Aim([SINE], [1.0]), {GAIN: (math.nan, 1.0)}, "must be a range of allowed values"),
        (Aim([SINE], [1.0]), {GAIN: 3.0}, "proportional_gain = 3.0: must be a range of allowed values"),
        (Aim([SINE], [1.0]), {GAIN: (1.0, 2.0, 3.0)}, "must be a range of allowed values"),
    ],
)
def test_what_cannot_be_searched_is_refused_in_one_line(aim: Aim, ranges: Any, message: str) -> None:
    with pytest.raises(ParameterError, match=message) as caught:
        tune(aim, ranges, candidates=64)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("length", "message"),
    [
        ({"candidates": -1}, "candidates = -1: must be a whole number from 0 to 10000000"),
        ({"candidates": 0}, "candidates = 0: is a first guess without a search; leave out the ranges"),
        ({"candidates": 64.0}, "candidates = 64.0: must be a whole number"),
        ({"seed": -1}, "seed = -1: must be a whole number from 0 to 9223372036854775807"),
    ],
)
def test_a_length_or_a_seed_that_is_none_is_refused(length: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        tune(Aim([SINE]), WIDE, **length)


def test_every_metric_that_is_better_small_can_be_an_aim() -> None:
    known = judged_by([SINE])
    assert {"rms_error", "overshoot", "control_total_variation"} < set(known)
    for metric in set(known) - {"overshoot", "low_pressure_time"}:  # which are 0 here
        found = tune(Aim([SINE], [1.0], metric), {GAIN: (1.0, 2.0)}, candidates=64)
        assert found.after[0] == pytest.approx(metric_of(SINE, dict(found.parameters), 1, metric), rel=1e-9)


def test_effort_makes_the_command_calmer_and_is_not_in_the_metric() -> None:
    """What is small is error times variation^effort, as a grid finds it too."""
    grid = np.geomspace(0.3, 10.0, 400)
    runs = simulate_batch(SINE, {GAIN: grid})
    errors = np.where(runs["diverged"], np.inf, runs["rms_error"])
    product = np.where(runs["diverged"], np.inf, errors * runs["control_total_variation"].values ** 0.5)
    found = tune(Aim([SINE], [1.0], effort=0.5), {GAIN: (0.3, 10.0)}, candidates=256)
    assert found.parameters[GAIN] == pytest.approx(grid[product.argmin()], rel=0.03)
    assert found.after == pytest.approx([metric_of(SINE, dict(found.parameters))], rel=1e-9)
    assert found.parameters[GAIN] < 0.8 * grid[errors.argmin()]


@pytest.mark.parametrize("effort", [-0.1, math.inf, math.nan])
def test_an_effort_that_is_none_is_refused(effort: float) -> None:
    with pytest.raises(ParameterError, match=r"effort.*must be a finite number, at least 0"):
        tune(Aim([SINE], [1.0], effort=effort), WIDE)


def test_loops_weigh_alike_where_no_weights_are_given() -> None:
    ranges = {"controller.proportional_gain": (1.0, 10.0)}
    loops = [
        replace(example(Loop), {"simulation.duration": 0.01, "load.amplitude": force})
        for force in (0.0, 100.0)
    ]
    alike = tune(Aim(loops), ranges, candidates=64)
    assert repr(alike).splitlines()[0].startswith("controller.proportional_gain = ")
    assert repr(alike).splitlines()[3].startswith("128 closed loops were simulated")
    assert alike.cost == tune(Aim(loops, (1.0, 1.0)), ranges, candidates=64).cost


@pytest.mark.parametrize("generation", [1, 2])
def test_what_a_search_stumbles_over_later_is_one_line(
    monkeypatch: pytest.MonkeyPatch, generation: int
) -> None:
    """The optimiser lets it pass as it is, in its first population and after that."""
    counted, means = 0, objective.candidate_means

    def nan(aim: Aim, i: int, runs: Any) -> Any:
        nonlocal counted
        counted += 1
        if counted > generation:  # the first are those of the loop as it is
            runs = runs.assign({aim.metric: runs[aim.metric] * math.nan})
        return means(aim, i, runs)

    monkeypatch.setattr(objective, "candidate_means", nan)
    loop = load_scenario("rig/1khz-pi-sine", {"simulation.duration": "20 ms"})
    with pytest.raises(ParameterError) as caught:
        tune(Aim([loop]), {"controller.proportional_gain": (1.0, 10.0)}, candidates=192)
    assert str(caught.value) == (
        "metric = 'rms_error': must be one that every loop has; it is nan in loop 1 of 1"
    )
