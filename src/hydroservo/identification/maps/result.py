"""What a map of a machine holds."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.control.loop import Loop
from hydroservo.core.formatting import plain_quantity
from hydroservo.identification.maps.finding import map_finding
from hydroservo.identification.result import scenario_on_base
from hydroservo.show import Finding
from hydroservo.show.html import html_of

if TYPE_CHECKING:
    import xarray as xr


class Interval(NamedTuple):
    """A number that a map gives, in SI units.

    Attributes:
        value: the best one.
        low: lower end of its 95 % interval.
        high: the upper end.
        unit: SI.
        meaning: what it is.
    """

    value: float
    low: float
    high: float
    unit: str
    meaning: str

    @classmethod
    def around(cls, value: float, half: float, unit: str, meaning: str) -> "Interval":
        """The interval of a number and half its width."""
        return cls(float(value), float(value - half), float(value + half), unit, meaning)

    def times(self, factor: float, unit: str) -> "Interval":
        """Another number that is so many times this one; the factor is above 0."""
        return Interval(factor * self.value, factor * self.low, factor * self.high, unit, self.meaning)

    def at_least_0(self) -> "Interval":
        """The same of a number that a scenario may not have below 0."""
        return self._replace(value=max(self.value, 0.0), low=max(self.low, 0.0), high=max(self.high, 0.0))

    def __repr__(self) -> str:
        value, low, high = (plain_quantity(one, self.unit) for one in self[:3])
        return f"{value} ({low} ... {high})"


class DrawnLine(NamedTuple):
    """Lines that a picture shows beside the curve.

    Attributes:
        label: what they are.
        x: shape (n,), in the unit of the curve's first column.
        y: shape (n,), in that of its second; nan between two lines.
    """

    label: str
    x: Any
    y: Any


class MapContents(NamedTuple):
    """What one kind of map finds in logs."""

    # the points of the map along ``point``; the first variable over which the second is drawn
    curve: "xr.Dataset"
    numbers: Mapping[str, Interval]  # by name
    lines: Sequence[DrawnLine] = ()  # that are fitted to the curve
    # of the scenario's numbers, by their paths; all are written where one is
    values: Mapping[str, Interval] = {}
    remarks: Sequence[str] = ()  # what a user should know, in a line each
    undetermined: Mapping[str, str] = {}  # numbers that it cannot give, and why
    characteristic: "xr.Dataset | None" = None  # the table of a characteristic
    changes: Mapping[str, Any] = {}  # of the scenario by their paths, with which its valve plays that table


class StaticMap(NamedTuple):
    """A map of a machine.

    Attributes:
        kind: valve-flow, characteristic, pressure-gain, friction or decay.
        scenario: whose machine it is; empty where none was given.
        logs: from which it is.
        curve: its points along ``point``, with deviations and 95 % intervals, an xarray.Dataset.
        numbers: that it gives, by name.
        lines: that are fitted to the curve.
        remarks: what a user should know, in a line each.
        tables: of a scenario over the given one, with what was found.
        undetermined: numbers that it cannot give, and why.
        loop: of the scenario, where one was given.
        characteristic: the table of a map of that kind along ``point``: flow or speed over the command, which
            does not fall, with intervals, an xarray.Dataset.
    """

    kind: str
    scenario: str
    logs: Sequence[str]
    curve: "xr.Dataset"
    numbers: Mapping[str, Interval]
    lines: Sequence[DrawnLine]
    remarks: Sequence[str]
    tables: Mapping[str, Any]
    undetermined: Mapping[str, str] = {}
    loop: Loop | None = None
    characteristic: "xr.Dataset | None" = None

    def toml(self, folder: Path | str = ".") -> str:
        """The text of a scenario with what was found, which builds on the given one.

        Args:
            folder: where its file will stand, from which a scenario in a file is found again.
        """
        return scenario_on_base(self.scenario, self.tables, folder, f"map {self.kind} {', '.join(self.logs)}")

    def __repr__(self) -> str:
        numbers = [f"{name} = {one!r}" for name, one in self.numbers.items()]
        unknown = [f"{name} cannot be determined: {why}" for name, why in self.undetermined.items()]
        return "\n".join([*numbers, *unknown, *self.remarks])

    def finding(self) -> Finding:
        """What it says, as commands and notebooks show it."""
        return map_finding(self)

    def _repr_html_(self) -> str:
        return html_of(self.finding())


def unchanged_number(value: float) -> Interval:
    """A number of a scenario that stays as it is, so that others that a constructor takes change alone."""
    return Interval(value, value, value, "", "")


def curve_of(columns: Mapping[str, Any], about: Mapping[str, tuple[str, str]]) -> "xr.Dataset":
    """The points of a map as a dataset along ``point``."""
    import xarray as xr

    return xr.Dataset(
        {
            name: ("point", columns[name], {"units": unit, "long_name": meaning})
            for name, (unit, meaning) in about.items()
        }
    )
