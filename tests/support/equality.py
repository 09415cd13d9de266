"""When two blocks are the same; ``==`` of named tuples asks for their numbers alone."""

from typing import Any

import numpy as np

from hydroservo.core.block import Block, leaves
from hydroservo.engine.flat import block_shape


def assert_same_block(found: Block, wanted: Block) -> None:
    """Fails unless two blocks, such as loops, hold the same numbers in blocks of the same classes."""
    assert contents(found) == contents(wanted)
    assert block_shape(found) == block_shape(wanted)


def contents(block: Block) -> dict[str, Any]:
    """Each number by its path; arrays as lists."""
    return {path: value.tolist() if isinstance(value, np.ndarray) else value for path, value in leaves(block)}
