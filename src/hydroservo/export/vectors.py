"""Test vectors: what an exported unit was given, sample by sample, and the states that it must have after."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop, LoopState
from hydroservo.core.block import Block, leaves
from hydroservo.core.errors import LoopError
from hydroservo.core.signals import Demand, Measurement
from hydroservo.export.parts import Command, ExternalForce, Instant, block_of, with_its_substeps
from hydroservo.export.unit import CModule, Part
from hydroservo.language.names import place_in_c
from hydroservo.runs.fitting import compilation, first_state
from hydroservo.runs.kernels import Mode, kernel_of, recording_of, run_spec
from hydroservo.runs.run import runnable_loop
from hydroservo.runs.trace import plan_of

STRETCHES = 10
IN_A_ROW = 50  # samples in each stretch
RECOVERY = 20  # good samples after a bad one
HUGE = 1e300

Records = Mapping[str, Block]  # the arguments of one step by name


class Vectors(NamedTuple):
    """Samples to replay from ``init``, one after the other.

    Attributes:
        inputs: a row for each sample, a column for each signal of the arguments, in their order.
        expected: a row for each sample, a column for each number of the state after it.
        made: where the inputs come from, in sentences.
    """

    inputs: NDArray[np.float64]
    expected: NDArray[np.float64]
    made: str


class Listener(NamedTuple):
    """A law that changes nothing and writes down what it is given, its command in the scenario's unit."""

    heard: list[Records]
    per_volt: float

    def init(self) -> None: ...

    def step(self, s: Block, y: Measurement, r: Demand, dt: float) -> Block:
        self.heard.append({"measurement": y.with_command(self.per_volt * y.command), "demand": r})
        return s


def make_vectors(loop: Loop, part: Part, unit: CModule) -> Vectors:
    """A part of a loop, run in plain Python on what it is given in the closed loop that it is in.

    The inputs are those of ten stretches of 50 samples, spread evenly over the scenario; the part then runs
    through all of them, one after the other, in plain Python from its ``init``. For a controller in double
    precision a sample without its first reading and one of huge numbers follow, each before 20 good samples.
    A whole loop and a demand have no inputs; they run through their first 500 samples.
    """
    loop = runnable_loop(loop) if part is Part.DEMAND else with_its_substeps(runnable_loop(loop))
    inputs, made = closed_loop_inputs(loop, part)
    if part is Part.CONTROLLER and unit.real == "double":
        reading = next((place for place in unit.places("measurement") if place != "command"), "velocity")
        inputs += bad_inputs(inputs, reading)
        made += (
            f" Then a sample whose {reading.replace('_', ' ')} is not a number, {RECOVERY} good ones, one "
            f"whose inputs are all {HUGE:g}, and {RECOVERY} good ones."
        )
    return Vectors(
        input_rows(unit, inputs),
        rows_at(replay_states(block_of(loop, part), inputs), [signal.place for signal in unit.states]),
        f"{made} All ran one after the other in plain Python, in double precision.",
    )


def closed_loop_inputs(loop: Loop, part: Part) -> tuple[list[Records], str]:
    """What a part of a loop is given at the samples of all stretches, and where that comes from, in words."""
    if part in (Part.DEMAND, Part.LOOP):
        made = f"They are the first samples of the {part}, which has no inputs."
        return [{}] * (STRETCHES * IN_A_ROW), made
    period = loop.simulation.period
    listener = Listener([], float(loop.command.per_volt))
    watched = loop._replace(controller=listener) if part is Part.CONTROLLER else loop
    after = [(t, watched.sample(s, t, period)) for t, s in closed_loop(loop)]
    inputs = listener.heard if part is Part.CONTROLLER else machine_inputs(loop, part, after)
    pushed = (
        "" if part is Part.CONTROLLER else " A tenth of the oil's force acts besides in every other stretch."
    )
    return inputs, (
        f"The inputs are those of the {part} in the closed loop of the scenario: {len(inputs)} samples, in "
        f"up to {STRETCHES} stretches spread evenly over its {loop.simulation.duration:g} s.{pushed}"
    )


def machine_inputs(loop: Loop, part: Part, after: Iterable[tuple[float, LoopState]]) -> list[Records]:
    """What a machine or its equations are given at samples whose controller has run."""
    inputs: list[Records] = []
    for i, (t, s) in enumerate(after):
        pushes = (i // IN_A_ROW) % 2
        records: Records = {
            "command": Command(float(loop.command.per_volt) * s.controller.u),
            "external": ExternalForce(0.1 * loop.plant.hydraulic_force(s.plant) * pushes),
        }
        if part is Part.EQUATIONS:
            records = {**records, "instant": Instant(t, loop.load.next_jump(t)), "machine": loop.machine(s)}
        inputs.append(records)
    return inputs


def closed_loop(loop: Loop) -> Iterator[tuple[float, LoopState]]:
    """The instants and states before the samples of all stretches of a strict run, while it is finite."""
    state, period = first_state(loop), loop.simulation.period
    plan = plan_of(loop, state, ())
    nothing = np.empty((1, 0))
    with compilation(loop):
        study, wanted = run_spec(loop, plan.samples), recording_of(loop, state, plan.paths)
        run = kernel_of(study, wanted, state, Mode(compiled=True, strict=True))
    done = 0
    for sample in stretch_numbers(plan.samples):
        with compilation(loop):
            reached = run.advance(done, sample, period, plan.samples, nothing)
        if reached < sample:
            return
        yield sample * period, run.state
        done = sample


def stretch_numbers(samples: int) -> Iterator[int]:
    """The numbers of the samples in all stretches; of all there are, where they are few."""
    if samples <= STRETCHES * IN_A_ROW:
        yield from range(samples)
        return
    for start in np.linspace(0, samples - IN_A_ROW, STRETCHES).round():
        yield from range(int(start), int(start) + IN_A_ROW)


def bad_inputs(good: Sequence[Records], reading: str) -> list[Records]:
    """A sample without a reading and one of huge numbers, each before good ones."""
    last = good[-1]
    blind = {**last, "measurement": last["measurement"]._replace(**{reading: math.nan})}
    huge = {name: type(record)(*[HUGE] * len(record)) for name, record in last.items()}
    after = list(good[-RECOVERY:])
    return [blind, *after, huge, *after]


def replay_states(block: Block, inputs: Iterable[Records]) -> list[Block]:
    """A block's state after each sample, from its ``init`` on."""
    state, states = block.init(), []
    for records in inputs:
        try:
            state = block.step(state, **records)
        except (ArithmeticError, ValueError) as error:
            given = ", ".join(map(str, records.values()))
            raise LoopError(f"no test vectors: Python stopped with {error!r}, given {given}") from None
        states.append(state)
    return states


def input_rows(unit: CModule, inputs: Sequence[Records]) -> NDArray[np.float64]:
    """What steps read of their arguments, a row for each sample, in the order of their signals."""
    columns = [
        rows_at([records[one.name] for records in inputs], [signal.place for signal in one.signals])
        for one in unit.arguments
    ]
    return np.hstack([np.empty((len(inputs), 0)), *columns])


def rows_at(records: Sequence[Block], places: Sequence[str]) -> NDArray[np.float64]:
    """The numbers of records of one type in Python that have some places in their record in C."""
    own = {place_in_c(path): path for path, _ in leaves(records[0])}
    numbers = [attrgetter(own[place]) for place in places]
    return np.array([[float(number(record)) for number in numbers] for record in records])
