"""Runs a study: its searches that are not done yet, what they came to, and how each number is repeated."""

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import tomli_w

from hydroservo.control.metrics import judged_by
from hydroservo.core.block import Block, nested_blocks
from hydroservo.core.outputs import OutputError, staged
from hydroservo.runs.fitting import signals_used
from hydroservo.scenario.load import MachineBlocks
from hydroservo.scenario.scenario_files import nest_changes
from hydroservo.show import Finding
from hydroservo.show.html import html_of
from hydroservo.studies.cells import (
    LawInCell,
    MapCell,
    laws_in_cells,
    limited_conditions,
    map_cells,
    search_units,
    table_of_limits,
)
from hydroservo.studies.fronts import choose_gains, front_points, reference_points, with_gains
from hydroservo.studies.laws import layered_changes
from hydroservo.studies.properties import properties_in, property_units
from hydroservo.studies.report.finding import study_finding
from hydroservo.studies.spec import ConditionKind, LawSpec, StudySpec
from hydroservo.studies.spec_file import FILE, read_study
from hydroservo.studies.trials import GAINS, Rules, judged_columns
from hydroservo.studies.verdicts import Verdicts, study_verdicts
from hydroservo.work.execution import do_units
from hydroservo.work.notebook_bar import shows_progress
from hydroservo.work.units import UnitStore, manifest_in

if TYPE_CHECKING:
    import pandas as pd

MANIFEST = "study.json"
LIMITS = "limits"
PROPERTIES = "properties"
PRESSURES = {"hydraulic_force", "pressure_a", "pressure_b", "force"}  # what a law of class VP uses


def write_scenarios(study: StudySpec, entrants: Sequence[LawInCell], folder: Path) -> None:
    """The scenario of each law in each cell with each kind of condition, and the conditions of each cell."""
    with staged(folder) as stage:
        for one in entrants:
            for kind in study.conditions.kinds:
                file = stage / scenario_file(one.cell.name, one.law.name, kind.name)
                file.parent.mkdir(parents=True, exist_ok=True)
                tables = law_scenario(study, one, kind, folder / file.parent.relative_to(stage))
                file.write_text(tomli_w.dumps(tables), "utf-8")
            conditions = stage / conditions_file(one.cell.name)
            if not conditions.exists():
                conditions.parent.mkdir(exist_ok=True)
                conditions.write_text(json.dumps(conditions_table(one), indent=1) + "\n", "utf-8")


def remove_dropped(folder: Path, before: Mapping[str, Any], now: Mapping[str, Any]) -> None:
    """Remove what was written for laws, cells and kinds that a study had and has no more."""
    try:
        for name in manifest_files(before) - manifest_files(now):
            (folder / name).unlink(missing_ok=True)
            for above in name.parents[:-1]:
                with suppress(FileNotFoundError):
                    if not any((folder / above).iterdir()):
                        (folder / above).rmdir()
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}") from None


def manifest_files(manifest: Mapping[str, Any]) -> set[Path]:
    """The files that a study with this manifest writes here."""
    cells, laws, kinds = (manifest.get(name, ()) for name in ("cells", "laws", "kinds"))
    scenarios = {scenario_file(*one) for one in product(cells, laws, kinds)}
    return scenarios | {conditions_file(cell) for cell in cells}


def scenario_file(cell: str, law: str, kind: str) -> Path:
    return Path("scenarios", cell, law, f"{kind}.toml")


def conditions_file(cell: str) -> Path:
    return Path("conditions", f"{cell}.json")


def law_scenario(study: StudySpec, entrant: LawInCell, kind: ConditionKind, folder: Path) -> dict[str, Any]:
    """The tables of a law's scenario in a cell, as a file in a folder has them."""
    changes = layered_changes(entrant.contender.changes, kind.changes)
    files = {path for path in changes if path.rpartition(".")[2] == FILE}
    own = {path: seen_from(folder, value) if path in files else value for path, value in changes.items()}
    base = study.base if isinstance(study.base, str) else seen_from(folder, study.base)
    return {"base": base, **nest_changes(own)}


def seen_from(folder: Path, file: str | Path) -> str:
    """A file's path as a scenario in a folder has it: from that folder, so that both can move together."""
    try:
        return Path(os.path.relpath(Path(file).resolve(), folder.resolve())).as_posix()
    except ValueError:  # on another drive
        return Path(file).resolve().as_posix()


def conditions_table(entrant: LawInCell) -> dict[str, Any]:
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
    return f"truth.{path}" if path.partition(".")[0] in MachineBlocks._fields else path


class StudyResult(NamedTuple):
    """What a study came to.

    Attributes:
        folder: where it is kept.
        manifest: what it was: laws, cells, axes, rules.
        table: a row for each point of a front and condition.
        limits: a row for each condition whose limits were asked for.
        verdicts: what it says.
    """

    folder: Path
    manifest: Mapping[str, Any]
    table: Any  # DataFrames of pandas, which is heavy to import
    limits: Any
    verdicts: Verdicts

    def __repr__(self) -> str:
        lines = [f"{cell}: {', '.join(texts)}" for cell, texts in self.winners().items()]
        about = f"best law at {', '.join(self.verdicts.levels)} times the activity"
        return "\n".join([str(self.manifest["title"]), f"{about} of {self.manifest['reference']}", *lines])

    def finding(self) -> Finding:
        """What it says, as commands and notebooks show it."""
        return study_finding(self)

    def _repr_html_(self) -> str:
        return html_of(self.finding())

    def winners(self) -> dict[str, list[str]]:
        """The best law in each cell at each level, and with how many it ties."""
        found: dict[str, list[str]] = {}
        for cell in self.verdicts.activity:
            for level in self.verdicts.levels.values():
                best = level.cells[cell].best if cell in level.cells else None
                tied = f" (ties with {len(best.ties) - 1})" if best and len(best.ties) > 1 else ""
                found.setdefault(cell, []).append(f"{best.law}{tied}" if best and best.law else "none")
        return found


@shows_progress
def study(
    source: str | Path,
    out: str | Path,
    *,
    changes: Mapping[str, object] | None = None,
    plugins: Sequence[str | Path] = (),
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[float], None] | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> StudyResult:
    """Hold laws against each other as a study's file asks, doing what is not done yet::

        found = hs.study("small", "small-study")
        found.verdicts.levels["1"].cells["high"].best

    Args:
        source: the path of a TOML file, or the name of a built-in study such as ``small``.
        out: the folder in which it is kept; the same call goes on with what is there.
        changes: values by dotted path that override those of the file, such as ``search.candidates``.
        plugins: Python files with blocks that the study's scenarios name, besides those that its file names;
            they are executed, here and in the workers, which find them at the same place.
        workers: processes of this machine; one for each core if None.
        scheduler: address of a Dask scheduler, whose workers do it instead.
        progress: called now and then with the fraction of the work that is done.
        say: is told, in a line each, what went wrong on the way.

    Raises:
        ScenarioError: in one line, the file, the key, the value and what is allowed.
        HydroservoError: the folder is that of another version, no scheduler answers, searches failed, or
            limits are asked for and CasADi is not installed.
        OutputError: something cannot be written.
    """
    asked = read_study(source, changes)
    asked = asked._replace(plugins=[*asked.plugins, *(Path(one) for one in plugins)])
    entrants = list(laws_in_cells(asked))
    bounded = limited_conditions(asked, entrants)
    manifest = manifest_of(asked, entrants, Path(out))
    remove_dropped(Path(out), manifest_in(out, MANIFEST) or {}, manifest)
    store, least = UnitStore(out, MANIFEST, manifest), UnitStore(out, MANIFEST, manifest, LIMITS)
    least.keep(limit.unit.key for limit in bounded)
    write_scenarios(asked, entrants, store.folder)
    whole = len(entrants) * (asked.search.seeds + 1) + len(bounded)
    report = ProgressParts(progress, whole)
    done = partial(do_units, workers=workers, scheduler=scheduler, say=say)
    table = table_of_searches(asked, entrants, store, done, report)
    done([one.unit for one in bounded], least, progress=report.part(len(bounded)))
    choice = choose_gains(judged_columns(table), asked.reference, asked.search.levels, Rules())
    laws = list(property_units(entrants, with_gains(choice, table)))
    beside = UnitStore(out, MANIFEST, manifest, PROPERTIES)
    beside.keep(one.unit.key for one in laws)
    done([one.unit for one in laws], beside, progress=report.part(len(entrants)))
    limits = table_of_limits(bounded, least)
    verdicts = study_verdicts(table, manifest, limits=limits, properties=properties_in(beside, laws))
    return StudyResult(store.folder, manifest, table, limits, verdicts)


def table_of_searches(
    study: StudySpec,
    entrants: Sequence[LawInCell],
    store: UnitStore,
    done: Callable[..., None],
    report: "ProgressParts",
) -> "pd.DataFrame":
    """The rows of all searches; the reference's come first, for its activity bounds those of the others."""
    first = [unit for one in entrants if is_reference(study, one) for unit in search_units(study, one, None)]
    done(first, store, progress=report.part(len(first)))
    activity = training_activity(store.table([unit.key for unit in first]).to_pandas(), study.reference)
    rest = [
        unit
        for one in entrants
        if not is_reference(study, one)
        for unit in search_units(study, one, activity[one.cell.name])
    ]
    store.keep(unit.key for unit in [*first, *rest])
    done(rest, store, progress=report.part(len(rest)))
    found: pd.DataFrame = store.table([unit.key for unit in [*first, *rest]]).to_pandas()
    return found


def is_reference(study: StudySpec, entrant: LawInCell) -> bool:
    return entrant.law.name == study.reference


def training_activity(table: "pd.DataFrame", reference: str) -> dict[str, float]:
    """The activity of the reference in each cell [%/s], where searches see it: on the training conditions.

    It is that of its first search, so that more searches change no other law's.
    """
    runs = judged_columns(table[table["search_seed"] == 0])
    own = reference_points(front_points(runs, "validation"), reference, Rules())
    found = front_points(runs, "train").merge(own[GAINS], on=GAINS)
    return {str(cell): float(one) for cell, one in zip(found["cell"], found["activity"], strict=True)}


class ProgressParts:
    """Tells of parts of a work one after the other, as the fraction of the whole that is done."""

    def __init__(self, tell: Callable[[float], None] | None, whole: int) -> None:
        self.tell, self.whole, self.before = tell, whole, 0

    def part(self, size: int) -> Callable[[float], None] | None:
        """What is to be told of the fraction done of the next part."""
        if self.tell is None:
            return None
        tell, start, share = self.tell, self.before / self.whole, size / self.whole
        self.before += size
        return lambda fraction: tell(start + share * fraction)


def manifest_of(study: StudySpec, entrants: list[LawInCell], folder: Path) -> dict[str, Any]:
    """What a study is, for those who read its folder: files are seen from there."""
    first = {one.law.name: one for one in reversed(entrants)}
    loop = next(iter(entrants[0].contender.assemblies.values())).loop
    return {
        "title": study.title,
        "metric": study.metric,
        "unit": judged_by([loop])[study.metric].unit,
        "reference": study.reference,
        "laws": {name: about_law(law, first[name]) for name, law in study.laws.items()},
        "axes": [
            {
                "name": axis.name,
                "label": axis.label,
                "levels": [{"name": one.name, "label": one.label, "value": one.value} for one in axis.levels],
            }
            for axis in study.axes
        ],
        "cells": {cell.name: cell_levels(study, cell) for cell in map_cells(study)},
        "plugins": [seen_from(folder, one) for one in study.plugins],
        "kinds": [kind.name for kind in study.conditions.kinds],
        "conditions": {**study.conditions.counts, "stress": study.conditions.stress},
        "search": {
            "candidates": study.search.candidates,
            "seeds": study.search.seeds,
            "levels": list(study.search.levels),
        },
        "limits": {"conditions": study.limits},
        "rules": Rules()._asdict(),
    }


def cell_levels(study: StudySpec, cell: MapCell) -> dict[str, str]:
    return {axis.name: level.name for axis, level in zip(study.axes, cell.levels, strict=True)}


def about_law(law: LawSpec, entrant: LawInCell) -> dict[str, Any]:
    """What a law is made of, what it measures, and how much of it is tuned."""
    loop = next(iter(entrant.contender.assemblies.values())).loop
    names = [type(block).__name__ for _, block in controllers(loop.controller)]
    observers = [
        block for path, block in nested_blocks(loop.controller) if path.rpartition(".")[2] == "observer"
    ]
    return {
        "stem": law.name.removesuffix(f"-{law.observer}") if law.observer else law.name,
        "family": law.family,
        "observer": type(observers[0]).__name__ if observers else "",
        "wrapper": " in ".join(names[:-1]),
        "class": "VP" if PRESSURES & set(signals_used(loop)) else "V",
        "gains": len(entrant.contender.ranges),
        "of": law.of,
        "without": law.without,
    }


def controllers(block: Block) -> Iterator[tuple[str, Block]]:
    """A controller, and what it wraps."""
    yield "", block
    if hasattr(block, "controller"):
        yield from controllers(block.controller)
