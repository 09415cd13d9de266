"""Gains designed off line: against closed forms, and against other ways to the same numbers."""

import math
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from scipy.linalg import eig
from scipy.signal import cont2discrete

from hydroservo.control.controllers import LQI
from hydroservo.control.synthesis.gains import computed, no_gain
from hydroservo.control.synthesis.linear_model import model_at_rest, with_disturbances
from hydroservo.control.synthesis.lqr import lqr
from hydroservo.control.synthesis.memory import both, integrator, oscillator, remembering
from hydroservo.control.synthesis.sampled import under_held_input, under_white_noise
from hydroservo.core.block import Block, Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.hooks import designed
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants import DesignModel
from hydroservo.testing.examples import example

MODEL = example(DesignModel)
INTEGRATORS, PUSH = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([0.0, 1.0])
LAG = 0.01


def plants() -> list[tuple[np.ndarray, np.ndarray]]:
    """Sampled models of some sizes, with and without memory."""
    lagging, static = (model_at_rest(MODEL, lag).scaled() for lag in (LAG, 0.0))
    memory = both(integrator(30.0, 1e-3), oscillator(20.0, 0.25, 1e-3))
    found = [under_held_input(one.rates, one.driven, 1e-3) for one in (lagging, static)]
    return [*found, remembering(*found[0], memory), under_held_input(INTEGRATORS, PUSH, 0.1)]


def riccati(transition: np.ndarray, driven: np.ndarray, weights: np.ndarray, effort: float) -> np.ndarray:
    """The gain to which dynamic programming leads from the end backwards."""
    cost = np.diag(weights**2)
    for _ in range(20_000):
        gain = driven @ cost @ transition / (driven @ cost @ driven + effort**2)
        closed = transition - np.outer(driven, gain)
        cost = np.diag(weights**2) + closed.T @ cost @ closed + effort**2 * np.outer(gain, gain)
    return gain


def test_a_double_integrator_has_the_gain_of_the_textbook() -> None:
    """Q = I and R = 1 have K = [1, sqrt 3] in continuous time; sampling is off by the order of the period."""
    off = []
    for period in (1e-2, 1e-3):
        gain = lqr(*under_held_input(INTEGRATORS, PUSH, period), np.ones(2), 1.0)
        off.append(np.abs(gain - [1.0, math.sqrt(3.0)]).max())
    assert off[1] < 2e-3
    assert off[0] / off[1] == pytest.approx(10.0, rel=0.02)


@pytest.mark.parametrize("plant", plants(), ids=["lag", "static", "memory", "double integrator"])
@pytest.mark.parametrize("effort", [0.1, 10.0])
def test_the_gain_is_where_dynamic_programming_ends(
    plant: tuple[np.ndarray, np.ndarray], effort: float
) -> None:
    weights = np.ones(len(plant[1]))
    gain = lqr(*plant, weights, effort)
    assert gain == pytest.approx(riccati(*plant, weights, effort), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("plant", plants(), ids=["lag", "static", "memory", "double integrator"])
@pytest.mark.parametrize("effort", [0.1, 10.0])
def test_the_poles_are_those_of_the_symplectic_pencil_inside_the_circle(
    plant: tuple[np.ndarray, np.ndarray], effort: float
) -> None:
    """Its eigenvalues come in pairs z and 1/z; no Riccati equation is solved for them."""
    transition, driven = plant
    n = len(driven)
    nothing, one = np.zeros((n, n)), np.eye(n)
    left = np.block([[transition, nothing], [-np.eye(n), one]])
    right = np.block([[one, np.outer(driven, driven) / effort**2], [nothing, transition.T]])
    pairs = eig(left, right, right=False)
    inside = pairs[np.abs(pairs) < 1.0]
    poles = np.linalg.eigvals(transition - np.outer(driven, lqr(*plant, np.ones(n), effort)))
    assert len(inside) == n
    assert np.abs(poles).max() < 1.0
    assert np.poly(poles) == pytest.approx(np.poly(inside), abs=1e-9)


def test_a_model_that_no_command_moves_has_no_gain() -> None:
    with pytest.raises(np.linalg.LinAlgError):
        lqr(np.diag([2.0, 0.5]), np.array([0.0, 1.0]), np.ones(2), 1.0)


def test_a_memory_without_weight_has_no_gain() -> None:
    """What the measure does not see, on the unit circle, no best command brings to rest."""
    transition, driven = under_held_input(INTEGRATORS, PUSH, 0.1)
    with pytest.raises(np.linalg.LinAlgError):
        lqr(transition, driven, np.array([0.0, 1.0]), 1.0)


def test_sampling_is_that_of_scipy() -> None:
    plant = model_at_rest(MODEL, LAG)
    scaled = plant.scaled()
    transition, driven = under_held_input(scaled.rates, scaled.driven, 1e-3)
    parts = (plant.rates, plant.driven[:, np.newaxis], np.eye(3), np.zeros((3, 1)))
    expected, added, *_ = cont2discrete(parts, 1e-3)
    shape = plant.sizes[:, np.newaxis]
    assert transition * shape / plant.sizes == pytest.approx(expected, rel=1e-9)
    assert driven[:, np.newaxis] * shape / plant.command == pytest.approx(added, rel=1e-9)


def test_noise_on_a_double_integrator_by_its_closed_form() -> None:
    h, q = 0.3, 2.0
    transition, added = under_white_noise(INTEGRATORS, np.diag([0.0, q]), h)
    assert transition == pytest.approx(np.array([[1.0, h], [0.0, 1.0]]), rel=1e-12)
    expected = q * np.array([[h**3 / 3.0, h**2 / 2.0], [h**2 / 2.0, h]])
    assert added == pytest.approx(expected, rel=1e-12)


def test_the_linear_model_is_the_slope_of_the_design_model() -> None:
    plant, small = model_at_rest(MODEL, LAG), 1e-7
    for i, step in enumerate(np.diag(plant.sizes[:2] * small)):
        rates = MODEL.rates(float(step[0]), float(step[1]), 0.0, 0.0)
        assert plant.rates[:2, i] * step[i] == pytest.approx(
            [rates.velocity, rates.hydraulic_force], rel=1e-9
        )
    volts = plant.sizes[2] * small
    assert plant.rates[1, 2] * volts == pytest.approx(MODEL.g2(0.0, volts) * volts, rel=1e-9)
    assert with_disturbances(MODEL)[:2, :2] == pytest.approx(plant.rates[:2, :2])
    assert model_at_rest(MODEL, 0.0).driven == pytest.approx([0.0, plant.rates[1, 2]])


def test_an_oscillator_keeps_its_size_for_ever() -> None:
    memory = oscillator(1.0, 0.25, 1e-3)
    assert np.abs(np.linalg.eigvals(memory.transition)) == pytest.approx(1.0, abs=1e-15)
    whole_turn = np.linalg.matrix_power(memory.transition, 4000)
    assert whole_turn == pytest.approx(np.eye(2), abs=1e-12)


class State(NamedTuple):
    u: Annotated[float, Field("V", "command")]


CALLS: list[str] = []


@role(Controller)
class Halved(NamedTuple):
    size: Annotated[float, Field("V", "size")]
    gain: Annotated[float, Field("V", "gain", "half the size", derived=True)] = 0.0
    inner: Block = State(0.0)

    def init(self) -> State:
        return State(0.0)

    def step(self, s: State, y: Measurement, r: Demand, dt: float) -> State:
        return State(self.gain)

    def designed(self, model: Block, period: float) -> "Halved":
        CALLS.append("halved")
        return self._replace(gain=0.5 * self.size)


NONE = no_gain(Halved(2.0), ["size"], 1e-3, "it is")


def test_gains_have_nine_digits() -> None:
    (gain,) = computed(lambda: [np.array([[1.0 / 3.0, 2e9 / 3.0]])], NONE)
    assert gain.tolist() == [[0.333333333, 666666667.0]]


@pytest.mark.parametrize("size", [0.0, math.inf])
def test_a_design_that_fails_and_one_that_is_not_finite_are_no_gain(size: float) -> None:
    with pytest.raises(ParameterError) as caught:
        computed(lambda: [np.eye(2), np.linalg.inv(np.eye(2) * size), np.eye(1) * size], NONE)
    assert caught.value is NONE


@role(Controller)
class Doubled(NamedTuple):
    size: Annotated[float, Field("V", "size")]
    gain: Annotated[float, Field("V", "gain", "twice the size", derived=True)] = 0.0
    inner: Block = State(0.0)

    def init(self) -> State:
        return State(0.0)

    def step(self, s: State, y: Measurement, r: Demand, dt: float) -> State:
        return State(self.gain)

    def designed(self, model: Block, period: float) -> "Doubled":
        CALLS.append("doubled")
        return self._replace(gain=2.0 * self.size)


class Other(NamedTuple):
    u: Annotated[float, Field("V", "command")]


def test_the_same_numbers_are_designed_once() -> None:
    CALLS.clear()
    found = [designed(Halved(3.25), 1e-3, lambda: MODEL) for _ in range(3)]
    assert found == [Halved(3.25, 1.625)] * 3
    assert CALLS == ["halved"]
    designed(Halved(3.25), 2e-3, lambda: MODEL)
    designed(Halved(3.25), 1e-3, lambda: MODEL._replace(least_drop=2e3))
    assert CALLS == ["halved"] * 3


def test_blocks_of_other_classes_with_the_same_numbers_have_designs_of_their_own() -> None:
    """To Python they are equal, and have the same hash."""
    one, other = designed(Halved(7.5), 1e-3, lambda: MODEL), designed(Doubled(7.5), 1e-3, lambda: MODEL)
    assert (one, other) == ((7.5, 3.75, State(0.0)), (7.5, 15.0, State(0.0)))
    assert type(other) is Doubled
    inner = [designed(Halved(7.5, inner=kind(0.0)), 1e-3, lambda: MODEL).inner for kind in (State, Other)]
    assert [type(one) for one in inner] == [State, Other]
    zeros = [designed(Halved(zero), 1e-3, lambda: MODEL).gain for zero in (0.0, -0.0)]
    assert [math.copysign(1.0, gain) for gain in zeros] == [1.0, -1.0]


def test_a_block_with_an_array_is_designed_each_time() -> None:
    CALLS.clear()
    for _ in range(2):
        designed(Halved(1.0, inner=np.zeros(2)), 1e-3, lambda: MODEL)
    assert CALLS == ["halved"] * 2


@pytest.mark.parametrize("size", [math.inf, math.nan])
def test_rates_beyond_numbers_are_refused(size: float) -> None:
    with pytest.raises(ValueError, match=r"beyond floating-point|infs or NaNs"):
        under_held_input(INTEGRATORS, np.array([0.0, size]), 1.0)


def test_an_absurd_model_is_refused_in_one_line() -> None:
    heavy = MODEL._replace(plant=MODEL.plant._replace(mass=1e300, bulk_modulus=1e-300))
    with pytest.raises(ParameterError, match=r"^LQI\.effort = .*they, or the model, are beyond") as caught:
        example(LQI).designed(heavy, 1e-3)
    assert str(caught.value).isprintable()


def test_what_is_said_of_one_number_alone() -> None:
    assert str(NONE) == (
        "Halved.size = 2.0: with a sample period of 0.001 s no gain is found: "
        "it is beyond the range of floating-point numbers"
    )
