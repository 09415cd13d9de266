"""Whether the blocks of a loop fit together, and one line about it where they do not."""

import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from math import isnan
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, get_type_hints

from hydroservo.control.loop import Loop
from hydroservo.control.metrics import monitors_of
from hydroservo.core.block import Block, is_block, leaves, values
from hydroservo.core.errors import LoopError, short
from hydroservo.core.roles import (
    Controller,
    Differentiator,
    Filter,
    Observer,
    Plant,
    PositionSensor,
    PressureSensor,
    VelocityEstimator,
)
from hydroservo.core.roles.saying import is_role
from hydroservo.core.signals import Measurement
from hydroservo.cosimulation import ForeignMachine
from hydroservo.machine.sensors.missing import (
    Lacking,
    MissingSignalError,
    Unmeasured,
    missing_signals,
    sensors_for,
)

STATES: dict[Any, tuple[str, ...]] = {  # the numbers that others read in the state of a role
    Controller: ("u",),
    Observer: ("d1", "d2", "s1", "s2", "velocity", "hydraulic_force"),
    Differentiator: ("rate",),
    Filter: ("value",),
    Plant: ("velocity", "position"),
    PositionSensor: ("value",),
    VelocityEstimator: ("value",),
    PressureSensor: ("value",),
}


@cache
def loop_roles() -> dict[str, type]:
    """The role of each block of a loop, by its name there."""
    return {name: kind for name, kind in get_type_hints(Loop).items() if is_role(kind)}


@cache
def return_type(role: type, name: str) -> Any:
    """What a method of a role returns."""
    return get_type_hints(getattr(role, name))["return"]


class CheckedReturns:
    """A block whose methods return what its role says, or raise a LoopError.

    Attributes:
        block: the block.
        role: its role.
        place: its name in the loop.
    """

    def __init__(self, block: Block, role: type, place: str) -> None:
        self.block, self.role, self.place = block, role, place

    def __getattr__(self, name: str) -> Any:
        found = getattr(self.block, name)
        if not isinstance(vars(self.role).get(name), FunctionType):
            return found

        def call(*arguments: Any) -> Any:
            result = found(*arguments)
            problem = self.problem(name, arguments, result)
            if problem:
                cls = type(self.block).__name__
                raise LoopError(
                    f"the {self.place} {cls}: {name} returns {short(result)}{problem}{method_place(found)}"
                )
            return result

        return call

    def problem(self, name: str, arguments: tuple[Any, ...], result: Any) -> str:
        """How a result is not what a method is to return; "" where it is."""
        wanted = return_type(self.role, name)
        if name == "init" and not is_block(result):
            return "; it must return the first state, a NamedTuple of floats"
        if name == "init":
            lost = [one for one in STATES.get(self.role, ()) if one not in result._fields]
            return f"; it must have {lost[0]}" if lost else missing_number(result)
        if name in ("step", "deriv") and type(result) is not type(arguments[0]):
            state = type(arguments[0]).__name__
            return f"; it must return a {state}, as init does: a {name} returns its state's type"
        if hasattr(wanted, "_fields") and not set(wanted._fields) <= set(getattr(result, "_fields", ())):
            return f"; it must return a {wanted.__name__}"
        if wanted is float and not is_number_like(result):
            return "; it must return a float"
        return missing_number(result)


def missing_number(result: Any) -> str:
    """Which number of a record is none."""
    empty = [path for path, value in leaves(result) if not is_number_like(value)] if is_block(result) else []
    return f", whose {empty[0]} is not a number" if empty else ""


def is_number_like(value: Any) -> bool:
    """Whether something may pass for a number in plain Python."""
    return value is not None and not isinstance(value, str | tuple | list | dict)


def method_place(method: Any) -> str:
    """The file and line of a method, in brackets."""
    code = getattr(method, "__code__", None)
    return f" ({code.co_filename}, line {code.co_firstlineno})" if code is not None else ""


@contextmanager
def compilation(loop: Loop) -> Iterator[None]:
    """Turns what a compiler says, or a block stumbles over, into one line about the loop."""
    from hydroservo.engine.native import CompileError, RunError

    law = name_with_inner(loop.controller, "controller")
    try:
        yield
    except CompileError as error:
        check_returns(loop)
        where = method_at(loop, error.places)
        raise LoopError(f"the loop with {law} cannot be compiled: {where}{error}") from None
    except RunError as error:
        cause = error.__cause__
        where = f" ({error_place(cause)})" if cause else "; compiled=False shows it"
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
    parts: dict[str, Any] = {
        name: CheckedReturns(getattr(loop, name), role, name) for name, role in loop_roles().items()
    }
    judged = loop._replace(**parts)
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
    law = name_with_inner(loop.controller, "controller")
    try:
        state = loop.init()
        after = (
            with_missing_sensors(loop).sample(state, 0.0, loop.simulation.period)
            if has_floats(state)
            else state
        )
        if has_floats(after):
            loop.deriv(0.0, loop.machine(state), loop.held(after))
    except MissingSignalError as error:
        if error.name in unanswered_signals(loop):
            plant: Any = loop.plant
            file = plant.foreign.name
            raise LoopError(
                f"{law} needs {error}, which the FMU {file} does not answer; "
                f"name its variable in plant.signals.{error.name}, or use a law that does not need it"
            ) from None
        given_by = sensors_for(loop.sensors, error.name)
        raise LoopError(
            f"{law} needs {error}, which {name_with_inner(loop.sensors, 'sensors')} does not measure; "
            f"add {given_by}, or use a law that does not need it"
        ) from None
    except Exception as error:  # whatever a block stumbles over
        raise LoopError(f"{block_at_fault(loop, error)}: {cause(error)} ({error_place(error)})") from None
    for (path, before), (path_after, value) in zip(state_parts(state), state_parts(after), strict=False):
        if path != path_after or (is_block(before) and type(before) is not type(value)):
            raise LoopError(
                f"state {path} is a {type(before).__name__}, and {path_after} a {type(value).__name__} after "
                "one step; a step returns its state's type"
            )
        if not is_block(before) and not (type(before) is float and isinstance(value, (float, Unmeasured))):
            raise LoopError(f"state {path} {float_problem(before if type(before) is not float else value)}")
    check_monitors(loop, after)
    return state


def has_floats(state: Block) -> bool:
    """Whether the numbers of a state are floats, so that a sample may compute with them."""
    return all(is_block(value) or isinstance(value, (float, Unmeasured)) for _, value in state_parts(state))


def float_problem(value: object) -> str:
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
            problem = f"{error} ({error_place(error)})"
            raise LoopError(
                f"the metric {name} ({type(one).__name__}) does not fit this loop: {problem}"
            ) from None
        if type(after) is not type(before) or not all(isinstance(value, float) for value in values(after)):
            raise LoopError(f"the metric {name}: a step must return a state of init's type, with floats only")
        if not is_block(metrics) or not all(isinstance(value, float | bool) for value in metrics):
            raise LoopError(f"the metric {name}: values must be a NamedTuple of floats and flags")


def block_at_fault(loop: Loop, error: Exception) -> str:
    """Which block does not fit: the last one that ran, or that lacks what was asked of it."""
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    ran = [getattr(error, "obj", None), *(frame.f_locals.get("self") for frame in reversed(frames))]
    for block in filter(is_block, ran):
        for name, own in loop._asdict().items():
            if any(part is block for _, part in state_parts(own)):
                return f"the {name} {name_with_inner(own, name)} does not fit this loop"
    return "the blocks of this loop do not fit"


def cause(error: Exception) -> str:
    """What went wrong at the start, which runs in plain Python, and what to write instead."""
    if isinstance(error, ZeroDivisionError):
        return "it divides by zero at the start; guard it, as in a / b if b != 0.0 else 0.0"
    return str(error)


def method_at(loop: Loop, places: Sequence[tuple[str, int]]) -> str:
    """The method of a block that the first of some places is in which are in any, with file and line."""
    classes = {type(block) for _, block in state_parts(loop) if is_block(block)}
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


def error_place(error: BaseException) -> str:
    """The file and line that an error came from."""
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return f"{frame.filename}, line {frame.lineno}"


def with_missing_sensors(loop: Loop) -> Loop:
    """The loop with sensors that raise :class:`MissingSignalError` once a signal they lack is used."""
    return loop._replace(
        sensors=Lacking(loop.sensors, (*missing_signals(loop.sensors), *unanswered_signals(loop)))
    )


def unanswered_signals(loop: Loop) -> tuple[str, ...]:
    """What sensors do not measure because the machine is an FMU that does not answer it."""
    if not isinstance(loop.plant, ForeignMachine):
        return ()
    state, period = loop.init(), loop.simulation.period
    seen = loop.seen(state, 0.0)
    sensors = loop.sensors.step(state.sensors, seen, loop.draws(0.0, period), period)
    measured = loop.sensors.measure(sensors, seen, 0.0)
    return tuple(name for name in Measurement._fields if isnan(getattr(measured, name)))


def name_with_inner(block: Block, inner: str) -> str:
    """What a block is called in a message: "TSMC in DAC" if the field ``inner`` holds what it wraps."""
    name = type(block).__name__
    return f"{name_with_inner(getattr(block, inner), inner)} in {name}" if hasattr(block, inner) else name


def state_parts(state: Block, path: str = "") -> Iterator[tuple[str, Any]]:
    """A state, the states nested in it and their numbers, with their dotted paths."""
    yield path, state
    if is_block(state):
        for name in state._fields:
            yield from state_parts(getattr(state, name), f"{path}.{name}" if path else name)
