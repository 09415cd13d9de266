"""The table of a batch, and the files that it goes into."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hydroservo.cli.writing import Written
from hydroservo.errors import HydroservoError
from hydroservo.outputs import OutputError, keep_elsewhere, staged
from hydroservo.runs.results import FORMATS, as_json, save
from hydroservo.scenario.build import Argument
from hydroservo.scenario.sampling import Drawn

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


def table_of_runs(
    found: "xr.Dataset", drawn: Drawn, seed: int, arguments: Mapping[str, Argument]
) -> "xr.Dataset":
    """The table of a batch, with all that it takes to run each of its runs again.

    Args:
        found: what ``simulate_batch`` returned.
        drawn: what each run sets.
        seed: of the draws.
        arguments: what constructors take, by path.
    """
    deviations = {
        f"uncertainty.{path}": ("run", column, {"units": "", "long_name": f"relative deviation of {path}"})
        for path, column in drawn.deviations.items()
    }
    taken = {
        path: ("run", column, {"units": field.unit, "long_name": field.meaning})
        for path, column in drawn.values.items()
        if path in arguments and (field := arguments[path].field)
    }
    made = [path for path in drawn.parameters if path not in drawn.values]
    about = {"drawn_with_seed": seed, "varied": as_json(drawn.ranges)}
    table = found.drop_vars(made).assign(taken | deviations).assign_attrs(about)
    return table[[*drawn.values, *deviations, *(name for name in found if name not in drawn.parameters)]]


def write_batch(files: Sequence[Path], table: "xr.Dataset", varied: Sequence[str], metric: str) -> Written:
    """Write a table, and pictures of one metric against what varied, each whatever becomes of the others."""
    failures: dict[Path, Exception] = {}
    for folder in dict.fromkeys(file.parent for file in files):
        together = [file for file in files if file.parent == folder]
        try:
            with staged(folder) as stage:
                for file in together:
                    try:
                        write_file(stage / file.name, table, varied, metric)
                    except Exception as error:  # whatever it is, the other files are worth having
                        failures[file] = error
        except OutputError as error:
            failures |= dict.fromkeys(together, error)
    done = [file for file in files if file not in failures]
    return Written(done, failure_of(failures, lambda file: write_file(file, table, varied, metric)))


def failure_of(failures: Mapping[Path, Exception], write: Callable[[Path], object]) -> Exception | None:
    """What a batch ends with: all that could not be written and where it is instead, or what else failed."""
    lost = {file: str(error) for file, error in failures.items() if isinstance(error, OutputError)}
    others = [error for file, error in failures.items() if file not in lost]
    if not lost:
        return others[0] if others else None
    problem = OutputError("; ".join(dict.fromkeys(lost.values())))
    found = keep_elsewhere(problem, lambda place: [write(place / name) for name in distinct(lost)])
    if others:
        others[0].add_note(str(found))
    return others[0] if others else found


def distinct(files: Iterable[Path]) -> list[str]:
    """The name of each file, with a number before it where another has the same."""
    names = [file.name for file in files]
    return [name if names.count(name) == 1 else f"{i}-{name}" for i, name in enumerate(names, 1)]


def write_file(file: Path, table: "xr.Dataset", varied: Sequence[str], metric: str) -> None:
    if file.suffix.lower() in FORMATS:
        save(table, file)
    else:
        from hydroservo.figures.batch import plot_batch
        from hydroservo.figures.style import save_picture

        save_picture(plot_batch(table, varied, metric), file, table.attrs["hash"])
