"""The cases of a test that run less often than the others."""

from collections.abc import Collection
from typing import Any

import pytest


def mostly(tier: pytest.MarkDecorator, values: Collection[Any], often: Collection[Any]) -> list[Any]:
    """The values for ``parametrize``, with all in a tier but those that run as often as the test itself."""
    assert all(value in values for value in often)
    rows = [value if type(value) is tuple else (value,) for value in values]
    return [
        value if value in often else pytest.param(*row, marks=tier)
        for value, row in zip(values, rows, strict=True)
    ]
