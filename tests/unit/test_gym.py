"""The environments, held to Gymnasium's own checks, to each other and to runs of the scenario."""

import copy
import pickle
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.utils.env_match import check_environments_match

import hydroservo as hs
import hydroservo.gym as environments
from hydroservo.testing.case import bits
from tests.support.plugins import MECHANISM

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


@pytest.fixture
def ram(tmp_path: Path) -> dict[str, Any]:
    """A scenario with a mechanism of one's own, and the file of that."""
    own, scenario = tmp_path / "blank.py", tmp_path / "ram.toml"
    own.write_text(MECHANISM)
    scenario.write_text('base = "axis/position"\nplant.mechanism = { type = "OntoBlank" }\n')
    return {"scenario": scenario, "plugins": [own]}


def rewards(env: Any, count: int = 20) -> list[bytes]:
    """The bits of rewards that commands of one's own bring."""
    actions = np.random.default_rng(3).uniform(-0.3, 0.3, size=(count, *env.action_space.shape))
    return [bits(np.asarray(env.step(action)[1])) for action in actions]


def test_a_block_of_ones_own_is_in_an_environment_by_its_file_and_in_a_loop(ram: dict[str, Any]) -> None:
    nominal = {"uncertainty.scale": 0}  # which a loop no longer has
    loop = hs.load_scenario(ram["scenario"], SHORT | nominal, ram["plugins"])
    assert type(loop.plant.mechanism).__name__ == "OntoBlank"
    envs = made(IDS[1], changes=nominal, **ram), gymnasium.make(IDS[1], scenario=loop, draws=3)
    for env in envs:
        env.reset(seed=1)
    assert rewards(envs[0]) == rewards(envs[1])


@pytest.mark.parametrize("given", [{"changes": SHORT}, {"plugins": ["law.py"]}])
def test_what_makes_a_loop_does_not_go_with_one(given: dict[str, Any]) -> None:
    with pytest.raises(hs.ParameterError, match=r"must be left out where scenario is a loop"):
        environments.LoopEnv(hs.load_scenario("axis/position"), "position", **given)


COPIES = [copy.copy, copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))]


@pytest.mark.parametrize("copied", COPIES)
def test_a_copy_goes_on_from_the_same_state_by_itself(
    copied: Callable[[Any], Any], ram: dict[str, Any]
) -> None:
    env = made(IDS[1], **ram).unwrapped
    env.reset(seed=2)
    rewards(env)
    twin = copied(env)
    ours = rewards(env)
    assert rewards(twin) == ours
    assert data_equivalence(twin.reset(), env.reset(), exact=True)  # from the same generator


@pytest.mark.parametrize("copied", COPIES)
def test_a_copy_of_runs_side_by_side_goes_on_too(copied: Callable[[Any], Any]) -> None:
    env = gymnasium.make_vec(IDS[0], 70, vectorization_mode=LANES, changes=SHORT, draws=3, threads=2)
    env.reset(seed=2)
    rewards(env)
    twin = copied(env)
    ours = rewards(env, 60)  # through ends of episodes
    assert rewards(twin, 60) == ours


def test_another_process_goes_on_with_a_pickle(ram: dict[str, Any], tmp_path: Path) -> None:
    env = made(IDS[1], **ram).unwrapped
    env.reset(seed=2)
    (tmp_path / "env.pickle").write_bytes(pickle.dumps(env))
    text = (
        "import pickle, sys, numpy\n"
        "env = pickle.load(open(sys.argv[1], 'rb'))\n"
        "print(*(env.step(numpy.array([0.2]))[1].hex() for _ in range(20)))"
    )
    command = [sys.executable, "-c", text, str(tmp_path / "env.pickle")]
    theirs = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    assert theirs == [env.step(np.array([0.2]))[1].hex() for _ in range(20)]


@pytest.mark.filterwarnings("ignore:.*render_mode:UserWarning")  # of Gymnasium
def test_that_nothing_is_drawn_is_said_in_one_line() -> None:
    for make in (gymnasium.make, lambda *given, **more: gymnasium.make_vec(*given, 2, LANES, **more)):
        with pytest.raises(hs.ParameterError) as error:
            make(IDS[0], render_mode="rgb_array")
        assert str(error.value) == "render_mode = 'rgb_array': must be None: nothing is drawn"
    assert made(render_mode=None).unwrapped.render() is None


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
    for action in ([np.nan], [0.1, 0.2], ["left"], [None]):
        with pytest.raises(hs.ParameterError, match="must be 1 finite numbers"):
            env.step(np.array(action))
