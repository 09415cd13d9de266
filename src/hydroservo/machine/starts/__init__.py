"""Where a run starts."""

from hydroservo.machine.starts.as_built import AsBuilt
from hydroservo.machine.starts.steady import Steady

__all__ = ["AsBuilt", "Steady"]
