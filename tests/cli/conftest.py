"""Settings of the tests of commands."""

import math

import pytest


@pytest.fixture(autouse=True)
def no_lines_of_progress(monkeypatch):
    """On a busy machine a short command takes long, and what it says of that is no part of a test."""
    monkeypatch.setattr("hydroservo.cli.messages.FIRST_LINE", math.inf)
