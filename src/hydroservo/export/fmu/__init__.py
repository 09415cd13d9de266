"""Exports as FMUs: FMI 2.0 and 3.0, co-simulation and model exchange; and whole loops as systems of them."""

from hydroservo.export.compilers import Platform
from hydroservo.export.fmu.contents import check_clock
from hydroservo.export.fmu.variables import variables_of
from hydroservo.export.fmu.write import PARTS, check_tools, checked_ending, write_fmu, write_ssp
from hydroservo.export.unit import FmiVersion

__all__ = [
    "PARTS",
    "FmiVersion",
    "Platform",
    "check_clock",
    "check_tools",
    "checked_ending",
    "variables_of",
    "write_fmu",
    "write_ssp",
]
