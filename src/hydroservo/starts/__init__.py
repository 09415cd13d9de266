"""Where a run starts."""

from hydroservo.starts.as_built import AsBuilt
from hydroservo.starts.steady import Steady

__all__ = ["AsBuilt", "Steady"]
