"""Tools that a test needs."""

import os
import shutil

import pytest


def needs(*tools: str) -> None:
    """Skips a test whose tools are missing; fails it where HYDROSERVO_TOOLS says that all are there.

    Called in a fixture or a test.
    """
    missing = ", ".join(tool for tool in tools if shutil.which(tool) is None)
    if missing and os.environ.get("HYDROSERVO_TOOLS") == "all":
        pytest.fail(f"missing: {missing}")
    if missing:
        pytest.skip(f"missing: {missing}")
