"""Studies from their files, each value checked where it stands."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from hydroservo.core.errors import ParameterError, ScenarioError, one_of
from hydroservo.core.formatting import is_number
from hydroservo.core.validation import whole_number
from hydroservo.scenario.quantities import si_value
from hydroservo.scenario.scenario_files import layered_table, locate_source, named_source, nest_changes
from hydroservo.scenario.tables import FileOrigin, Layer, LayeredTable, TableEntry, parse_toml
from hydroservo.studies.spec import (
    AxisLevel,
    ConditionKind,
    ConditionPlan,
    LawSpec,
    MapAxis,
    ObserverChoice,
    SearchPlan,
    StudySpec,
)

LARGEST_NUMBER = 1e300
FILE = "file"  # key of a recorded signal
LEVELS = (0.5, 1.0, 2.0, 4.0, 8.0)
NAME = "abcdefghijklmnopqrstuvwxyz0123456789-"  # of laws, levels and kinds: they name files


def text_at(table: LayeredTable, name: str, default: str | None = None) -> str:
    if not table.has(name):
        if default is None:
            raise table.error(f"needs {name}")
        return default
    entry = table.entry(name)
    if not isinstance(entry.value, str) or not entry.value.strip():
        raise entry.error("must be a text")
    return entry.value


def texts_at(
    table: LayeredTable, name: str, allowed: Sequence[str] | None = None, default: Sequence[str] = ()
) -> list[str]:
    """Different texts, of those that are allowed; any if None."""
    if not table.has(name):
        return list(default)
    entry = table.entry(name)
    found = entry.value
    if not isinstance(found, list) or not found or not all(isinstance(one, str) for one in found):
        raise entry.error("must be a list of texts")
    if len(set(found)) < len(found):
        raise entry.error("names one twice")
    for one in found:
        if allowed is not None and one not in allowed:
            raise entry.error(f"names {one!r}; it {one_of(one, allowed)}")
    return found


def whole_at(table: LayeredTable, name: str, low: int, high: int, default: int) -> int:
    """A whole number between two others."""
    if not table.has(name):
        return default
    entry = table.entry(name)
    try:
        return whole_number(name, entry.value, low, high)
    except ParameterError as error:
        raise entry.error(error.allowed) from None


def number_list_at(
    table: LayeredTable, name: str, low: float, high: float, default: Sequence[float]
) -> list[float]:
    """Different numbers between two others, the smallest first."""
    if not table.has(name):
        return list(default)
    entry = table.entry(name)
    found = entry.value
    real = isinstance(found, list) and all(map(is_number, found))
    if not real or not found or not all(low <= one <= high for one in found) or sorted(set(found)) != found:
        raise entry.error(f"must be a list of numbers from {low:g} to {high:g}, the smallest first")
    return [float(one) for one in found]


def number_of(entry: TableEntry) -> float:
    """A finite number."""
    value = entry.value
    if not is_number(value) or not -LARGEST_NUMBER <= value <= LARGEST_NUMBER:
        raise entry.error(f"must be a number from {-LARGEST_NUMBER:g} to {LARGEST_NUMBER:g}")
    return float(value)


def changes_in(table: LayeredTable, name: str) -> dict[str, Any]:
    """Changes to a scenario by dotted path, as they stand in nested tables or under dotted keys."""
    return {path: entry_value(entry) for path, entry in table.table(name).entries()}


def entry_value(entry: TableEntry) -> Any:
    """A value as any folder may have it: the path of a recording from here, not from its own file."""
    is_file = entry.key.rpartition(".")[2] == FILE and isinstance(entry.value, str)
    return str(entry.origin.folder / entry.value) if is_file else entry.value


def entries_at(table: LayeredTable, name: str) -> dict[str, TableEntry]:
    """What varies by path, each as an entry that says where it stands."""
    return dict(table.table(name).entries())


def read_study(source: str | Path, changes: Mapping[str, object] | None = None) -> StudySpec:
    """The study that a file asks for."""
    origin, content = locate_source(source, "studies")
    overrides = Layer(FileOrigin(f"{origin.name}, overridden", Path()), nest_changes(changes or {}))
    top = LayeredTable("", (overrides, Layer(origin, parse_toml(content, origin.name))))
    keys = ("title", "base", "plugins", "set", "metric", "reference", "known")
    top.check_keys((*keys, "laws", "observers", "axes", "conditions", "search", "limits"))
    observers = {
        name: observer_choice(top.table("observers").table(name)) for name in table_names(top, "observers")
    }
    laws = {law.name: law for law in laws_in_file(top, tuple(observers))}
    if not laws:
        raise top.error("needs [laws]")
    reference = text_at(top, "reference", next(iter(laws)))
    if reference not in laws:
        raise top.entry("reference").error(one_of(reference, tuple(laws)))
    drawn = condition_plan(top.table("conditions"))
    return StudySpec(
        text_at(top, "title", origin.name),
        machine_of(top),
        [top.entry("plugins").origin.folder / one for one in texts_at(top, "plugins")],
        changes_in(top, "set"),
        text_at(top, "metric", "rms_error"),
        reference,
        entries_at(top, "known"),
        laws,
        observers,
        [map_axis(top.table("axes").table(name)) for name in table_names(top, "axes")],
        drawn,
        search_plan(top.table("search")),
        limit_count(top.table("limits"), drawn.counts["test"]),
        origin,
    )


def study_source(source: str | Path) -> str:
    """The TOML text of a study."""
    return locate_source(source, "studies")[1]


def table_names(top: LayeredTable, section: str) -> Iterator[str]:
    table = top.table(section)
    for name in table.names():
        if not name or set(name) - set(NAME):
            problem = "must be a name of lower-case letters, digits and hyphens, as files are named after it"
            raise ScenarioError(table.origin.name, table.key(name), problem)
        yield name


def scenario_at(table: LayeredTable, name: str) -> str | Path:
    """The scenario that a key names."""
    text_at(table, name)
    return named_source(table.entry(name))


def machine_of(top: LayeredTable) -> str | Path:
    """The scenario of the machine, which has no law: its gains would show through those that a law leaves."""
    found = scenario_at(top, "base")
    if layered_table(found, {}).table("controller").names():
        raise top.entry("base").error(
            "has a [controller]; it must be a scenario without, as laws are in [laws]"
        )
    return found


def laws_in_file(top: LayeredTable, observers: Sequence[str]) -> Iterator[LawSpec]:
    """The laws of a file, each with each of the observers that it is to have."""
    found: dict[str, LawSpec] = {}
    table = top.table("laws")
    for name in table_names(top, "laws"):
        for one in laws_in_table(table.table(name), name, found, observers):
            if one.name in found:
                raise table.entry(name).error(f"makes a second law named {one.name}")
            found[one.name] = one
            yield one


def laws_in_table(
    table: LayeredTable, name: str, before: Mapping[str, LawSpec], observers: Sequence[str]
) -> Iterator[LawSpec]:
    """One table of laws: a law with each of its observers, or one of those before without a part."""
    if table.has("of"):
        table.check_keys(("of", "without", "set", "unwrapped", "wrapped"))
        of = text_at(table, "of")
        if of not in before:
            raise table.entry("of").error(f"must be a law before it; it {one_of(of, tuple(before))}")
        whole_law = before[of]._replace(name=name, of=of, without=text_at(table, "without"))
        yield with_table_changes(whole_law, table)
        return
    table.check_keys(("scenario", "family", "set", "observers", "of", "unwrapped", "wrapped"))
    scenario, family = scenario_at(table, "scenario"), text_at(table, "family", name)
    plain = with_table_changes(LawSpec(name, family, scenario, {}, "", "", "", False, {}), table)
    chosen = texts_at(table, "observers", observers)
    if not chosen:
        yield plain
    for one in chosen:
        yield plain._replace(name=f"{name}-{one}", observer=one)


def with_table_changes(law: LawSpec, table: LayeredTable) -> LawSpec:
    changes = changes_in(table, "set")
    for path in changes:
        if not path.startswith("controller."):
            problem = f"sets {path}, which does not belong to the law; it must begin with controller"
            raise table.error(problem)
    return law._replace(
        changes={**law.changes, **changes},
        unwrapped=flag_at(table, "unwrapped", law.unwrapped),
        wrapped=changes_in(table, "wrapped") or law.wrapped,
    )


def flag_at(table: LayeredTable, name: str, default: bool) -> bool:
    """Whether a key says true."""
    if not table.has(name):
        return default
    entry = table.entry(name)
    if not isinstance(entry.value, bool):
        raise entry.error("must be true or false")
    return entry.value


def observer_choice(table: LayeredTable) -> ObserverChoice:
    """An observer that laws are given."""
    table.check_keys(("set", "vary", "drop"))
    changes = changes_in(table, "set")
    if "type" not in changes:
        raise table.error("needs set.type, the observer's")
    return ObserverChoice(changes, entries_at(table, "vary"), texts_at(table, "drop"))


def map_axis(table: LayeredTable) -> MapAxis:
    table.check_keys(("label", "levels"))
    levels = table.table("levels")
    name = table.path.rpartition(".")[2]
    found = [axis_level(levels.table(one)) for one in table_names(table, "levels")]
    if not found:
        raise table.error("needs levels")
    return MapAxis(name, text_at(table, "label", name), found)


def axis_level(table: LayeredTable) -> AxisLevel:
    table.check_keys(("label", "value", "set", "vary"))
    name = table.path.rpartition(".")[2]
    value = None
    if table.has("value"):
        value = number_of(table.entry("value"))
    return AxisLevel(
        name, text_at(table, "label", name), value, changes_in(table, "set"), entries_at(table, "vary")
    )


def condition_plan(table: LayeredTable) -> ConditionPlan:
    """What is drawn, and how often; where the file is silent, the defaults."""
    splits = ("train", "validation", "test")
    table.check_keys(("seed", *splits, "stress", "stressed", "vary", "kinds"))
    counts = {
        name: whole_at(table, name, 1, 100_000, few) for name, few in zip(splits, (8, 8, 200), strict=True)
    }
    kinds = table.table("kinds")
    found = [condition_kind(kinds.table(name)) for name in table_names(table, "kinds")] or [
        ConditionKind("all", {}, {})
    ]
    return ConditionPlan(
        whole_at(table, "seed", 0, 2**63 - 1, 0),
        counts,
        number_list_at(table, "stress", 0.0, 1e3, ()),
        whole_at(table, "stressed", 1, counts["test"], min(20, counts["test"])),
        entries_at(table, "vary"),
        found,
    )


def condition_kind(table: LayeredTable) -> ConditionKind:
    table.check_keys(("set", "vary"))
    return ConditionKind(table.path.rpartition(".")[2], changes_in(table, "set"), entries_at(table, "vary"))


def search_plan(table: LayeredTable) -> SearchPlan:
    """How gains are searched; where the file is silent, the defaults."""
    table.check_keys(("candidates", "seeds", "step", "levels", "widen"))
    return SearchPlan(
        candidates_in(table),
        whole_at(table, "seeds", 1, 1000, 1),
        step_in(table),
        levels_in(table),
        whole_at(table, "widen", 0, 5, 2),
    )


def candidates_in(table: LayeredTable) -> int:
    """The most that a search tries: a power of 2, for a search looks at its front after each."""
    found = whole_at(table, "candidates", 256, 2**20, 2048)
    if found & (found - 1):
        raise table.entry("candidates").error("must be a power of 2 from 256 on, such as 512 or 4096")
    return found


def levels_in(table: LayeredTable) -> list[float]:
    """Activities over that of the reference, its own among them."""
    found = number_list_at(table, "levels", 1e-3, 1e3, LEVELS)
    if 1.0 not in found:
        raise table.entry("levels").error("must contain 1, the activity of the reference")
    return found


def step_in(table: LayeredTable) -> float | None:
    """The longest integration step while searching [s]; None, as those of the machine, where it is silent."""
    if not table.has("step"):
        return None
    entry = table.entry("step")
    try:
        found = si_value(str(entry.value), "s")
    except ValueError as error:
        raise entry.error(str(error)) from None
    if not found > 0.0:
        raise entry.error("must be a time above 0")
    return found


def limit_count(table: LayeredTable, most: int) -> int:
    """Of how many test conditions limits are sought; where the file is silent, of none."""
    table.check_keys(("conditions",))
    return whole_at(table, "conditions", 0, most, 0)
