"""The table of a batch, and the files that it goes into."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hydroservo.cli.variations import Drawn
from hydroservo.errors import HydroservoError
from hydroservo.results import FORMATS, as_json, save

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["checked_endings", "table_of_runs", "write_batch"]

PICTURES = (".png", ".svg", ".pdf")


def checked_endings(files: Sequence[Path]) -> None:
    """Refuse a file that could not be written in the end.

    Raises:
        HydroservoError: an ending names no format.
    """
    for file in files:
        endings = (*FORMATS, *PICTURES)
        if file.suffix.lower() not in endings:
            raise HydroservoError(
                f"{file}: the ending {file.suffix!r} names no format; use one of {', '.join(endings)}"
            )


def table_of_runs(found: "xr.Dataset", drawn: Drawn, seed: int) -> "xr.Dataset":
    """The table of a batch, with all that it takes to run each of its runs again.

    Args:
        found: what ``simulate_batch`` returned.
        drawn: what each run sets.
        seed: of the draws.
    """
    shared = {path for path in drawn.parameters if path not in drawn.ranges}
    deviations = {
        name: ("run", values, {"units": "", "long_name": f"relative deviation of {name.partition('.')[2]}"})
        for name, values in drawn.settings.items()
        if name not in drawn.ranges
    }
    about = {"drawn_with_seed": seed, "varied": as_json(drawn.ranges)}
    table = found.drop_vars(shared).assign(deviations).assign_attrs(about)
    return table[[*drawn.ranges, *deviations, *(name for name in found if name not in drawn.parameters)]]


def write_batch(files: Sequence[Path], table: "xr.Dataset", varied: Sequence[str], metric: str) -> None:
    """Write a table, and pictures of one metric against what varied."""
    for file in files:
        if file.suffix.lower() in FORMATS:
            save(table, file)
        else:
            from hydroservo.figures.batch import plot_batch, save_picture

            save_picture(plot_batch(table, varied, metric), file)
