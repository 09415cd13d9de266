"""To and from other tools: python-control."""

from hydroservo.interop.python_control import from_statespace, to_law, to_nlsys, to_scenario, to_statespace

__all__ = ["from_statespace", "to_law", "to_nlsys", "to_scenario", "to_statespace"]
