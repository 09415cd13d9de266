"""Exports as FMUs: FMI 2.0 and 3.0, co-simulation."""

from hydroservo.export.exported import FmiVersion
from hydroservo.export.fmu.write import write_fmu

__all__ = ["FmiVersion", "write_fmu"]
