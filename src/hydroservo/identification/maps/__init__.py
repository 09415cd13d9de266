"""Static maps of a machine: valve flow, pressure gain, friction, and the decay of pressures."""

from hydroservo.identification.maps.map_logs import MapKind, map_logs
from hydroservo.identification.maps.result import DrawnLine, Interval, StaticMap

__all__ = ["DrawnLine", "Interval", "MapKind", "StaticMap", "map_logs"]
