"""What tests of exported C and FMUs share."""

from pathlib import Path

__all__ = ["DRIVERS"]

DRIVERS = Path(__file__).parent / "drivers"  # programs in C, around exported units
