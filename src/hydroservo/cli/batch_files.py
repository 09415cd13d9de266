"""The files that the table of a batch goes into."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from hydroservo.cli.frame import PICTURE_ENDINGS, Written
from hydroservo.core.outputs import OutputError, keep_elsewhere, staged, write_text
from hydroservo.runs.results import FORMATS, Format, save
from hydroservo.show.journal import NO_JOURNAL, Journal

if TYPE_CHECKING:
    import xarray as xr

ENDINGS = (*FORMATS, *PICTURE_ENDINGS)


def write_batch_files(
    files: Sequence[Path], table: "xr.Dataset", *, metric: str, journal: Journal = NO_JOURNAL
) -> Written:
    """Write a table, and pictures of one metric against what varied, each whatever becomes of the others."""
    failures: dict[Path, Exception] = {}
    write = partial(write_batch_file, table=table, metric=metric, journal=journal)
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
    return Written(done, combine_failures(failures, write))


def combine_failures(failures: Mapping[Path, Exception], write: Callable[[Path], object]) -> Exception | None:
    """What a batch ends with: all that could not be written and where it is instead, or what else failed."""
    lost = {file: str(error) for file, error in failures.items() if isinstance(error, OutputError)}
    others = [error for file, error in failures.items() if file not in lost]
    if not lost:
        return others[0] if others else None
    problem = OutputError("; ".join(dict.fromkeys(lost.values())))
    found = keep_elsewhere(problem, lambda place: [write(place / name) for name in distinct_names(lost)])
    if others:
        others[0].add_note(str(found))
    return others[0] if others else found


def distinct_names(files: Iterable[Path]) -> list[str]:
    """The name of each file, with a number before it where another has the same."""
    names = [file.name for file in files]
    return [name if names.count(name) == 1 else f"{i}-{name}" for i, name in enumerate(names, 1)]


def write_batch_file(file: Path, table: "xr.Dataset", metric: str, journal: Journal) -> None:
    ending = file.suffix.lower()
    if ending in FORMATS:
        save(table, file)
        if ending == Format.CSV.ending:
            write_text(file, journal.csv(file.read_text(encoding="utf-8")))
    else:
        from hydroservo.runs.batch_finding import draw

        draw(table, metric).save(file, origin=table.attrs["hash"])
