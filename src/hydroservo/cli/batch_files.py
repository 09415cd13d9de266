"""The files that the table of a batch goes into."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from hydroservo.cli.files import PICTURE_ENDINGS
from hydroservo.cli.places import is_folder
from hydroservo.cli.writing import Written
from hydroservo.errors import HydroservoError
from hydroservo.outputs import OutputError, keep_elsewhere, staged, write_text
from hydroservo.reports.decimal_commas import decimal_commas
from hydroservo.runs.results import FORMATS, Format, save

if TYPE_CHECKING:
    import xarray as xr

ENDINGS = (*FORMATS, *PICTURE_ENDINGS)


def destinations(out: Sequence[str]) -> tuple[list[Path], Path | None]:
    """The files that ``--out`` names, and the folder; None if it names none.

    Raises:
        HydroservoError: an ending names no format, or there are two folders.
    """
    folders = [one for one in out if is_folder(one, ENDINGS)]
    files = [Path(one) for one in out if one not in folders]
    checked_endings(files)
    if len(folders) > 1:
        raise HydroservoError(f"--out: {folders[0]} and {folders[1]} are both folders; give one, and files")
    return files, Path(folders[0]) if folders else None


def is_csv(file: Path) -> bool:
    """Whether a file's ending says CSV."""
    return file.suffix.lower() == Format.CSV.ending


def checked_endings(files: Sequence[Path]) -> None:
    """Refuse a file that could not be written in the end.

    Raises:
        HydroservoError: an ending names no format.
    """
    for file in files:
        if file.suffix.lower() not in ENDINGS:
            raise HydroservoError(
                f"{file}: the ending {file.suffix!r} is not a known format; use one of "
                f"{', '.join(ENDINGS)}, or a folder, with a / at its end"
            )


def write_batch(
    files: Sequence[Path],
    table: "xr.Dataset",
    varied: Sequence[str],
    metric: str,
    decimal_comma: bool = False,
) -> Written:
    """Write a table, and pictures of one metric against what varied, each whatever becomes of the others."""
    failures: dict[Path, Exception] = {}
    write = partial(write_file, table=table, varied=varied, metric=metric, decimal_comma=decimal_comma)
    for folder in dict.fromkeys(file.parent for file in files):
        together = [file for file in files if file.parent == folder]
        try:
            with staged(folder) as stage:
                for file in together:
                    try:
                        write(stage / file.name)
                    except Exception as error:  # whatever it is, the other files are worth having
                        failures[file] = error
        except OutputError as error:
            failures |= dict.fromkeys(together, error)
    done = [file for file in files if file not in failures]
    return Written(done, failure_of(failures, write))


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


def write_file(
    file: Path, table: "xr.Dataset", varied: Sequence[str], metric: str, decimal_comma: bool
) -> None:
    if file.suffix.lower() in FORMATS:
        save(table, file)
        if decimal_comma and is_csv(file):
            write_text(file, decimal_commas(file.read_text(encoding="utf-8")))
    else:
        from hydroservo.figures.batch import plot_batch
        from hydroservo.figures.style import save_picture

        save_picture(plot_batch(table, varied, metric), file, table.attrs["hash"])
