"""What is doubtful of a loop's numbers, before it runs."""

from hydroservo.block import Block, is_block
from hydroservo.errors import ParameterError, one_line
from hydroservo.loop import Loop
from hydroservo.runs.demands import command_caution, demand_caution, late_caution
from hydroservo.runs.mismatches import mismatch_cautions
from hydroservo.runs.sizes import size_cautions


def loop_cautions(loop: Loop) -> list[str]:
    """What a user should know of a loop before it runs: lines, empty ones among them."""
    asked = [demand_caution(loop), late_caution(loop), command_caution(loop)]
    return [*asked, *own_cautions(loop), *size_cautions(loop), *mismatch_cautions(loop)]


def own_cautions(block: Block, path: str = "") -> list[str]:
    """What a block, and the blocks nested in it, say of numbers that are allowed and doubtful.

    Args:
        block: such as a loop.
        path: where it is, which stands before its line.
    """
    said = said_by(block, path) if hasattr(block, "caution") else ""
    found = [f"{path}: {said}"] if said else []
    for name, value in block._asdict().items():
        if is_block(value):
            found += own_cautions(value, f"{path}.{name}" if path else name)
    return found


def said_by(block: Block, path: str) -> str:
    """The line of a block that has a method ``caution``.

    Raises:
        ParameterError: the method fails, as one of a user's own block may.
    """
    try:
        return one_line(str(block.caution()))
    except Exception as error:
        kind = type(block).__name__
        problem = f"its method caution fails: {type(error).__name__}: {error}"
        raise ParameterError(path or kind, kind, problem) from None
