"""Whether the blocks of a loop fit together, and one line about it where they do not."""

import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import isnan
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

from hydroservo.control.loop import Loop
from hydroservo.control.metrics import monitors_of
from hydroservo.core.block import Block, is_block, values
from hydroservo.core.errors import LoopError
from hydroservo.core.signals import Measurement
from hydroservo.cosimulation import ForeignMachine
from hydroservo.machine.sensors.missing import (
    Lacking,
    MissingSignalError,
    Unmeasured,
    missing_signals,
    sensors_for,
)
from hydroservo.runs.returns import with_checked_returns


@contextmanager
def compilation(loop: Loop) -> Iterator[None]:
    """Turns what a compiler says, or a block stumbles over, into one line about the loop."""
    from hydroservo.engine.native import CompileError, RunError

    law = named(loop.controller, "controller")
    try:
        yield
    except CompileError as error:
        check_returns(loop)
        where = method_at(loop, error.places)
        raise LoopError(f"the loop with {law} cannot be compiled: {where}{error}") from None
    except RunError as error:
        cause = error.__cause__
        where = f" ({place_of(cause)})" if cause else "; compiled=False shows it"
        raise LoopError(f"the loop with {law} stopped: {error}{where}") from None


def first_state(loop: Loop) -> Block:
    """The initial state, from which a sample in plain Python shows that the blocks fit together."""
    try:
        return fitting_state(loop)
    except LoopError as error:
        problem = error
    check_returns(loop)
    raise problem


def check_returns(loop: Loop) -> None:
    """Name the method that returns what its role does not, where there is one."""
    judged = with_checked_returns(loop)
    try:
        state = judged.init()
        after = judged.sample(state, 0.0, loop.simulation.period)
        judged.deriv(0.0, loop.machine(state), judged.held(after))
    except LoopError:
        raise
    except Exception:  # whatever else a block stumbles over is for the caller to say
        return


def fitting_state(loop: Loop) -> Block:
    """The initial state of a loop whose blocks fit, by one sample."""
    law = named(loop.controller, "controller")
    try:
        state = loop.init()
        after = lacking(loop).sample(state, 0.0, loop.simulation.period) if has_floats(state) else state
        if has_floats(after):
            loop.deriv(0.0, loop.machine(state), loop.held(after))
    except MissingSignalError as error:
        if error.name in unanswered(loop):
            plant: Any = loop.plant
            file = plant.foreign.name
            raise LoopError(
                f"{law} needs {error}, which the FMU {file} does not answer; "
                f"name its variable in plant.signals.{error.name}, or use a law that does not need it"
            ) from None
        given_by = sensors_for(loop.sensors, error.name)
        raise LoopError(
            f"{law} needs {error}, which {named(loop.sensors, 'sensors')} does not measure; "
            f"add {given_by}, or use a law that does not need it"
        ) from None
    except Exception as error:  # whatever a block stumbles over
        raise LoopError(f"{at_fault(loop, error)}: {error} ({place_of(error)})") from None
    for (path, before), (path_after, value) in zip(parts(state), parts(after), strict=False):
        if path != path_after or (is_block(before) and type(before) is not type(value)):
            raise LoopError(
                f"state {path} is a {type(before).__name__}, and {path_after} a {type(value).__name__} after "
                "one step; a step returns its state's type"
            )
        if not is_block(before) and not (type(before) is float and isinstance(value, (float, Unmeasured))):
            raise LoopError(f"state {path} {problem_of(before if type(before) is not float else value)}")
    check_monitors(loop, after)
    return state


def has_floats(state: Block) -> bool:
    """Whether the numbers of a state are floats, so that a sample may compute with them."""
    return all(is_block(value) or isinstance(value, (float, Unmeasured)) for _, value in parts(state))


def problem_of(value: object) -> str:
    """What is wrong with a number of a state that is not a float."""
    several = "hydroservo.core.vectors.vector makes a record of floats"
    ways = {bool: "write 1.0 or 0.0", int: "write 1.0, not 1"}
    way = "write float(...)" if isinstance(value, float) else ways.get(type(value), several)
    return f"is of type {type(value).__name__}: must be a float in init and after each step; {way}"


def signals_used(loop: Loop) -> list[str]:
    """The fields of :class:`~hydroservo.core.signals.Measurement` that a law reads, seen at a sample."""
    return [name for name in Measurement._fields if is_used(loop, name)]


def is_used(loop: Loop, signal: str) -> bool:
    """Whether a sample computes with a signal."""
    try:
        loop._replace(sensors=Lacking(loop.sensors, (signal,))).sample(
            loop.init(), 0.0, loop.simulation.period
        )
    except MissingSignalError:
        return True
    return False


def check_monitors(loop: Loop, state: Block) -> None:
    """Let each monitor hear one step in plain Python."""
    for name, one in monitors_of(loop).items():
        try:
            before = one.init()
            after = one.step(before, loop, state, 0.0, loop.simulation.period)
            metrics = one.values(before)
        except Exception as error:  # whatever a block stumbles over
            problem = f"{error} ({place_of(error)})"
            raise LoopError(
                f"the metric {name} ({type(one).__name__}) does not fit this loop: {problem}"
            ) from None
        if type(after) is not type(before) or not all(isinstance(value, float) for value in values(after)):
            raise LoopError(f"the metric {name}: a step must return a state of init's type, with floats only")
        if not is_block(metrics) or not all(isinstance(value, float | bool) for value in metrics):
            raise LoopError(f"the metric {name}: values must be a NamedTuple of floats and flags")


def at_fault(loop: Loop, error: Exception) -> str:
    """Which block does not fit: the last one that ran, or that lacks what was asked of it."""
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    ran = [getattr(error, "obj", None), *(frame.f_locals.get("self") for frame in reversed(frames))]
    for block in filter(is_block, ran):
        for name, own in loop._asdict().items():
            if any(part is block for _, part in parts(own)):
                return f"the {name} {named(own, name)} does not fit this loop"
    return "the blocks of this loop do not fit"


def method_at(loop: Loop, places: Sequence[tuple[str, int]]) -> str:
    """The method of a block that the first of some places is in which are in any, with file and line."""
    classes = {type(block) for _, block in parts(loop) if is_block(block)}
    methods = [(cls, one) for cls in classes for one in vars(cls).values() if isinstance(one, FunctionType)]
    inside = (
        f"{cls.__name__}.{method.__name__} ({file}, line {line}): "
        for file, line in places
        for cls, method in methods
        if has_line(method.__code__, file, line)
    )
    return next(inside, "")


def has_line(code: CodeType, file: str, line: int) -> bool:
    """Whether a line of a file, its path absolute, is one of a function's."""
    lines = [code.co_firstlineno, *(number for *_, number in code.co_lines() if number is not None)]
    return str(Path(code.co_filename).absolute()) == file and min(lines) <= line <= max(lines)


def place_of(error: BaseException) -> str:
    """The file and line that an error came from."""
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return f"{frame.filename}, line {frame.lineno}"


def lacking(loop: Loop) -> Loop:
    """The loop with sensors that raise :class:`MissingSignalError` once a signal they lack is used."""
    return loop._replace(sensors=Lacking(loop.sensors, (*missing_signals(loop.sensors), *unanswered(loop))))


def unanswered(loop: Loop) -> tuple[str, ...]:
    """What sensors do not measure because the machine is an FMU that does not answer it."""
    if not isinstance(loop.plant, ForeignMachine):
        return ()
    state, period = loop.init(), loop.simulation.period
    seen = loop.seen(state, 0.0)
    sensors = loop.sensors.step(state.sensors, seen, loop.draws(0.0, period), period)
    measured = loop.sensors.measure(sensors, seen, 0.0)
    return tuple(name for name in Measurement._fields if isnan(getattr(measured, name)))


def named(block: Block, inner: str) -> str:
    """What a block is called in a message: "TSMC in DAC" if the field ``inner`` holds what it wraps."""
    name = type(block).__name__
    return f"{named(getattr(block, inner), inner)} in {name}" if hasattr(block, inner) else name


def parts(state: Block, path: str = "") -> Iterator[tuple[str, Any]]:
    """A state, the states nested in it and their numbers, with their dotted paths."""
    yield path, state
    if is_block(state):
        for name in state._fields:
            yield from parts(getattr(state, name), f"{path}.{name}" if path else name)
