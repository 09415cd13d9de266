"""What a block is to a type checker."""

from typing import Any

Block = Any  # a NamedTuple with methods; Python's type system has no name for "some NamedTuple"
