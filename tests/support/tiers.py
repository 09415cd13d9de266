"""The cases of a test that run less often than the others."""

from collections.abc import Collection
from typing import Any

import pytest


def mostly(tier: pytest.MarkDecorator, values: Collection[Any], often: Collection[Any]) -> list[Any]:
    """The values for ``parametrize``, with all in a tier but those that run as often as the test itself."""
    assert all(value in values for value in often)
    return [value if value in often else pytest.param(value, marks=tier) for value in values]
