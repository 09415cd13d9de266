"""What a static map leaves in its folder: its curve, a scenario, and what the report says."""

from collections.abc import Sequence
from pathlib import Path

from hydroservo.cli.files import OwnFiles
from hydroservo.cli.map_tables import numbers_table
from hydroservo.cli.reporting import in_one_block, table_of
from hydroservo.field import Field
from hydroservo.figures.static_map import plot_static_map
from hydroservo.formatting import quantity
from hydroservo.identification.maps import StaticMap
from hydroservo.loop import Loop
from hydroservo.outputs import write_text
from hydroservo.reports.report import Picture, Report, logs_of, origin_of_loop
from hydroservo.runs.results import metrics_csv


def map_files(found: StaticMap, folder: Path) -> OwnFiles:
    """The points of the curve in SI units, and where a scenario was given one with what was found.

    Args:
        found: what ``map_logs`` returned.
        folder: where the scenario will stand.
    """
    own: OwnFiles = {"map.csv": lambda path: write_text(path, curve_csv(found))}
    if not found.scenario:
        return own
    return {**own, "scenario.toml": lambda path: write_text(path, found.toml(folder))}


def curve_csv(found: StaticMap) -> str:
    """The points of the curve."""
    every = found.curve.data_vars.items()
    fields = {str(name): Field(row.attrs["units"], row.attrs["long_name"]) for name, row in every}
    return metrics_csv(found.curve.to_dataframe(), fields)


def map_report(command: str, found: StaticMap, loop: Loop | None, logs: Sequence[Path]) -> Report:
    """The report of a static map.

    Args:
        command: makes it again.
        found: what ``map_logs`` returned.
        loop: the loop of its scenario, if it has one.
        logs: what was measured.
    """
    shown = [f"{one.meaning}: {quantity(one.value, one.unit)}" for one in found.numbers.values()]
    caption = "The measured curve with its 95 % intervals, and what is fitted to it."
    return Report(
        f"Map: {found.kind.replace('-', ' ')}",
        [f"{'; '.join(shown)}."] if shown else [],
        in_one_block(found.remarks),
        [Picture("map", caption, plot_static_map(found))],
        [table_of("numbers", numbers_table(found), "What the map gives.")],
        command,
        [origin_of_loop(found.scenario, loop)] if loop else [],
        logs_of(logs),
    )
