"""Settings of all tests."""

import os
import signal
from pathlib import Path

import pytest
from hypothesis import settings

# Comparisons that tests share say as much as their own when they fail.
pytest.register_assert_rewrite("tests.support")

# A first call compiles for a second. The same examples each time; --hypothesis-profile=random draws others.
settings.register_profile("hydroservo", deadline=None, derandomize=True)
settings.register_profile("random", deadline=None)
settings.load_profile("hydroservo")

# Where interrupts are ignored, as in the background of a script, commands would ignore those of tests too.
signal.signal(signal.SIGINT, signal.default_int_handler)

# As commands have it: threads cost more than matrices of six rows do. Libraries read it as they load.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Kernels of the tests stay out of the user's cache.
os.environ["HYDROSERVO_CACHE_DIR"] = str(Path(__file__).parent.parent / ".pytest_cache" / "kernels")


@pytest.fixture
def forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    """The plug-ins that a test loads, no other test sees."""
    monkeypatch.setattr("hydroservo.scenario.registry.loaded_modules", {})
