"""What a search is to find: scenarios with the ranges, bounds and machines of their tables ``[tune]``."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from hydroservo.control.loop import Loop
from hydroservo.control.wiring import wired
from hydroservo.core.block import Block, field_at, leaves
from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.core.formatting import Scale
from hydroservo.linear.stability import Bounds
from hydroservo.runs.arguments import checked_loops
from hydroservo.runs.objective import Aim, checked_aim
from hydroservo.runs.provenance import scenario_hash
from hydroservo.scenario.load import Assembly, assemble, load_scenario
from hydroservo.scenario.ranges import Relative, typed_scales
from hydroservo.scenario.scenario_files import same_place
from hydroservo.scenario.tables import TableEntry
from hydroservo.scenario.tune_table import LIMITS, SearchedRange, SearchSettings, checked_part, searched_range

NO_SEARCH = "is a first guess without a search; leave out the ranges"

Load = Callable[[str | Path, Mapping[str, object], Sequence[str | Path]], Loop]


class TuningTask(NamedTuple):
    """A search as :func:`hydroservo.runs.tuning.search_gains` takes it, and whose it is."""

    # those that are tuned together, by name or path; none for loops that no scenario names
    scenarios: Sequence[str]
    names: Sequence[str]  # of the aim's loops, each scenario at each scale; none for such loops
    aim: Aim  # what is to be small
    # the lowest and highest value of each number, by its path, in SI units
    ranges: Mapping[str, tuple[float, float]]
    candidates: int  # how many sets of numbers are tried
    seed: int  # of the search
    bounds: Bounds | None = None  # what the loops are to bear; None for none
    # the loops that are held against them, by name: those of the aim, and those of each scenario at both
    # ends and the middle of its uncertainty
    machines: Mapping[str, Loop] = MappingProxyType({})
    typed: Mapping[str, Scale] = MappingProxyType({})  # the units in which ranges were typed, by SI unit


def task_of_aim(
    aim: Aim, ranges: Mapping[str, Any], length: Mapping[str, Any], others: Mapping[str, object]
) -> TuningTask:
    """The search of loops that no scenario names."""
    for name, value in others.items():
        raise ParameterError(name, value, "is for scenarios by name; an Aim has its own")
    for path, ends in ranges.items():
        if isinstance(ends, str | Relative):
            raise ParameterError(path, ends, "must be two numbers in SI units for an Aim")
    search = SearchSettings(
        **{name: checked_part(name, value, 1, aim.loops) for name, value in length.items()}
    )
    if not search.candidates and ranges:
        raise ParameterError("candidates", 0, NO_SEARCH)
    check_bounded(search, length)
    machines = {f"loop {i}": wired(loop) for i, loop in enumerate(checked_loops(aim.loops), 1)}
    return TuningTask((), (), aim, ranges, search.candidates, search.seed, search.bounds, machines)


def task_of_scenarios(
    scenarios: Sequence[str | Path],
    ranges: Mapping[str, TableEntry],
    parts: Mapping[str, object],
    changes: Mapping[str, object],
    plugins: Sequence[str | Path],
    load: Load = load_scenario,
) -> TuningTask:
    """The search of scenarios: what is said of it, else what ``[tune]`` of the first one says."""
    search = search_of(scenarios, assemble(scenarios[0], changes, plugins), parts)
    assemblies = {one: assemble(one, changes, plugins) for one in search.scenarios}
    wanted = ranges_to_search(ranges, search, assemblies)
    ends = {path: (one.low, one.high) for path, one in wanted.items()}
    scales: Sequence[float | None] = search.scales or [None]
    each = [(one, scale) for one in search.scenarios for scale in scales]
    loops = [load(one, at_scale(changes, scale), plugins) for one, scale in each]
    weights = [weight for weight in search.weights for _ in scales]
    aim = Aim(loops, weights, search.metric, search.seeds, search.effort)
    check_together(aim, search.scales, parts)
    typed = typed_scales((one.entry, field_at(loops[0], path).unit) for path, one in wanted.items())
    names = [str(one) if scale is None else f"{one}, scale {scale:g}" for one, scale in each]
    machines: dict[str, Loop] = dict(zip(names, loops, strict=True)) if search.bounded else {}
    known = set(map(scenario_hash, loops))
    others = machines_of(search.scenarios, changes, plugins) if machines else ()
    machines |= {name: loop for name, loop in others if scenario_hash(loop) not in known}
    return TuningTask(
        [str(one) for one in search.scenarios],
        *(names, aim, ends, search.candidates, search.seed, search.bounds, machines, typed),
    )


def machines_of(
    scenarios: Sequence[str | Path], changes: Mapping[str, object], plugins: Sequence[str | Path]
) -> Iterator[tuple[str, Loop]]:
    """The machines of scenarios at both ends and the middle of their uncertainty, by name."""
    for one in scenarios:
        for scale in (-1.0, 0.0, 1.0):
            yield f"{one}, scale {scale:g}", load_scenario(one, at_scale(changes, scale), plugins)


def search_of(
    scenarios: Sequence[str | Path], first: Assembly, parts: Mapping[str, object]
) -> SearchSettings:
    """What is said of a search, with the scenarios that are tuned together and a weight for each."""
    search, together = first.search, scenarios
    weights = search.weights if len(scenarios) == 1 else ()
    if len(scenarios) == 1 and search.scenarios:
        together = search.scenarios
        if same_place(scenarios[0]) not in map(same_place, together):
            raise ScenarioError(str(scenarios[0]), "tune.scenarios", not_among(scenarios[0], search))
    count = len(together)
    if "weights" not in parts and len(weights) not in (0, count):
        problem = (
            f"are for {len(weights)} scenarios; name them in tune.scenarios, or write tune.weights = [1]"
        )
        raise ScenarioError(str(scenarios[0]), "tune.weights", problem)
    said = {name: checked_part(name, value, count, [first.loop]) for name, value in parts.items()}
    search = search._replace(**{"scenarios": together, "weights": weights or (1.0,) * count} | said)
    check_bounded(search, parts)
    return search


def check_bounded(search: SearchSettings, parts: Mapping[str, object]) -> None:
    """Refuse a bound on a search that has none."""
    for name in LIMITS:
        if name in parts and not search.bounded:
            raise ParameterError(name, parts[name], "is a bound, and the search has none: it is unbounded")


def not_among(scenario: str | Path, search: SearchSettings) -> str:
    """What is wrong with scenarios that are tuned together and do not hold the one that names them."""
    names = ", ".join(map(str, search.scenarios))
    origin = search.together.origin.name if search.together else ""
    if origin in ("", str(scenario)):
        return f"must hold the scenario itself; they are {names}"
    own = f'[tune] with scenarios = ["{Path(scenario).name}"] and weights = [1]'
    return f"those of {origin}, its base, are {names}, not this one; write {own}"


def of_another_law(lost: TableEntry, law: Block) -> str:
    """What is wrong with ranges of a base that name no number of a law, one of them given."""
    numbers = (
        name for name, value in leaves(law) if isinstance(value, float) and not field_at(law, name).derived
    )
    own = f'controller.{next(numbers, "NUMBER")} = "LOW..HIGH"'
    missing = f"{type(law).__name__} has no {lost.key.removeprefix('tune.vary.')}"
    origin = f"that of {lost.origin.name}, its base, is for another law"
    return f"{origin}: {missing}; write [tune.vary] of its own, such as {own}"


def ranges_to_search(
    ranges: Mapping[str, TableEntry], search: SearchSettings, assemblies: Mapping[str | Path, Assembly]
) -> Mapping[str, SearchedRange]:
    """Between what each number is searched, by path."""
    first = next(iter(assemblies.values()))
    asked = {path: searched_range(path, entry, first.loop, first.arguments) for path, entry in ranges.items()}
    if not search.candidates:
        if asked:
            raise ParameterError("candidates", 0, NO_SEARCH)
        return {}
    wanted = asked or search.ranges
    if not wanted and search.lost:
        of = str(next(iter(assemblies)))
        raise ScenarioError(of, "tune.vary", of_another_law(search.lost, first.loop.controller))
    if not wanted:
        raise ParameterError("ranges", "{}", "must name a number, or the scenario have [tune.vary]")
    for path, one in wanted.items():
        for name, assembly in assemblies.items():
            if path not in dict(leaves(assembly.loop)) or path in assembly.arguments:
                raise ScenarioError(one.entry.origin.name, one.entry.key, f"is not a number of {name}")
    return wanted


def at_scale(changes: Mapping[str, object], scale: float | None) -> Mapping[str, object]:
    """Changes that take a scenario at a scale of its uncertainty; at its own if that is None."""
    return changes if scale is None else {**changes, "uncertainty.scale": scale}


def check_together(aim: Aim, scales: Sequence[float], parts: Mapping[str, object]) -> None:
    """Refuse a metric that a scenario does not have, and scales that make no difference in one."""
    try:
        checked_aim(aim)
        check_scales(scales, aim.loops)
    except ParameterError as error:
        name = error.path if error.path in parts else f"tune.{error.path}"
        raise ParameterError(name, error.value, error.allowed) from None


def check_scales(scales: Sequence[float], loops: Sequence[Loop]) -> None:
    """Refuse scales at which a scenario is the same machine."""
    count = len(scales) or 1
    for start in range(0, len(loops), count):
        if len({scenario_hash(loop) for loop in loops[start : start + count]}) < count:
            text = ",".join(f"{scale:g}" for scale in scales)
            raise ParameterError("scales", text, "changes nothing in a scenario without [uncertainty]")
