"""The linear quadratic laws: the loops they are designed for, no offset, and where that ends."""

import math

import numpy as np
import pytest
from scipy.signal import cont2discrete

from hydroservo import simulate
from hydroservo.control.controllers import LQI, InternalModel, OffsetFreeLQ, Saturation
from hydroservo.control.controllers.resonator import Resonator
from hydroservo.control.loop import Loop
from hydroservo.control.observers import ExtendedStateObserver, HighGainObserver, KalmanObserver, NoObserver
from hydroservo.control.observers.spool_lag import SpoolLag
from hydroservo.control.references import Step
from hydroservo.control.synthesis.linear_model import model_at_rest
from hydroservo.control.synthesis.lqr import lqr
from hydroservo.control.synthesis.memory import (
    NOTHING,
    ErrorMemory,
    both,
    integrator,
    oscillator,
    remembering,
)
from hydroservo.control.synthesis.sampled import under_held_input
from hydroservo.core.block import Block
from hydroservo.core.errors import ParameterError
from hydroservo.core.hooks import designed
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants import DesignModel
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example

MODEL = example(DesignModel)
LAG, PERIOD = 0.01, 1e-3
KALMAN = KalmanObserver(10.0, 1e5, 1e-4, 1.0)
STILL = Demand(0.0, 0.0, 0.0)
LAWS = (
    OffsetFreeLQ(1e-3, LAG, KALMAN),
    LQI(1e-3, 30.0, LAG),
    InternalModel(1e-3, 0.25, 30.0, 30.0, LAG),
)
MEMORY = both(integrator(30.0, PERIOD), oscillator(30.0, 0.25, PERIOD))
names = pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)


def ready(law: Block, lag: float = LAG) -> Block:
    return designed(law._replace(model=MODEL, time_constant=lag), PERIOD, lambda: MODEL)


def seen(x1: float, x2: float, command: float) -> Measurement:
    return Measurement(x1, x2, math.nan, command, math.nan, math.nan, math.nan)


def memory_of(s: Block) -> tuple[float, ...]:
    if not hasattr(s, "integral"):
        return ()
    return (s.integral, *s.resonator) if hasattr(s, "resonator") else (s.integral,)


def with_memory(s: Block, memory: np.ndarray) -> Block:
    if not len(memory):
        return s
    s = s._replace(integral=float(memory[0]))
    return s._replace(resonator=s.resonator._make(memory[1:].tolist())) if len(memory) > 1 else s


def loop_poles(law: Block, lag: float) -> np.ndarray:
    """Of a linear machine that is the model, sampled by scipy, under the law's own step."""
    plant = model_at_rest(MODEL, lag)
    parts = (
        plant.rates,
        plant.driven[:, np.newaxis],
        np.eye(len(plant.rates)),
        np.zeros((len(plant.rates), 1)),
    )
    transition, driven, *_ = cont2discrete(parts, PERIOD)
    sizes = np.concatenate([plant.sizes, np.ones(len(memory_of(law.init())))])
    states = len(plant.sizes)

    def ahead(z: np.ndarray) -> np.ndarray:
        x, opening = z[:states], float(z[2]) if states == 3 else 0.0
        s = with_memory(law.init()._replace(opening=opening), z[states:])
        s = s._replace(unlimited=opening) if hasattr(s, "unlimited") else s
        s = law.step(s, seen(float(x[0]), float(x[1]), opening), STILL, PERIOD)
        return np.concatenate([transition @ x + driven[:, 0] * s.u, memory_of(s)])

    steps = np.diag(sizes) * 1e-6
    columns = [(ahead(step) - ahead(-step)) / (2e-6 * size) for step, size in zip(steps, sizes, strict=True)]
    return np.linalg.eigvals(np.array(columns).T)


def designed_poles(lag: float, memory: ErrorMemory) -> np.ndarray:
    """Of the gain alone, in the scale of the design."""
    plant = model_at_rest(MODEL, lag)
    scaled = plant.scaled()
    transition, driven = remembering(*under_held_input(scaled.rates, scaled.driven, PERIOD), memory)
    weights = np.concatenate([[1.0], np.zeros(len(plant.sizes) - 1), np.ones(len(memory.rates))])
    gain = lqr(transition, driven, weights, 1e-3 * plant.command)
    return np.linalg.eigvals(transition - np.outer(driven, gain))


@pytest.mark.parametrize("lag", [LAG, 0.0])
@pytest.mark.parametrize(
    ("law", "memory"),
    [
        (LAWS[0]._replace(observer=NoObserver()), NOTHING),
        (LAWS[1], integrator(30.0, PERIOD)),
        (LAWS[2], MEMORY),
    ],
    ids=lambda one: type(one).__name__,
)
def test_the_loop_has_the_poles_of_its_design(law: Block, memory: ErrorMemory, lag: float) -> None:
    poles = loop_poles(ready(law, lag), lag)
    assert np.abs(poles).max() < 1.0
    assert np.poly(poles) == pytest.approx(np.poly(designed_poles(lag, memory)), abs=1e-7)


@names
def test_where_the_model_follows_the_demand_the_command_is_what_it_needs(law: Block) -> None:
    """x at its target: d/dt of x1 and x2 by the model are those of the demand and of the target."""
    r, law = Demand(0.02, 0.3, -4.0), ready(law, 0.0)
    if isinstance(law, OffsetFreeLQ):
        law = law._replace(observer=NoObserver())
    x2 = (r.rate - MODEL.f1(r.value)) / MODEL.g1()
    u = law.step(law.init(), seen(r.value, x2, 0.0), r, PERIOD).u
    rates = MODEL.rates(r.value, x2, 0.0, MODEL.g2(x2, 0.0) * u)
    assert rates.velocity == pytest.approx(r.rate, rel=1e-12)
    assert rates.hydraulic_force == pytest.approx(
        (r.second_rate - MODEL.f1_slope() * r.rate) / MODEL.g1(), rel=1e-9
    )


def constant_loop(scale: float, law: Block) -> Loop:
    """A constant demand, reached by a jump, and a constant load, on the machine with the valve's lag."""
    asked = {
        "uncertainty.scale": scale,
        "simulation.duration": "24 s",
        "load.type": "Constant",
        "plant.stroke": "1 m",
    }
    loop = load_scenario("rig/1khz-pi-sine", asked)
    return loop._replace(reference=Step(0.0, 0.02), controller=law._replace(model=MODEL))


def last_error(loop: Loop) -> float:
    run = simulate(loop)
    return abs(float(run["plant.velocity"][-1]) - 0.02)


@pytest.mark.slow  # long runs
@pytest.mark.parametrize("scale", [1.0, -1.0])
@names
def test_no_error_stays_under_a_constant_load_whatever_the_parameters(law: Block, scale: float) -> None:
    loop = constant_loop(scale, law)
    assert float(loop.load.force(0.0)) == 100.0
    assert last_error(loop) < 1e-9


@pytest.mark.slow  # long runs
@pytest.mark.parametrize(
    "observer",
    [ExtendedStateObserver(300.0, 300.0), HighGainObserver(200.0, 100.0)],
    ids=lambda o: type(o).__name__,
)
def test_nor_with_other_observers(observer: Block) -> None:
    assert last_error(constant_loop(1.0, LAWS[0]._replace(observer=observer))) < 1e-9


@pytest.mark.slow  # long runs
def test_without_an_observer_it_does() -> None:
    assert last_error(constant_loop(1.0, LAWS[0]._replace(observer=NoObserver()))) > 1e-3


@pytest.mark.parametrize(("effort", "is_lost"), [(1e-3, True), (0.1, False)])
def test_little_effort_is_bought_with_robustness(effort: float, is_lost: bool) -> None:
    """Under a valve twice as fast as it is taken for."""
    loop = constant_loop(0.0, OffsetFreeLQ(effort, LAG, KALMAN))
    fast = loop._replace(valve=loop.valve._replace(time_constant=0.5 * LAG))
    assert last_error(loop) < 1e-9
    assert (float(simulate(fast)["steady_max_error"]) > 0.02) == is_lost  # swings for good


def test_anti_windup_shortens_the_way_back() -> None:
    """A demand that a small limit cannot meet for 0.3 s; then one that it can."""
    late = []
    for share in (0.0, 1.0):
        law = LQI(1e-2, 30.0, LAG, saturation=Saturation(0.03))
        gain = ready(law).gain_1
        loop = constant_loop(0.0, law._replace(anti_windup=share / gain))
        loop = loop._replace(reference=Step(0.1, 0.01, time=0.3))
        run = simulate(loop)
        late.append(float(abs(run["plant.velocity"] - 0.01)[run["time"] > 0.5].max()))
    assert late[0] > 5.0 * late[1]


def sine_loop(law: Block, scale: float, **asked: str) -> Loop:
    changes = {
        "uncertainty.scale": scale,
        "simulation.period": "100 us",
        "simulation.substeps": 4,
        "simulation.duration": "32 s",
    }
    return load_scenario("paper/sine-pi", changes | asked)._replace(controller=law._replace(model=MODEL))


def steady_error(law: Block, scale: float, **asked: str) -> float:
    """The largest over the last period [m/s]."""
    run = simulate(sine_loop(law, scale, **asked))
    error = run["plant.velocity"] - run["reference.value"]
    return float(abs(error)[run["time"] > 28.0].max())


RESONANT = InternalModel(1e-2, 0.25, 100.0, 100.0, 0.0)
INTEGRAL = LQI(1e-2, 100.0, 0.0)


@pytest.mark.slow  # long runs
@pytest.mark.parametrize("scale", [1.0, -1.0])
def test_an_internal_model_leaves_no_error_at_its_own_frequency(scale: float) -> None:
    """It ends at 2e-11 m/s of 0.03, where harmonics of the sampled orifice are; at 10 us at 1e-12."""
    assert steady_error(RESONANT, scale) < 1e-9
    assert steady_error(INTEGRAL, scale) > 2e-5


@pytest.mark.parametrize("share", [0.95, 1.05])
def test_an_internal_model_of_another_frequency_leaves_one(share: float) -> None:
    off = steady_error(RESONANT._replace(frequency=share * 0.25), 1.0)
    assert 1e-6 < off < 0.1 * steady_error(INTEGRAL, 1.0)


def test_nor_does_an_internal_model_help_against_a_load_of_another() -> None:
    asked = {"load.frequency": "0.7 Hz"}
    assert steady_error(RESONANT, 1.0, **asked) > 0.5 * steady_error(INTEGRAL, 1.0, **asked)


def test_the_oscillator_turns_exactly() -> None:
    block = Resonator(0.25)
    s = block.init()._replace(phase=1.0)
    for _ in range(40_000):  # ten turns
        s = block.step(s, 0.0, 1e-3)
    assert tuple(s) == pytest.approx((0.0, 1.0), abs=1e-11)
    turn = oscillator(1.0, 0.25, PERIOD)
    s = block.step(block.init()._make((0.3, -0.2)), 0.7, PERIOD)
    assert tuple(s) == pytest.approx(turn.transition @ [0.3, -0.2] + turn.driven * 0.7, rel=1e-12)


def test_the_lag_is_followed_exactly() -> None:
    lag = SpoolLag(LAG)
    after = lag.after(2.0, 5.0, 0.003)
    assert after == pytest.approx(5.0 - 3.0 * math.exp(-0.3), rel=1e-15)
    instants = np.linspace(0.0, 0.003, 3001)
    mean = np.trapezoid(5.0 - 3.0 * np.exp(-instants / LAG), instants) / 0.003
    assert lag.mean(2.0, 5.0, 0.003) == pytest.approx(mean, rel=1e-8)
    none = SpoolLag(0.0)
    assert (none.after(2.0, 5.0, 1e-9), none.mean(2.0, 5.0, 1e-9)) == (5.0, 5.0)


@names
def test_weights_out_of_reach_are_refused_in_one_line(law: Block) -> None:
    with pytest.raises(ParameterError) as caught:
        ready(law._replace(effort=1e300))
    message = str(caught.value)
    assert message.startswith(f"{type(law).__name__}.effort = 1e+300: with ")
    assert message.endswith(
        "no gain is found: they, or the model, are beyond the range of floating-point numbers"
    )
    assert f"sample period of {PERIOD:g} s" in message
    assert message.isprintable()


def test_a_frequency_that_sampling_cannot_show_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"^InternalModel\.frequency = 500\.0: must be below half"):
        ready(LAWS[2]._replace(frequency=500.0))


def test_more_effort_is_a_calmer_law() -> None:
    gains = [ready(OffsetFreeLQ(effort, LAG, KALMAN)).gain_3 for effort in (1e-2, 1e-1, 1.0)]
    assert gains[0] > 2.0 * gains[1] > 4.0 * gains[2] > 0.0
    heavy = ready(LAWS[0]._replace(force_weight=1e-3))
    assert heavy.gain_2 != ready(LAWS[0]).gain_2
