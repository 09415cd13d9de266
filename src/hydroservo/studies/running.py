"""Runs a study: its searches that are not done yet, what they came to, and how each number is repeated."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.block import Block
from hydroservo.formatting import NONE, quantity
from hydroservo.html_tables import Strong, html_heading, html_table
from hydroservo.metrics import judged_by
from hydroservo.runs.fitting import signals_used
from hydroservo.studies.asked import Law, Study
from hydroservo.studies.cells import Cell, Entrant, cells_of, entrants_of, units_of
from hydroservo.studies.contenders import blocks
from hydroservo.studies.file import read_study
from hydroservo.studies.limiting import limited, table_of_limits
from hydroservo.studies.middle import middle_gains
from hydroservo.studies.properties import examined, properties_in
from hydroservo.studies.rules import Rules
from hydroservo.studies.scenario_files import remove_dropped, seen_from, write_scenarios
from hydroservo.studies.sentences import sentence
from hydroservo.studies.verdicts import Verdicts, judged
from hydroservo.work.doing import do
from hydroservo.work.notebook_bar import shows_progress
from hydroservo.work.store import Store, manifest_in

__all__ = ["MANIFEST", "Studied", "study"]

MANIFEST = "study.json"
LIMITS = "limits"
PROPERTIES = "properties"
PRESSURES = {"load_force", "pressure_a", "pressure_b", "force"}  # what a law of class VP uses


class Studied(NamedTuple):
    """What a study came to.

    Attributes:
        folder: where it is kept.
        manifest: what it was: laws, cells, axes, rules.
        table: a row for each search, budget and condition.
        limits: a row for each condition whose limits were asked for.
        verdicts: what it says.
    """

    folder: Path
    manifest: Mapping[str, Any]
    table: Any  # DataFrames of pandas, which is heavy to import
    limits: Any
    verdicts: Verdicts

    def __repr__(self) -> str:
        lines = [f"{cell}: {sentence(one.best)}" for cell, one in self.verdicts.cells.items()]
        return "\n".join([str(self.manifest["title"]), *lines])

    def _repr_html_(self) -> str:
        """What a notebook shows: who wins each cell, with which error."""
        rows = []
        for cell, one in self.verdicts.cells.items():
            best = one.standings.get(one.best.law)
            error = quantity(best.error, self.manifest["unit"]) if best else NONE
            rows.append((cell, Strong(one.best.law or "none"), error, sentence(one.best)))
        about = f"{len(self.manifest['laws'])} laws, {len(self.table):,} rows in {self.folder}"
        heads = ("cell", "best", str(self.manifest["metric"]), "verdict")
        return html_heading(str(self.manifest["title"]), about) + html_table(heads, rows)


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
) -> Studied:
    """Hold laws against each other as a study's file asks, doing what is not done yet::

        found = hs.study("small", "small-study")
        found.verdicts.cells["high"].best

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
    entrants = list(entrants_of(asked))
    units = [unit for entrant in entrants for unit in units_of(asked, entrant)]
    bounded = limited(asked, entrants)
    manifest = manifest_of(asked, entrants, Path(out))
    remove_dropped(Path(out), manifest_in(out, MANIFEST) or {}, manifest)
    store, least = Store(out, MANIFEST, manifest), Store(out, MANIFEST, manifest, LIMITS)
    for one, own in ((store, units), (least, [limit.unit for limit in bounded])):
        one.keep(unit.key for unit in own)
    write_scenarios(asked, entrants, store.folder)
    whole = len(units) + len(bounded) + len(entrants)
    searched, all_but = len(units) / whole, (len(units) + len(bounded)) / whole
    done = partial(do, workers=workers, scheduler=scheduler, say=say)
    done(units, store, progress=part_of(progress, 0.0, searched))
    done([one.unit for one in bounded], least, progress=part_of(progress, searched, all_but))
    table = store.table([unit.key for unit in units]).to_pandas()
    laws = list(examined(entrants, middle_gains(table)))
    beside = Store(out, MANIFEST, manifest, PROPERTIES)
    beside.keep(one.unit.key for one in laws)
    done([one.unit for one in laws], beside, progress=part_of(progress, all_but, 1.0))
    limits = table_of_limits(bounded, least)
    verdicts = judged(table, manifest, limits=limits, properties=properties_in(beside, laws))
    return Studied(store.folder, manifest, table, limits, verdicts)


def part_of(
    progress: Callable[[float], None] | None, start: float, end: float
) -> Callable[[float], None] | None:
    """What is to be told of the fraction done of a part that takes the work from one fraction to another."""
    return None if progress is None else lambda fraction: progress(start + (end - start) * fraction)


def manifest_of(study: Study, entrants: list[Entrant], folder: Path) -> dict[str, Any]:
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
        "cells": {cell.name: levels_of(study, cell) for cell in cells_of(study)},
        "plugins": [seen_from(folder, one) for one in study.plugins],
        "kinds": [kind.name for kind in study.conditions.kinds],
        "conditions": {**study.conditions.counts, "stress": study.conditions.stress},
        "search": {
            "candidates": study.search.candidates,
            "seeds": study.search.seeds,
            "optimisers": list(study.search.optimisers),
            "efforts": list(study.search.efforts),
        },
        "limits": {"conditions": study.limits},
        "rules": Rules()._asdict(),
    }


def levels_of(study: Study, cell: Cell) -> dict[str, str]:
    return {axis.name: level.name for axis, level in zip(study.axes, cell.levels, strict=True)}


def about_law(law: Law, entrant: Entrant) -> dict[str, Any]:
    """What a law is made of, what it measures, and how much of it is tuned."""
    loop = next(iter(entrant.contender.assemblies.values())).loop
    names = [type(block).__name__ for _, block in controllers(loop.controller)]
    observers = [block for path, block in blocks(loop.controller) if path.rpartition(".")[2] == "observer"]
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
