"""Exports as FMUs: FMI 2.0 and 3.0, co-simulation."""

from hydroservo.export.fmu.write import checked_name, write_fmu
from hydroservo.export.unit import FmiVersion

__all__ = ["FmiVersion", "checked_name", "write_fmu"]
