"""What a static map found: on the terminal, and as JSON."""

from typing import Any

from rich.markup import escape
from rich.table import Table

from hydroservo._version import __version__
from hydroservo.cli.tables import NO_NUMBER
from hydroservo.formatting import scales_of
from hydroservo.identification.maps import StaticMap


def as_tables(found: StaticMap) -> dict[str, Any]:
    """The map as nested tables, in SI units."""
    curve = {
        str(name): {
            "values": row.values.tolist(),
            "unit": row.attrs["units"],
            "meaning": row.attrs["long_name"],
        }
        for name, row in found.curve.data_vars.items()
    }
    return {
        "kind": found.kind,
        "scenario": found.scenario,
        "version": __version__,
        "logs": list(found.logs),
        "numbers": {name: one._asdict() for name, one in found.numbers.items()},
        "undetermined": dict(found.undetermined),
        "curve": curve,
        "remarks": list(found.remarks),
    }


def numbers_table(found: StaticMap) -> Table:
    """The numbers with their intervals, and a dash with the reason for those that cannot be determined."""
    title = f"{found.kind}: {', '.join(found.logs)}"
    shown = Table(title=escape(title), title_justify="left")
    shown.add_column("number", no_wrap=True)
    for name in ("value", "from", "to", "unit"):
        shown.add_column(name, justify="right" if name != "unit" else "left", no_wrap=True)
    shown.add_column("meaning", overflow="fold")
    scales = scales_of((one.unit, [one.value]) for one in found.numbers.values())
    for name, one in found.numbers.items():
        scale = scales[one.unit]
        numbers = (f"{scale.of(number):.4g}" for number in (one.value, one.low, one.high))
        shown.add_row(name, *numbers, scale.label, one.meaning)
    for name, why in found.undetermined.items():
        shown.add_row(name, *[NO_NUMBER] * 3, "", f"cannot be determined: {why}")
    shown.caption = "from and to: 95 % interval"
    return shown
