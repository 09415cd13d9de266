"""Scenarios: TOML files with units that describe a loop, and the built-in ones."""

from hydroservo.scenario.datasheets import datasheet_columns
from hydroservo.scenario.layers import parse_override, scenario_source, scenarios
from hydroservo.scenario.load import Assembly, assemble, load_scenario
from hydroservo.scenario.plugins import load_plugin
from hydroservo.scenario.sampling import Drawn

__all__ = [
    "Assembly",
    "Drawn",
    "assemble",
    "datasheet_columns",
    "load_plugin",
    "load_scenario",
    "parse_override",
    "scenario_source",
    "scenarios",
]
