"""Exports as FMUs: FMI 2.0 and 3.0, co-simulation."""

from hydroservo.export.fmu.write import write_fmu
from hydroservo.export.unit import FmiVersion

__all__ = ["FmiVersion", "write_fmu"]
