"""The environments, held to Gymnasium's own checks, to each other and to runs of the scenario."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.utils.env_match import check_environments_match

import hydroservo as hs
import hydroservo.gym as environments
from hydroservo.testing.bits import bits

gymnasium.register_envs(environments)
IDS = ("hydroservo/Velocity-v0", "hydroservo/Position-v0")
SHORT = {"simulation.duration": "0.05 s"}
LANES = "vector_entry_point"


def made(name: str = IDS[0], draws: int = 3, changes: dict[str, Any] | None = None, **task: Any) -> Any:
    return gymnasium.make(name, draws=draws, changes={**SHORT, **(changes or {})}, **task)


@pytest.mark.parametrize("name", IDS)
def test_gymnasiums_own_checks_find_nothing(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(made(name).unwrapped)
        check_environments_match(made(name), made(name), num_steps=120)


@pytest.mark.parametrize("name", IDS)
def test_lanes_give_the_bits_of_single_environments(name: str) -> None:
    task = {"changes": SHORT, "draws": 3}
    lanes = gymnasium.make_vec(name, 33, vectorization_mode=LANES, **task)
    singles = gymnasium.make_vec(name, 3, vectorization_mode="sync", **task)
    first, others = lanes.reset(seed=7), singles.reset(seed=7)
    assert data_equivalence(first[0][:3], others[0], exact=True)
    lanes.action_space.seed(1)
    for _ in range(120):  # through two ends of episodes
        actions = lanes.action_space.sample()
        one, other = lanes.step(actions), singles.step(actions[:3])
        for ours, theirs in zip(one[:4], other[:4], strict=True):
            assert data_equivalence(ours[:3], theirs, exact=True)
        for key in other[4]:
            assert (one[4][key][:3] == other[4][key]).all()


def test_the_commands_of_the_law_give_the_bits_of_its_run() -> None:
    eight = {"controller.saturation.limit": "8 V"}  # a power of two: actions lose no bit
    env = made(scenario="rig/noisy-1khz-pi-square", changes=eight).unwrapped
    env.reset(seed=5)
    data = hs.simulate(env.loop, strict=True)
    true, value = env.task.runs, data["controlled.value"].to_numpy()
    for k, command in enumerate(data["controller.u"].to_numpy()[:-1]):
        assert bits(true["controlled.value"]) == bits(value[k : k + 1])
        _, reward, terminated, truncated, _ = env.step(np.array([command / 8.0]))
        error = value[k + 1] - data["reference.value"].to_numpy()[k + 1]
        before = data["controller.u"].to_numpy()[k - 1] if k else 0.0
        own = -min((error / env.task.error_scale) ** 2, 1.0) - 0.1 * ((command - before) / 8.0) ** 2
        assert reward == pytest.approx(own, rel=1e-12)
        assert (terminated, truncated) == (False, k == 49)


def test_a_piston_that_leaves_its_stroke_ends_the_episode_at_the_price_of_what_is_left() -> None:
    env = made(changes={"simulation.duration": "1 s"})
    env.reset(seed=0)
    steps = 0
    ended = False
    while not ended:
        seen, reward, ended, cut, _ = env.step(np.array([-1.0]))
        steps += 1
    assert not cut
    assert steps < 1000
    assert seen[2] <= 0.0  # the position
    assert reward <= -(1000 - steps) * 1.4
    assert env.observation_space.contains(seen)


def test_episodes_are_drawn_from_the_uncertainty_and_from_what_is_to_vary() -> None:
    vary = {"reference.amplitude": (0.01, 0.03)}
    env = made(draws=50, vary=vary).unwrapped
    nominal = hs.load_scenario("rig/1khz-pi-sine", {"uncertainty.scale": 0})
    seen = []
    for _ in range(60):
        env.reset()
        seen.append((env.loop.plant.leakage, env.loop.plant.damping, env.loop.reference.amplitude))
    leakage, damping, amplitude = np.array(seen).T
    deviation = leakage / nominal.plant.leakage - 1.0
    assert np.abs(deviation).max() <= 0.3
    assert deviation.min() < -0.2
    assert deviation.max() > 0.2
    # all by one factor
    np.testing.assert_allclose(damping / nominal.plant.damping - 1.0, deviation * 2 / 3, atol=1e-12)
    assert amplitude.min() >= 0.01
    assert amplitude.max() <= 0.03
    assert np.ptp(amplitude) > 0.01


@pytest.mark.parametrize(
    ("task", "said"),
    [
        ({"scenario": "axis/position"}, "scenario = axis/position: must control the velocity"),
        ({"scenario": "rig/none"}, "rig/none"),
        ({"draws": 0}, "draws = 0"),
        ({"error_weight": float("nan")}, "error_weight = nan"),
        ({"effort_weight": -1.0}, "effort_weight = -1"),
        ({"vary": {"plant.mss": (1.0, 2.0)}}, "plant.mss"),
    ],
)
def test_wrong_arguments_are_refused_in_one_line(task: dict[str, Any], said: str) -> None:
    with pytest.raises(hs.HydroservoError) as error:
        environments.LoopEnv(**{"scenario": "rig/1khz-pi-sine", "signal": "velocity", **task})
    assert said in str(error.value).replace("'", "")
    assert "\n" not in str(error.value)


def test_where_nothing_differs_there_is_one_machine() -> None:
    env = made(draws=50, changes={"uncertainty.scale": 0})
    assert {env.reset()[1]["machine"] for _ in range(20)} == {0}


def test_an_action_that_is_no_number_is_refused() -> None:
    env = made().unwrapped
    env.reset(seed=0)
    for action in ([np.nan], [0.1, 0.2]):
        with pytest.raises(hs.ParameterError, match="must be 1 finite numbers"):
            env.step(np.array(action))
