"""What an environment asks of an agent: observations, actions, rewards, and when an episode ends."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.block import replace
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import Field
from hydroservo.core.signals import Demand, Measurement
from hydroservo.core.validation import checked_number, whole_number
from hydroservo.limits.command import command_limits
from hydroservo.machine.sensors.missing import missing_signals
from hydroservo.runs.arguments import checked_mapping
from hydroservo.runs.cautions import quietly
from hydroservo.runs.commanded import SteppedRuns
from hydroservo.runs.run import simulate
from hydroservo.scenario import Assembly, assemble, parameter_draws
from hydroservo.scenario.other_tables import Deviation
from hydroservo.scenario.ranges import as_entries, relative

BEYOND = 10.0  # sizes, at which an observation is cut off
SEEDS = 2**53  # of the random numbers of an episode
LARGEST_CHANGE = 4.0  # of a command from sample to sample, by its limit, squared
WEIGHT = Field("", "weight in the reward", at_least=0, at_most=1e6)

Numbers = NDArray[np.float64]
Flags = NDArray[np.bool_]
Whole = NDArray[np.int64]
MOST_DRAWS = 100_000  # sets of parameters, each with a start of its own to be found

Ranges = Mapping[str, str | tuple[float, float]]


class SampleOutcome(NamedTuple):
    """What a sample period comes to in each of some runs."""

    observations: Numbers
    rewards: Numbers
    terminated: Flags
    truncated: Flags


class Task:
    """Runs of a scenario side by side, each with an agent in place of the law.

    With e = (r - y)/E of the true signal y at the end of the sample period, E half of the demand's range, and
    the action a, the command u by its limit::

        reward = -error_weight min(e^2, 1) - effort_weight (a_k - a_(k-1))^2

    An episode ends where the run diverges or the piston leaves its stroke. It is then charged the most that
    the samples left could cost, error_weight + 4 effort_weight each, so that ending early never pays. It is
    cut off at the scenario's duration.

    Args:
        count: how many runs.
        scenario: its name or file, or a loop, which has no uncertainty.
        signal: that the scenario must control, "velocity" or "position".
        changes: of the scenario, as of :func:`~hydroservo.scenario.load_scenario`.
        plugins: Python files with blocks that the scenario names; they are executed.
        vary: what differs between episodes besides the scenario's uncertainty, as of
            :func:`~hydroservo.scenario.parameter_draws.draws`.
        draws: how many sets of such numbers there are, of which each episode takes one; one where nothing
            differs.
        error_weight: of the squared error.
        effort_weight: of the squared change of the command.
        threads: how many to use; all cores if None.

    Attributes:
        signals: paths of what is observed: what the sensors measure, then the demand and its rates.
        scales: by which these are divided, in SI units.
        limit: of the command [V].
        machine: the set of parameters that each run has.
        seed: of the random numbers of each run.

    Raises:
        ScenarioError: no such scenario, or a wrong one.
        ParameterError: an argument out of its range, or a law whose command has no limit.
    """

    def __init__(
        self,
        count: int,
        scenario: str | Path | Loop,
        signal: str,
        *,
        changes: Mapping[str, object] | None = None,
        plugins: Sequence[str | Path] = (),
        vary: Ranges | None = None,
        draws: int = 64,
        error_weight: float = 1.0,
        effort_weight: float = 0.1,
        threads: int | None = None,
    ) -> None:
        self.error_weight = float(checked_number(error_weight, "error_weight", WEIGHT, float))
        self.effort_weight = float(checked_number(effort_weight, "effort_weight", WEIGHT, float))
        assembly = environment_assembly(scenario, changes, plugins, signal)
        loop, self.count = assembly.loop, count
        self.limit = command_limits(loop).limit
        self.runs = SteppedRuns(loop, draw_parameter_sets(assembly, vary, draws), count, threads=threads)
        lacking = missing_signals(self.runs.loop.sensors)
        measured = [f"controller.measured.{name}" for name in Measurement._fields if name not in lacking]
        self.signals = measured + [f"reference.{name}" for name in Demand._fields]
        self.scales, self.error_scale = signal_sizes(loop, self.signals)
        self.stroke = float(getattr(self.runs.loop.plant, "stroke", np.inf))
        self.actions = np.zeros(count)
        self.sample, self.machine, self.seed = (np.zeros(count, dtype=np.int64) for _ in range(3))

    @property
    def observation_space(self) -> spaces.Space[Numbers]:
        """What was measured and what is demanded, by their sizes."""
        return spaces.Box(-BEYOND, BEYOND, (len(self.signals),), np.float64)

    @property
    def action_space(self) -> spaces.Space[Numbers]:
        """The command by its limit."""
        return spaces.Box(-1.0, 1.0, (1,), np.float64)

    def loop_of(self, run: int) -> Loop:
        """The loop of a run's episode with its law, for ``hydroservo.simulate``."""
        return self.runs.loop_of(int(self.machine[run]), int(self.seed[run]))

    def begin(self, which: Whole, generators: Sequence[np.random.Generator]) -> None:
        """New episodes of some runs, each drawn from its own generator."""
        for run in which.tolist():
            self.machine[run] = generators[run].integers(self.runs.sets)
            self.seed[run] = generators[run].integers(SEEDS)
        self.runs.begin(which, self.machine[which], self.seed[which])
        self.actions[which], self.sample[which] = 0.0, 0

    def advance(self, actions: ArrayLike) -> SampleOutcome:
        """A sample period of all runs.

        Raises:
            ParameterError: an action that is no number, or too few or many of them.
        """
        try:
            given = np.asarray(actions, dtype=np.float64)
        except (TypeError, ValueError):
            given = np.empty(0)
        if given.size != self.count or not np.isfinite(given).all():
            raise ParameterError("action", actions, f"must be {self.count} finite numbers in [-1, 1]")
        given = np.clip(given.reshape(self.count), -1.0, 1.0)
        self.runs.advance(self.limit * given)
        self.sample += 1
        change, self.actions = given - self.actions, given
        ended = self.runs.lost | self.left_stroke()
        left = self.runs.samples - self.sample
        costs = self.costs(change) + ended * left * (self.error_weight + LARGEST_CHANGE * self.effort_weight)
        return SampleOutcome(self.observations(), -costs, ended, left <= 0)

    def observations(self) -> Numbers:
        """What each run shows, shape (runs, signals); 0 where a signal is lost."""
        seen = self.runs.table_of(self.signals) / self.scales
        return np.clip(np.nan_to_num(seen, nan=0.0), -BEYOND, BEYOND)

    def costs(self, change: Numbers) -> Numbers:
        """What the sample period cost; the most where the error is no number."""
        error = (self.runs["reference.value"] - self.runs["controlled.value"]) / self.error_scale
        squares = np.minimum(np.nan_to_num(error * error, nan=1.0), 1.0)
        return self.error_weight * squares + self.effort_weight * change * change

    def left_stroke(self) -> Flags:
        """Which pistons are beyond an end of their stroke."""
        position = self.runs["plant.position"]
        return (position < 0.0) | (position > self.stroke)


def signal_sizes(loop: Loop, paths: Sequence[str]) -> tuple[NDArray[np.float64], float]:
    """The largest absolute values of what is seen of a loop, and half of its demand's range.

    They are of a run under its own law; 1 of what stays 0, and a constant demand's absolute value.
    """
    at_samples = replace(loop, {"simulation.record_period": loop.simulation.period})
    recorded = ["controller.u", "reference.value"]
    data = quietly(simulate)(at_samples, record=recorded, metrics=[], strict=True)
    commands, demand = (np.nan_to_num(data[path].to_numpy()) for path in recorded)
    substeps = data.attrs.get("substeps", loop.simulation.substeps)
    runs = SteppedRuns(replace(loop, {"simulation.substeps": substeps}), {}, 1)
    first = np.zeros(1, dtype=np.int64)
    runs.begin(first, sets=first, seeds=np.array([loop.simulation.seed]))
    largest = np.zeros(len(paths))
    for command in commands[:-1]:
        largest = np.fmax(largest, [abs(runs[path].item()) for path in paths])
        runs.advance(np.array([command]))
    spread = 0.5 * float(np.ptp(demand)) or float(np.max(np.abs(demand)))
    return np.where(np.isfinite(largest) & (largest > 0.0), largest, 1.0), spread or 1.0


def environment_assembly(
    source: str | Path | Loop,
    changes: Mapping[str, object] | None,
    plugins: Sequence[str | Path],
    signal: str,
) -> Assembly:
    """The scenario of an environment."""
    if isinstance(source, Loop):
        for name, value in (("changes", changes), ("plugins", plugins)):
            if value:
                problem = "must be left out where scenario is a loop; pass it to load_scenario"
                raise ParameterError(name, value, problem)
        found = parameter_draws.assembly_of_loop(source)
    else:
        found = assemble(source, changes, plugins)
    meaning = found.loop.controls.declared().meaning
    if meaning != signal:
        name = "a loop" if isinstance(source, Loop) else str(source)
        raise ParameterError("scenario", name, f"must control the {signal}; it controls the {meaning}")
    return found


def draw_parameter_sets(scenario: Assembly, vary: Ranges | None, draws: int) -> parameter_draws.Columns:
    """The sets of parameters that episodes have, by path in SI units; the scenario's seed says which.

    What the scenario's uncertainty names deviates by one factor a set, drawn evenly from -1 to 1 times its
    scale, so that numbers which go together stay together. What is to vary besides is drawn by itself.
    """
    own = checked_mapping("vary", {} if vary is None else vary, "paths to ranges")
    whole_number("draws", draws, 1, MOST_DRAWS)
    seed, wide = scenario.loop.simulation.seed, largest_deviations(scenario)
    ranges = {path: relative(-abs(most), abs(most)) for path, most in wide.items() if path not in own}
    together = parameter_draws.uniform_numbers(seed, "uncertainty.scale", draws)
    varied = parameter_draws.variations(scenario, as_entries({**ranges, **own}))
    values = {}
    for one in varied:
        share = parameter_draws.uniform_numbers(seed, one.path, draws) if one.path in own else together
        values[one.path], _ = parameter_draws.draw_values(
            one, share if one.path in own or wide[one.path] > 0.0 else 1.0 - share
        )
    return parameter_draws.loop_parameters(scenario, varied, values)


def largest_deviations(scenario: Assembly) -> dict[str, float]:
    """How far a scenario's uncertainty leads each number from its nominal value, relative, where it does."""
    said = {**scenario.truth.arguments, **scenario.truth.numbers}
    found = {path: one.scale * one.relative for path, one in said.items() if isinstance(one, Deviation)}
    return {path: most for path, most in found.items() if most != 0.0}
