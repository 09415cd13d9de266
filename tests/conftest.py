"""Settings of all tests."""

from hypothesis import settings

settings.register_profile("hydroservo", deadline=None)  # a first call compiles for a second
settings.load_profile("hydroservo")
