"""Exports as FMUs: FMI 2.0 and 3.0, co-simulation."""

from hydroservo.export.fmu.ssp import PARTS, checked_system_name, write_ssp
from hydroservo.export.fmu.write import checked_name, write_fmu
from hydroservo.export.unit import FmiVersion

__all__ = ["PARTS", "FmiVersion", "checked_name", "checked_system_name", "write_fmu", "write_ssp"]
