"""A result said once: findings of tables, lines and pictures, and the printers that show them."""

from hydroservo.show.finding import Finding, Line, Log, Origin, Picture
from hydroservo.show.table import UNIT, Cell, Column, Mark, Table

__all__ = ["UNIT", "Cell", "Column", "Finding", "Line", "Log", "Mark", "Origin", "Picture", "Table"]
