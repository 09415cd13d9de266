"""Scenarios: TOML files with units that describe a loop, and the built-in ones."""

from hydroservo.scenario.datasheets import datasheet_columns
from hydroservo.scenario.load import Assembly, assemble, load_scenario
from hydroservo.scenario.parameter_draws import Drawn
from hydroservo.scenario.registry import load_plugin
from hydroservo.scenario.scenario_files import parse_override, scenario_source, scenarios

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
