"""A law on the machine of a cell: its loops, one for each kind of condition, and what of it is searched."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from hydroservo.core.block import Block, declared_fields, field_at, is_under, leaves, nested_blocks
from hydroservo.core.errors import ScenarioError, nearest, one_of
from hydroservo.scenario.build import Draft
from hydroservo.scenario.load import Assembly, assemble
from hydroservo.scenario.registry import plugin_classes, shipped_classes
from hydroservo.scenario.scenario_files import layered_table
from hydroservo.scenario.tables import LayeredTable, TableEntry
from hydroservo.scenario.tune_table import searched_range
from hydroservo.studies.spec import AxisLevel, LawSpec, StudySpec
from hydroservo.studies.spec_file import entry_value

RATES = ("1/s", "rad/s")  # units of numbers whose ranges go as far as the sample rate allows
LAW = "controller"

SearchRanges = dict[str, tuple[float, float]]  # in SI units, by path


class TunableLaw(NamedTuple):
    """A law on the machine of a cell."""

    assemblies: Mapping[str, Assembly]  # of its loop for each kind of condition, by the kind's name
    ranges: SearchRanges  # between what its numbers are searched, in SI units, by path
    # what makes its scenario from the study's base, by dotted path, without those of the kinds
    changes: Mapping[str, Any]


def tunable_law(study: StudySpec, law: LawSpec, levels: Sequence[AxisLevel]) -> TunableLaw:
    """A law as a study has it, on the machine of the cell at some levels of the axes."""
    own = assemble(law.scenario, {}, study.plugins)
    place = observer_place(study, law, own.loop.controller) if law.observer else ""
    if law.unwrapped and not hasattr(own.loop.controller, "controller"):
        raise ScenarioError(study.origin.name, f"laws.{law.name}.unwrapped", "is for a law in a wrapper")
    controller = law_table(study, law, place)
    changes = {**layered_changes(study.changes, *(level.changes for level in levels)), **controller}
    first = assemble(study.base, layered_changes(changes, study.conditions.kinds[0].changes), study.plugins)
    known = known_values(study, law, first)
    check_settable(study, law, first, known)
    changes |= known
    found = kind_loops(study, changes)
    one = next(iter(found.values()))
    ranges = own_ranges(study, law, own, place) | observer_ranges(study, law, one, place)
    searched = {path: ends for path, ends in ranges.items() if path not in known}
    if not searched:
        raise ScenarioError(study.origin.name, f"laws.{law.name}", "has nothing to search")
    check_settable(study, law, one, searched)
    slow = assemble(study.base, {**study.changes, **controller}, study.plugins).loop
    return TunableLaw(found, with_scaled_rates(searched, slow, one.loop), changes)


def law_table(study: StudySpec, law: LawSpec, place: str) -> dict[str, Any]:
    """What the study's scenario says of a law, by path: another observer is in the place of its own."""
    table = controller_table(layered_table(law.scenario, {}))
    if law.observer:
        given = study.observers[law.observer].table
        table = {path: value for path, value in table.items() if not is_under(path, f"{LAW}.{place}")}
        table |= {f"{LAW}.{place}.{path}": value for path, value in given.items()}
    path_of = path_in_study(law)
    found = {
        moved: value
        for path, value in layered_changes(table, law.changes).items()
        if (moved := path_of(path))
    }
    return found | {f"{LAW}.{path}": value for path, value in law.wrapped.items()}


def layered_changes(*layers: Mapping[str, Any]) -> dict[str, Any]:
    """Changes by dotted path, each layer over those before; another type drops what they say of its table."""
    found: dict[str, Any] = {}
    for layer in layers:
        types = {path: value for path, value in layer.items() if path.rpartition(".")[2] == "type"}
        other = [path.rpartition(".")[0] for path, value in types.items() if found.get(path) != value]
        found = {
            path: value for path, value in found.items() if not any(is_under(path, one) for one in other)
        }
        found |= layer
    return found


def kind_loops(study: StudySpec, changes: Mapping[str, Any]) -> dict[str, Assembly]:
    """The loop for each kind of condition, on the nominal machine."""
    kinds = study.conditions.kinds
    return {
        one.name: assemble(study.base, layered_changes(changes, one.changes), study.plugins) for one in kinds
    }


def controller_table(scenario: LayeredTable) -> dict[str, Any]:
    """What a scenario's files say of its law, by path: the layer that names its type, and those above."""
    table = scenario.table(LAW)
    named = [i for i, layer in enumerate(table.layers) if "type" in layer.given]
    if not named:
        raise scenario.error("names no [controller] with a type, which a study takes from it")
    layers = (table._replace(layers=(one,)) for one in reversed(table.layers[: named[0] + 1]))
    return layered_changes(
        *({f"{LAW}.{path}": entry_value(entry) for path, entry in one.entries()} for one in layers)
    )


def observer_place(study: StudySpec, law: LawSpec, controller: Block) -> str:
    found = [path for path, block in nested_blocks(controller) if path.rpartition(".")[2] == "observer"]
    if not found:
        raise ScenarioError(study.origin.name, f"laws.{law.name}.observers", "is for a law with an observer")
    return found[0]


def path_in_study(law: LawSpec) -> Callable[[str], str]:
    """Where a number of a law's own scenario is in the study's; "" in a wrapper that is left out."""

    def moved(path: str) -> str:
        rest = path.removeprefix(f"{LAW}.")
        if law.unwrapped:
            if not rest.startswith(f"{LAW}."):
                return ""
            rest = rest.removeprefix(f"{LAW}.")
        return f"{LAW}.{LAW}.{rest}" if law.wrapped else f"{LAW}.{rest}"

    return moved


def known_values(study: StudySpec, law: LawSpec, assembly: Assembly) -> dict[str, float]:
    """What a law knows of the loop and does not set itself, by the path of the number that holds it."""
    found = {}
    path_of = path_in_study(law)
    set_by_law = {path_of(path) for path in law.changes}
    nominal = assembly.loop._replace(**assembly.nominal._asdict())
    numbers = {path: value for path, value in leaves(nominal) if isinstance(value, float)}
    for key, entry in study.known.items():
        kind, _, field = key.rpartition(".")
        check_known_field(entry, kind, field)
        if entry.value not in numbers:
            raise entry.error(f"must be a number of the loop; it {one_of(str(entry.value), numbers)}")
        for path, block in nested_blocks(assembly.loop.controller):
            place = ".".join(filter(None, (LAW, path, field)))
            if type(block).__name__ == kind and field in block._fields and place not in set_by_law:
                found[place] = numbers[entry.value]
    return found


def check_known_field(entry: TableEntry, kind: str, field: str) -> None:
    """Refuse a number that no block has."""
    classes = {one.__name__: one for one in (*shipped_classes(), *plugin_classes())}
    if kind not in classes:
        raise entry.error(f"is for a key Type.field, and there is no type {kind!r}{nearest(kind, classes)}")
    if field not in declared_fields(classes[kind]):
        raise entry.error(
            f"is for a field {field!r} of {kind}, which {one_of(field, declared_fields(classes[kind]))}"
        )


def check_settable(study: StudySpec, law: LawSpec, assembly: Assembly, paths: Iterable[str]) -> None:
    """Refuse numbers of a block that a constructor makes: what is found of them could not be set."""
    for path in paths:
        draft, *names = assembly.drafts[LAW], *path.split(".")[1:-1]
        for name in [*names, ""]:
            if not isinstance(draft.maker, type):
                problem = f"{draft.maker.__qualname__} makes {path}, which a study sets; give its own numbers"
                raise ScenarioError(study.origin.name, f"laws.{law.name}.scenario", problem)
            if not isinstance(inner := draft.members.get(name), Draft):
                break
            draft = inner


def own_ranges(study: StudySpec, law: LawSpec, own: Assembly, place: str) -> SearchRanges:
    """What is searched of a law but its observer, if that is another: as its scenario has it."""
    path_of = path_in_study(law)
    beside = f"{LAW}.{place}".rpartition(".")[0]
    drop = [f"{beside}.{one}" for one in study.observers[law.observer].drop] if law.observer else []
    found = {}
    for path, one in own.search.ranges.items():
        replaced = law.observer and is_under(path, f"{LAW}.{place}")
        fixed = any(is_under(path, changed) for changed in law.changes)
        if is_under(path, LAW) and not replaced and not fixed and path not in drop and path_of(path):
            found[path_of(path)] = (one.low, one.high)
    return found


def observer_ranges(study: StudySpec, law: LawSpec, assembly: Assembly, place: str) -> SearchRanges:
    if not law.observer:
        return {}
    path_of = path_in_study(law)
    found = {}
    for name, entry in study.observers[law.observer].vary.items():
        if any(is_under(f"{LAW}.{place}.{name}", changed) for changed in law.changes):
            continue
        path = path_of(f"{LAW}.{place}.{name}")
        one = searched_range(path, entry, assembly.loop, assembly.arguments)
        found[path] = (one.low, one.high)
    return found


def with_scaled_rates(ranges: SearchRanges, slow: Block, loop: Block) -> SearchRanges:
    """Ranges whose rates go as far beyond those at the study's own sample rate as that of a cell does."""
    factor = max(1.0, slow.simulation.period / loop.simulation.period)
    rates = {path for path in ranges if field_at(loop, path).unit in RATES}
    return {path: (low, high * factor if path in rates else high) for path, (low, high) in ranges.items()}
