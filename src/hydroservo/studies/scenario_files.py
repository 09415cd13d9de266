"""What repeats a study's numbers: a scenario for each law in each cell, and the conditions of each cell."""

import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import product
from pathlib import Path
from typing import Any

import tomli_w

from hydroservo.outputs import OutputError, staged
from hydroservo.scenario.load import Machine
from hydroservo.scenario.overrides import nested
from hydroservo.studies.asked import Kind, Study
from hydroservo.studies.cells import Entrant
from hydroservo.studies.contenders import over
from hydroservo.studies.reading import FILE


def write_scenarios(study: Study, entrants: Sequence[Entrant], folder: Path) -> None:
    """The scenario of each law in each cell with each kind of condition, and the conditions of each cell."""
    with staged(folder) as stage:
        for one in entrants:
            for kind in study.conditions.kinds:
                file = stage / scenario_file(one.cell.name, one.law.name, kind.name)
                file.parent.mkdir(parents=True, exist_ok=True)
                tables = scenario_tables(study, one, kind, folder / file.parent.relative_to(stage))
                file.write_text(tomli_w.dumps(tables), "utf-8")
            conditions = stage / conditions_file(one.cell.name)
            if not conditions.exists():
                conditions.parent.mkdir(exist_ok=True)
                conditions.write_text(json.dumps(conditions_table(one), indent=1) + "\n", "utf-8")


def remove_dropped(folder: Path, before: Mapping[str, Any], now: Mapping[str, Any]) -> None:
    """Remove what was written for laws, cells and kinds that a study had and has no more.

    Args:
        folder: the study's.
        before: its manifest as it was; empty if there was none.
        now: as it is.
    """
    try:
        for name in files_of(before) - files_of(now):
            (folder / name).unlink(missing_ok=True)
            for above in name.parents[:-1]:
                with suppress(FileNotFoundError):
                    if not any((folder / above).iterdir()):
                        (folder / above).rmdir()
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}") from None


def files_of(manifest: Mapping[str, Any]) -> set[Path]:
    """The files that a study with this manifest writes here."""
    cells, laws, kinds = (manifest.get(name, ()) for name in ("cells", "laws", "kinds"))
    scenarios = {scenario_file(*one) for one in product(cells, laws, kinds)}
    return scenarios | {conditions_file(cell) for cell in cells}


def scenario_file(cell: str, law: str, kind: str) -> Path:
    return Path("scenarios", cell, law, f"{kind}.toml")


def conditions_file(cell: str) -> Path:
    return Path("conditions", f"{cell}.json")


def scenario_tables(study: Study, entrant: Entrant, kind: Kind, folder: Path) -> dict[str, Any]:
    """The tables of a law's scenario in a cell, as a file in a folder has them."""
    changes = over(entrant.contender.changes, kind.changes)
    files = {path for path in changes if path.rpartition(".")[2] == FILE}
    own = {path: seen_from(folder, value) if path in files else value for path, value in changes.items()}
    base = study.base if isinstance(study.base, str) else seen_from(folder, study.base)
    return {"base": base, **nested(own)}


def seen_from(folder: Path, file: str | Path) -> str:
    """A file's path as a scenario in a folder has it: from that folder, so that both can move together."""
    try:
        return Path(os.path.relpath(Path(file).resolve(), folder.resolve())).as_posix()
    except ValueError:  # on another drive
        return Path(file).resolve().as_posix()


def conditions_table(entrant: Entrant) -> dict[str, Any]:
    """The conditions of a cell by split and number: their kind, and what they set in SI units."""
    return {
        split: {
            str(number): {
                "kind": kind,
                "set": {as_set(path): column[i].item() for path, column in one.changes.items()},
            }
            for kind, one in own.items()
            for i, number in enumerate(one.numbers.tolist())
        }
        for split, own in entrant.drawn.items()
    }


def as_set(path: str) -> str:
    """Where a scenario has what a condition sets: numbers of the machine as its truth."""
    return f"truth.{path}" if path.partition(".")[0] in Machine._fields else path
