"""Settings of all tests."""

import os
from pathlib import Path

from hypothesis import settings

# A first call compiles for a second.
settings.register_profile("hydroservo", deadline=None)
settings.load_profile("hydroservo")

# Kernels of the tests stay out of the user's cache.
os.environ["HYDROSERVO_CACHE_DIR"] = str(Path(__file__).parent.parent / ".pytest_cache" / "kernels")
