"""All that is doubtful of a loop before it runs, and of a run."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, is_block
from hydroservo.core.errors import ParameterError, one_line
from hydroservo.runs.cautions.creep import creep_caution
from hydroservo.runs.cautions.demands import command_caution, demand_caution, late_caution
from hydroservo.runs.cautions.mismatches import mismatch_cautions
from hydroservo.runs.cautions.pressures import pressure_caution
from hydroservo.runs.cautions.sizes import size_cautions
from hydroservo.runs.cautions.unrecorded import record_caution


def loop_cautions(loop: Loop) -> list[str]:
    """What a user should know of a loop before it runs: lines, empty ones among them."""
    return [line for ask in OF_LOOP for line in ask(loop)]


def run_cautions(loop: Loop, data: Mapping[Any, Any]) -> list[str]:
    """What a user should know of a run besides: lines, empty ones among them.

    Args:
        loop: that was run.
        data: the run, with its machine's states.
    """
    return [ask(loop, data) for ask in OF_RUN]


def own_cautions(block: Block, path: str = "") -> list[str]:
    """What a block, and the blocks nested in it, say of numbers that are allowed and doubtful."""
    said = said_by(block, path) if hasattr(block, "caution") else ""
    found = [f"{path}: {said}"] if said else []
    for name, value in block._asdict().items():
        if is_block(value):
            found += own_cautions(value, f"{path}.{name}" if path else name)
    return found


def said_by(block: Block, path: str) -> str:
    """The line of a block that has a method ``caution``."""
    try:
        return one_line(str(block.caution()))
    except Exception as error:
        kind = type(block).__name__
        problem = f"its method caution fails: {type(error).__name__}: {error}"
        raise ParameterError(path or kind, kind, problem) from None


OF_LOOP: Sequence[Callable[[Loop], Sequence[str]]] = (
    lambda loop: (demand_caution(loop), late_caution(loop), command_caution(loop)),
    own_cautions,
    size_cautions,
    mismatch_cautions,
)
OF_RUN: Sequence[Callable[[Loop, Mapping[Any, Any]], str]] = (
    lambda _, data: pressure_caution(data),
    creep_caution,
    lambda loop, data: record_caution(data, loop.simulation.period),
)
