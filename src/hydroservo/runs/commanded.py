"""Loops that are given their commands from outside, all of them one sample period a call."""

import math
import warnings
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy, deepcopy
from itertools import pairwise, repeat
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo.control.loop import Loop
from hydroservo.control.wiring import wired
from hydroservo.core.block import Block, Field, leaves, replace
from hydroservo.core.errors import HydroservoWarning, ParameterError
from hydroservo.core.group import group
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.core.validation import LARGEST_WHOLE, checked
from hydroservo.cosimulation import refuse_fmus
from hydroservo.runs.batch import loop_with_steps
from hydroservo.runs.columns import SEED, checked_columns, hardest_loop, start_columns
from hydroservo.runs.fitting import compilation, first_state
from hydroservo.runs.kernels import run_spec, state_reaches, watched_paths
from hydroservo.runs.run import runnable_loop
from hydroservo.runs.trace import plan_of
from hydroservo.work.cores import checked_count

COMMAND = "controller.u"
LEAST_GROUPS = 4  # of runs that are worth a thread

Numbers = NDArray[np.float64]
WholeNumbers = NDArray[np.int64]

NOTHING = Measurement(*(math.nan,) * len(Measurement._fields))  # yet; a signal that nothing measures stays so


class SteppedRuns:
    """Runs of a loop whose commands come from outside, each of one of some sets of parameters::

        runs = SteppedRuns(loop, {"plant.mass": [5.0, 6.0]}, 100)
        runs.begin(np.arange(100), sets=np.arange(100) % 2, seeds=np.arange(100))
        runs.advance(np.full(100, 0.5))
        runs["plant.velocity"]

    The law of the loop is left out. A command [V] is what the law would have asked for at the sample that is
    shown: hold and delay come after it, and it is not limited. Runs may begin anew at any sample, each by
    itself. Given the commands of a law, a run has the bits of ``simulate(loop, strict=True)``, whatever the
    number of runs and threads.

    Args:
        loop: the loop, as :func:`~hydroservo.simulate` takes it.
        parameters: arrays of shape (sets,) in SI units by path, as :func:`~hydroservo.simulate_batch` takes
            them.
        count: how many runs go side by side.
        threads: how many to use; all cores if None.

    Attributes:
        loop: as it is run, with its law.
        sets: how many sets of parameters there are; one where none are given.
        samples: that a run of the loop's duration has after its first.

    Raises:
        ParameterError: as :func:`~hydroservo.simulate_batch`.
        LoopError: a block that does not fit the loop.
    """

    def __init__(
        self, loop: Loop, parameters: Mapping[str, ArrayLike], count: int, *, threads: int | None = None
    ) -> None:
        from hydroservo.engine.commanded import CompiledSteps, Steps
        from hydroservo.engine.kernel import Recording, RunSpec

        refuse_fmus(loop, "step it from outside")
        self.given, whole = wired(checked(loop)), runnable_loop(loop)
        self.sets = int(np.size(next(iter(parameters.values()), 0.0)))
        self.own = checked_columns(whole, {**parameters, SEED: np.full(self.sets, whole.simulation.seed)})
        columns = self.own | start_columns(checked(loop), self.own)
        self.loop, said = loop_with_steps(whole, hardest_loop(whole, [columns]), strict=True)
        if "warning" in said:
            warnings.warn(str(said["warning"]), HydroservoWarning, stacklevel=2)
        driven = self.loop._replace(controller=Commanded(), metrics=group({}))
        self.period = driven.simulation.period
        state = first_state(driven)
        self.samples = plan_of(driven, state, ()).samples - 1
        study: RunSpec = run_spec(driven, self.samples + 1)
        self.places = {path: i for i, path in enumerate(shown_paths(state))}
        wanted = Recording(
            tuple(f"s.{path}" for path in self.places), watched_paths(state), state_reaches(state)
        )
        with compilation(driven):
            kernel = CompiledSteps(study, wanted, state, tuple(columns), COMMAND)
        self.steps = Steps(kernel, count)
        groups = self.steps.groups
        workers = max(1, min(checked_count(threads, "threads"), groups // LEAST_GROUPS))
        ends = np.linspace(0, groups, workers + 1).astype(int).tolist()
        self.shares = list(pairwise(ends))
        self.pool = pool_of(self.shares)
        self.table, self.seed_row = np.array(list(columns.values())), list(columns).index(SEED)

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "pool": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self.pool = pool_of(self.shares)

    def __deepcopy__(self, memo: dict[int, Any]) -> "SteppedRuns":
        """A copy that goes on from the same state; what never changes is shared."""
        twin = copy(self)
        twin.steps = deepcopy(self.steps, memo)
        return twin

    def __getitem__(self, path: str) -> Numbers:
        """A number of the state of each run at its last sample, such as ``controller.measured.velocity``."""
        return self.steps.shown[:, self.places[path]].copy()

    def table_of(self, paths: Sequence[str]) -> Numbers:
        """Some numbers of the state of each run at its last sample, shape (count, paths)."""
        return self.steps.shown[:, [self.places[path] for path in paths]]

    def loop_of(self, chosen: int, seed: int) -> Loop:
        """The loop with its law, one of the sets of parameters and a seed, to be simulated alone."""
        own = {path: values[chosen].item() for path, values in self.own.items()}
        steps = {"simulation.substeps": self.loop.simulation.substeps}
        found: Loop = replace(self.given, own | steps | {SEED: seed})
        return found

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Which runs diverged since they began, where a number was not finite, or beyond physical reach."""
        return self.steps.lost

    def begin(self, which: WholeNumbers, sets: WholeNumbers, seeds: WholeNumbers) -> None:
        """Put some runs at their first sample, and measure there."""
        check_whole("which", which, self.steps.runs, np.size(which))
        check_whole("sets", sets, self.sets, np.size(which))
        check_whole("seeds", seeds, LARGEST_WHOLE, np.size(which))
        numbers = self.table[:, sets]
        numbers[self.seed_row] = seeds
        self.steps.give(which, numbers)
        with compilation(self.loop):
            self.steps.begin(which, self.period)

    def advance(self, commands: Numbers) -> None:
        """Hold a command [V] in each run until its next sample, and measure there.

        Args:
            commands: of shape (count,).
        """
        if np.shape(commands) != (self.steps.runs,) or not np.isfinite(commands).all():
            problem = f"must be {self.steps.runs} finite numbers, one for each run"
            raise ParameterError("commands", commands, problem)
        self.steps.command(commands)
        with compilation(self.loop):
            if self.pool is None:
                self.steps.advance(0, self.steps.groups, self.period)
            else:
                period, (firsts, lasts) = repeat(self.period), zip(*self.shares, strict=True)
                list(self.pool.map(self.steps.advance, firsts, lasts, period))


def pool_of(shares: Sequence[tuple[int, int]]) -> ThreadPoolExecutor | None:
    """A thread for each share of the runs; None where one is enough."""
    return ThreadPoolExecutor(len(shares)) if len(shares) > 1 else None


def check_whole(name: str, numbers: WholeNumbers, end: int, count: int) -> None:
    """Refuse what are not so many whole numbers from 0 to below an end."""
    given = np.asarray(numbers)
    whole = given.shape == (count,) and given.dtype.kind in "iu"
    if not (whole and ((given >= 0) & (given < end)).all()):
        raise ParameterError(name, numbers, f"must be {count} whole numbers from 0 to {end - 1}")


def shown_paths(state: Block) -> list[str]:
    """What of a state is shown: all but what sensors and holds remember."""
    return [path for path, _ in leaves(state) if not path.startswith(("sensors.", "hold."))]


class CommandedState(NamedTuple):
    """The command, which others write, and what was measured at the last sample."""

    u: Annotated[float, Field("V", "command given from outside")] = 0.0
    measured: Measurement = NOTHING


@role(Controller)
class Commanded(NamedTuple):
    """No law: the command is what stands in its state, written there from outside between two samples.

    Source: a definition.
    Fails to act by itself: what nobody exchanges stays.
    """

    def init(self) -> CommandedState:
        return CommandedState()

    def step(self, s: CommandedState, y: Measurement, r: Demand, dt: float) -> CommandedState:
        return CommandedState(s.u, y)
