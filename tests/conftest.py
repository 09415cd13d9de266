"""Settings of all tests."""

from hypothesis import settings
from numba import config

# A first call compiles for a second; interpreted, an example takes a hundred times longer.
settings.register_profile("hydroservo", deadline=None, max_examples=15 if config.DISABLE_JIT else 100)
settings.load_profile("hydroservo")
