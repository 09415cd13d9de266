"""Loops of a scenario that differ in one number."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from hydroservo.block import field_at
from hydroservo.loop import Loop
from hydroservo.scenario.load import Machine, assembled, load_scenario
from hydroservo.scenario.sampling import variation
from hydroservo.scenario.tables import Entry


def loops_over(
    source: str,
    path: str,
    entry: Entry,
    count: int,
    changes: Mapping[str, object],
    plugins: Sequence[Path],
    load: Callable[[str, Mapping[str, object], Sequence[Path]], Loop] = load_scenario,
) -> tuple[dict[float, Loop], str]:
    """The loops of a scenario by values of a number, and its SI unit; a law believes what it believed.

    Args:
        source: the scenario.
        path: the number's.
        entry: the range over which its values are even.
        count: how many.
        changes: as :func:`~hydroservo.load_scenario` takes them.
        plugins: likewise.
        load: makes a loop, as :func:`~hydroservo.load_scenario` does.
    """
    whole = assembled(source, changes, plugins)
    ends = variation(whole, path, entry)
    field = whole.arguments[path].field if path in whole.arguments else field_at(whole.loop, path)
    name = f"truth.{path}" if path.partition(".")[0] in Machine._fields else path
    values = np.linspace(ends.low, ends.high, count).tolist()
    return {value: load(source, {**changes, name: value}, plugins) for value in values}, field.unit
