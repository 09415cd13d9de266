"""What the methods of a block must do, tried with many random parameters, states and inputs."""

import inspect
import math
from collections.abc import Callable, Sequence
from functools import cache, lru_cache
from typing import Any

from hypothesis.strategies import SearchStrategy

from hydroservo.core.block import Block, is_block, leaves
from hydroservo.core.roles import Monitor, Sensors
from hydroservo.engine.compiling import compiled_function
from hydroservo.engine.native import CompileError
from hydroservo.machine.sensors.missing import missing_signals
from hydroservo.testing.case import Case, bits
from hydroservo.testing.drawing import ORDINARY, WIDE, arguments, random_blocks

STEPS = 4
MAY_BE_INFINITE = {"init", "next_jump"}  # there may be no jump

Draw = Callable[..., Any]
Method = Callable[..., Any]
Run = tuple[Block, list[list[Any]]]  # a block, and the arguments of successive calls of a method


def check_kinds(case: Case, draw: Draw) -> None:
    """Each method returns what its role says: floats, the records of signals, a state of the type of init."""
    for name in case.compiled_methods():
        block, inputs = draw_calls(case, draw, name, ordinary=True)
        wanted = inspect.signature(getattr(case.role, name)).return_annotation
        if name in ("step", "deriv") and case.has_state:
            wanted = block.init()
        for result in results(getattr(case.cls, name), block, name, inputs):
            problem = type_problem(result, wanted)
            if problem:
                raise case.error(f"{name} {problem}", name)
            if case.role is Monitor and name == "step":
                check_metric_kinds(case, block, result)


def check_metric_kinds(case: Case, block: Block, state: Block) -> None:
    """A monitor's metrics are of the same names and types whatever it gathered."""
    found, wanted = block.values(state), block.values(block.init())
    if kinds(found) != kinds(wanted):
        raise case.error(f"values gives {found!r}, and {wanted!r} before a run", "values")


def type_problem(result: Any, wanted: Any) -> str:
    """How a result is not of the type that is wanted, a class or an example; "" where it is."""
    if is_block(wanted) and kinds(result) != kinds(wanted):
        return f"returns {result!r}, not like {wanted!r} of init, in the names and types of its numbers"
    if wanted is float and type(result) is not float:
        return f"returns {result!r}: must be a float"
    if isinstance(wanted, type) and hasattr(wanted, "_fields"):
        if not isinstance(result, wanted):
            return f"returns {result!r}: must be a {wanted.__name__}"
        whole = [path for path, value in leaves(result) if type(value) is not float]
        if whole:
            return f"returns {result!r}, whose {whole[0]} is not a float"
    return ""


def kinds(value: Any) -> Any:
    return [(path, type(one)) for path, one in leaves(value)] if is_block(value) else type(value)


def check_finite(case: Case, draw: Draw) -> None:
    """Ordinary inputs give finite numbers, but for those that are nan in init and those not measured.

    Of a monitor, but for those that are not finite in init: extremes, and times that nothing ends.
    """
    for name in case.compiled_methods():
        if name in MAY_BE_INFINITE:
            continue
        block, inputs = draw_calls(case, draw, name, ordinary=True)
        unknown = unknown_numbers(case, block, name)
        for row, result in zip(inputs, results(getattr(case.cls, name), block, name, inputs), strict=True):
            for path, value in leaves(result) if is_block(result) else [("", result)]:
                may_be = path in unknown and (math.isnan(value) or case.role is Monitor)
                if not (math.isfinite(value) or may_be):
                    of = f" in {path}" if path else ""
                    raise case.error(f"{name} gives {value}{of} for {row_text(row)}, with {block!r}", name)


def unknown_numbers(case: Case, block: Block, name: str) -> set[str]:
    """What of a method's result may be nan."""
    if name == "measure" and case.role is Sensors:
        return set(missing_signals(block))
    if name != "step":
        return set()
    return {path for path, value in leaves(block.init()) if not math.isfinite(value)}


def check_repeatable(case: Case, draw: Draw) -> None:
    """The same inputs give the same bits, and stay as they are, as does the block."""
    for name in case.compiled_methods():
        block, inputs = draw_calls(case, draw, name, ordinary=False)
        before = all_bits([block, *inputs])
        first, second = (all_bits(results(getattr(case.cls, name), block, name, inputs)) for _ in range(2))
        if first != second:
            raise case.error(f"{name} gives other numbers for the same inputs, {row_text(inputs[0])}", name)
        if all_bits([block, *inputs]) != before:
            raise case.error(f"{name} changes what it is given", name)


def check_compiled(case: Case, draw: Draw) -> None:
    """Compiled, its methods give the bits of plain Python for any inputs, and leave those alone."""
    for name in case.compiled_methods():
        block, inputs = draw_calls(case, draw, name, ordinary=False)
        before = all_bits([block, *inputs])
        expected = results(getattr(case.cls, name), block, name, inputs)
        for _ in range(2):
            for row, a, b in zip(inputs, expected, compiled_results(case, block, name, inputs), strict=True):
                if bits(a) != bits(b):
                    problem = f"{name} gives {a!r} in plain Python and {b!r} compiled, for {row_text(row)}"
                    raise case.error(problem, name)
        if all_bits([block, *inputs]) != before:
            raise case.error(f"{name} compiled changes what it is given", name)


def compiled_results(case: Case, block: Block, name: str, inputs: Sequence[Sequence[Any]]) -> list[Any]:
    """What a compiled method gives."""
    try:
        return results(compiled_method(case.cls, name), block, name, inputs)
    except CompileError as error:
        raise case.error(f"{name} cannot be compiled: {error}", name, error.places) from error


@cache
def compiled_method(cls: type, name: str) -> Callable[..., Any]:
    return compiled_function(vars(cls)[name])


def draw_calls(case: Case, draw: Draw, name: str, *, ordinary: bool) -> Run:
    block = draw(cached_random_blocks(case, ordinary))
    inputs = [draw(arguments(block, case.role, name, ordinary)) for _ in range(STEPS)]
    if name == "step":
        inputs[0][0] = block.init()
    return block, inputs


@lru_cache(maxsize=2)  # to make it takes longer than to draw from it
def cached_random_blocks(case: Case, ordinary: bool) -> SearchStrategy[Block]:
    return random_blocks(case.block, ORDINARY if ordinary else WIDE)


def results(method: Method, block: Block, name: str, inputs: Sequence[Sequence[Any]]) -> list[Any]:
    """What successive inputs give; a step goes on from its own last state."""
    found: list[Any] = []
    for row in inputs:
        state = found[-1:] if name == "step" and found else row[:1]
        found.append(method(block, *state, *row[1:]))
    return found


def all_bits(values: Any) -> Any:
    """The bits of blocks, states and numbers in lists of them."""
    return [all_bits(one) for one in values] if isinstance(values, list) else bits(values)


def row_text(row: Sequence[Any]) -> str:
    return ", ".join(map(repr, row))
