"""What is doubtful of a loop's numbers, before it runs."""

from hydroservo.block import Block, is_block
from hydroservo.loop import Loop
from hydroservo.runs.demands import command_caution, demand_caution, late_caution
from hydroservo.runs.sizes import size_cautions

__all__ = ["loop_cautions", "own_cautions"]


def loop_cautions(loop: Loop) -> list[str]:
    """What a user should know of a loop before it runs: lines, empty ones among them."""
    asked = [demand_caution(loop), late_caution(loop), command_caution(loop)]
    return [*asked, *own_cautions(loop), *size_cautions(loop)]


def own_cautions(block: Block, path: str = "") -> list[str]:
    """What a block, and the blocks nested in it, say of numbers that are allowed and doubtful.

    Args:
        block: such as a loop.
        path: where it is, which stands before its line.
    """
    found = [f"{path}: {said}"] if hasattr(block, "caution") and (said := block.caution()) else []
    for name, value in block._asdict().items():
        if is_block(value):
            found += own_cautions(value, f"{path}.{name}" if path else name)
    return found
