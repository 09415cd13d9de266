"""What varies between the runs of a batch: ranges as they are typed, and the numbers drawn from them."""

from collections.abc import Callable, Container, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import field_at, value_at
from hydroservo.errors import ScenarioError, short
from hydroservo.loop import Loop
from hydroservo.scenario.build import Argument
from hydroservo.scenario.load import Machine
from hydroservo.scenario.overrides import PATH
from hydroservo.scenario.ranges import both_ends, check_path
from hydroservo.scenario.tables import Entry, Origin
from hydroservo.varied import SEED, Columns

__all__ = ["Drawn", "Variation", "drawn_runs", "option_ranges", "variations"]

OPTION = "--vary"
LONGEST = 4096  # characters of one option
NO_ARGUMENTS: Mapping[str, Argument] = MappingProxyType({})

Numbers = NDArray[np.float64]


class Variation(NamedTuple):
    """A number of the scenario that is drawn evenly between two values, in SI units."""

    path: str
    low: float
    high: float
    nominal: (
        float | None
    )  # what a parameter of the machine deviates from; None where values count as they are


class Drawn(NamedTuple):
    """What the runs of a batch do not share."""

    settings: Mapping[str, NDArray[Any]]  # by the path that ``run --set`` takes
    parameters: Mapping[str, NDArray[Any]]  # in SI units by the path in the loop
    ranges: Mapping[str, tuple[float, float]]  # in SI units, by the path as it was typed
    arguments: Mapping[str, NDArray[Any]]  # what constructors take, in SI units by path

    def of_run(self, i: int) -> tuple[dict[str, float], dict[str, float]]:
        """The settings and the parameters of one run."""
        settings, parameters = (
            {path: values[i].item() for path, values in columns.items()} for columns in self[:2]
        )
        return settings, parameters

    def constructed(self, columns_of: Callable[[Mapping[str, NDArray[Any]]], Columns]) -> "Drawn":
        """The same with what constructors make of their arguments among the numbers of the loop.

        Args:
            columns_of: as :func:`~hydroservo.scenario.datasheet_columns` of this scenario.

        Raises:
            ScenarioError: the arguments change nothing, or what they change is drawn too.
        """
        if not self.arguments:
            return self
        made = columns_of(self.arguments)
        if not made:
            paths = ", ".join(self.arguments)
            raise ScenarioError(OPTION, paths, "changes nothing: no number of the loop follows from it here")
        for path in made:
            if path in self.ranges and path not in self.arguments:
                own = [name for name in self.arguments if name.partition(".")[0] == path.partition(".")[0]]
                raise ScenarioError(OPTION, path, f"follows from {' and '.join(own)}, which varies too")
        return self._replace(parameters={**self.parameters, **made})


def variations(
    texts: Sequence[str], loop: Loop, nominal: Loop, arguments: Mapping[str, Argument] = NO_ARGUMENTS
) -> list[Variation]:
    """What ``--vary PATH=LOW..HIGH`` asks for, each path once.

    Args:
        texts: what was typed.
        loop: the loop that all runs start from.
        nominal: the same with its machine as it was before uncertainty: what percentages refer to.
        arguments: what constructors take, by path, before uncertainty.

    Raises:
        ScenarioError: in one line, the path, the value and what is allowed.
    """
    return [variation(path, entry, loop, nominal, arguments) for path, entry in option_ranges(texts).items()]


def option_ranges(texts: Sequence[str]) -> dict[str, Entry]:
    """The texts LOW..HIGH by path, each path once.

    Raises:
        ScenarioError: a text is not of the form PATH=LOW..HIGH, or a path is given twice.
    """
    found: dict[str, Entry] = {}
    for text in texts:
        path, equals, value = (part.strip() for part in text.partition("="))
        if not (equals and ".." in value and PATH.fullmatch(path)) or len(text) > LONGEST:
            raise ScenarioError(OPTION, "", f"{short(text)} must be of the form PATH=LOW..HIGH")
        if path in found:
            raise ScenarioError(OPTION, path, "is given twice")
        found[path] = Entry(Origin(OPTION, Path()), path, value)
    return found


def variation(
    path: str, entry: Entry, loop: Loop, nominal: Loop, arguments: Mapping[str, Argument]
) -> Variation:
    check_path(path, entry, loop, arguments)
    field, middle = arguments.get(path) or (field_at(loop, path), float(value_at(nominal, path)))
    low, high = both_ends(entry, field, middle)
    known = middle not in (0.0, field.auto)
    machine = path.partition(".")[0] in Machine._fields
    return Variation(path, low, high, middle if machine and known else None)


def drawn_runs(
    loop: Loop,
    varied: Sequence[Variation],
    seed: int,
    runs: int,
    *,
    seeds: bool,
    arguments: Container[str] = (),
) -> Drawn:
    """What each run of a batch sets.

    A parameter of the machine is set as its relative deviation, so that the controller goes on believing in
    the nominal value. Run i is the same whatever the number of runs, and each path whatever else varies.
    What constructors take stands apart, until :meth:`Drawn.constructed` asks them.

    Args:
        loop: the loop that all runs start from.
        varied: what is drawn.
        seed: of the draws.
        runs: how many.
        seeds: whether each run has random numbers of its own: the seed of the scenario plus its number.
        arguments: the paths of what constructors take.
    """
    settings: dict[str, NDArray[Any]] = {}
    parameters: dict[str, NDArray[Any]] = {}
    taken: dict[str, NDArray[Any]] = {}
    ranges = {one.path: (one.low, one.high) for one in varied}
    for one in varied:
        numbers = drawn(one, seed, runs)
        settings[one.path if one.nominal is None else f"uncertainty.{one.path}"] = numbers
        if one.path in arguments:
            taken[one.path] = values(one, numbers)
        else:
            parameters[one.path] = values(one, numbers)
    if seeds:
        own = loop.simulation.seed + np.arange(runs)
        settings[SEED] = parameters[SEED] = own
        ranges[SEED] = (int(own[0]), int(own[-1]))
    return Drawn(settings, parameters, ranges, taken)


def drawn(one: Variation, seed: int, runs: int) -> Numbers:
    """What is drawn for each run: a value in SI units, or a relative deviation."""
    u = uniform(seed, one.path, runs)
    if one.nominal is None:
        return np.minimum(one.low + (one.high - one.low) * u, one.high, dtype=np.float64)
    first, last = one.low / one.nominal - 1.0, one.high / one.nominal - 1.0
    return first + (last - first) * u


def uniform(seed: int, path: str, runs: int) -> Numbers:
    """Numbers in [0, 1) that are functions of the seed, the path and the number of the run.

    Source: Philox4x64-10, Salmon, Moraes, Dror, Shaw 2011, doi:10.1145/2063384.2063405.
    """
    stream = int.from_bytes(sha256(path.encode()).digest()[:8], "little")
    bits = np.random.Philox(key=np.array([seed, stream], dtype=np.uint64)).random_raw(runs)
    return np.ldexp((bits >> np.uint64(11)).astype(np.float64), -53)


def values(one: Variation, numbers: Numbers) -> Numbers:
    """The values in SI units that the numbers drawn stand for, to the bit as a scenario has them."""
    return numbers if one.nominal is None else one.nominal * (1.0 + numbers)
