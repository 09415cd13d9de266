"""Static maps of a machine: valve flow, pressure gain, friction, and the decay of pressures."""

from hydroservo.identification.maps.mapping import Kind, map_logs
from hydroservo.identification.maps.result import Drawn, Interval, StaticMap

__all__ = ["Drawn", "Interval", "Kind", "StaticMap", "map_logs"]
