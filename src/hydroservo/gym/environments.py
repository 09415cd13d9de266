"""The environments: one run, and many side by side."""

from collections.abc import Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.errors import ParameterError
from hydroservo.core.validation import whole_number
from hydroservo.gym.task import Task

Numbers = NDArray[np.float64]
Flags = NDArray[np.bool_]
Info = dict[str, Any]

FIRST = np.zeros(1, dtype=np.int64)  # the number of the only run
MOST = 1_000_000  # runs side by side
METADATA: dict[str, Any] = {"render_modes": []}


def check_render_mode(render_mode: object) -> None:
    """Refuse a render mode, for nothing is drawn."""
    if render_mode is not None:
        raise ParameterError("render_mode", render_mode, "must be None: nothing is drawn")


class LoopEnv(gymnasium.Env[Numbers, Numbers]):
    """One run of a scenario, of which an agent gives the commands; arguments are those of :class:`Task`.

    ``reset`` returns in its info which of the drawn sets of parameters the episode has (``machine``) and the
    seed of its random numbers (``seed``). Copies, shallow ones too, and pickles go on from the same state by
    themselves. Nothing is drawn.
    """

    metadata = METADATA

    def __init__(
        self, scenario: str | Path | Loop, signal: str, *, render_mode: None = None, **task: Any
    ) -> None:
        check_render_mode(render_mode)
        self.task = Task(1, scenario, signal, **task)
        self.observation_space, self.action_space = self.task.observation_space, self.task.action_space

    def __copy__(self) -> "LoopEnv":
        """A copy with a state of its own."""
        return deepcopy(self)

    def render(self) -> None:
        """Nothing is drawn."""

    @property
    def loop(self) -> Loop:
        """The loop of the episode with the scenario's law, for ``hydroservo.simulate``."""
        return self.task.loop_of(0)

    def reset(self, *, seed: int | None = None, options: Info | None = None) -> tuple[Numbers, Info]:
        """A new episode: a machine and a demand are drawn, and the first sample is measured."""
        super().reset(seed=seed)
        self.task.begin(FIRST, [self.np_random])
        info = {"machine": int(self.task.machine[0]), "seed": int(self.task.seed[0])}
        return self.task.observations()[0], info

    def step(self, action: ArrayLike) -> tuple[Numbers, float, bool, bool, Info]:
        """The command is held until the next sample, which is measured."""
        found = self.task.advance(action)
        ends = bool(found.terminated[0]), bool(found.truncated[0])
        return found.observations[0], float(found.rewards[0]), *ends, {}


class LoopVectorEnv(gymnasium.vector.VectorEnv[Numbers, Numbers, Any]):
    """Runs side by side in vector lanes and on all cores; arguments are those of :class:`Task`.

    Run i has the bits of a :class:`LoopEnv` that is seeded with ``seed + i``. A run whose episode ended
    begins anew at the next step, whose action it does not heed.
    """

    metadata = METADATA | {"autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int,
        scenario: str | Path | Loop,
        signal: str,
        *,
        render_mode: None = None,
        **task: Any,
    ) -> None:
        check_render_mode(render_mode)
        self.num_envs = whole_number("num_envs", num_envs, 1, MOST)
        self.task = Task(self.num_envs, scenario, signal, **task)
        self.single_observation_space = self.task.observation_space
        self.single_action_space = self.task.action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.generators = [np_random(None)[0] for _ in range(self.num_envs)]
        self.over: Flags = np.zeros(self.num_envs, dtype=np.bool_)

    def __copy__(self) -> "LoopVectorEnv":
        """A copy with a state of its own."""
        return deepcopy(self)

    def render(self) -> None:
        """Nothing is drawn."""

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: Info | None = None
    ) -> tuple[Numbers, Info]:
        """New episodes of all runs.

        Args:
            seed: of the first run, the others have those after it; or one each; None goes on drawing.
            options: none are known.

        Raises:
            ParameterError: another number of seeds than of runs.
        """
        seeds = range(seed, seed + self.num_envs) if isinstance(seed, int) else seed
        if seeds is not None and len(seeds) != self.num_envs:
            raise ParameterError("seed", f"{len(seeds)} seeds", f"must be one, or {self.num_envs} of them")
        for run, one in enumerate(seeds or ()):
            if one is not None:
                self.generators[run] = np_random(one)[0]
        every = np.ones(self.num_envs, dtype=np.bool_)
        info = self.begin(every)
        self.over = ~every
        return self.task.observations(), info

    def step(self, actions: Numbers) -> tuple[Numbers, Numbers, Flags, Flags, Info]:
        """The commands are held until the next sample, which is measured; what was over begins anew."""
        begun = self.over
        found = self.task.advance(actions)
        if not begun.any():
            self.over = found.terminated | found.truncated
            return *found, {}
        info = self.begin(begun)
        rewards = np.where(begun, 0.0, found.rewards)
        ends = found.terminated & ~begun, found.truncated & ~begun
        self.over = ends[0] | ends[1]
        return self.task.observations(), rewards, *ends, info

    def begin(self, which: Flags) -> Info:
        """New episodes of some runs, and what is to be said of them."""
        self.task.begin(np.flatnonzero(which), self.generators)
        numbers = {"machine": self.task.machine, "seed": self.task.seed}
        said = {name: np.where(which, values, 0) for name, values in numbers.items()}
        return said | {f"_{name}": which.copy() for name in numbers}
