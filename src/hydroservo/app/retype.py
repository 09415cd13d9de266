"""Another type for a block: with the numbers of a built-in scenario where it has none by default."""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

from hydroservo.app.form import failure_on_page, number_entry, problem_in_own_unit
from hydroservo.app.source import Source, checked_changes
from hydroservo.control.loop import Loop
from hydroservo.core.errors import ScenarioError, short
from hydroservo.core.field import Field, declared_fields
from hydroservo.scenario import Assembly, assemble, scenarios
from hydroservo.scenario.build import Draft, maker_named
from hydroservo.scenario.quantities import si_value
from hydroservo.scenario.registry import defaults
from hydroservo.scenario.role_checks import argument_types
from hydroservo.scenario.tables import FileOrigin, TableEntry

MOST_TRIES = 12
CONTROLS = "controls"  # the one block that is a name alone


class Retyped(NamedTuple):
    """Changes with another type among them."""

    changes: dict[str, object]  # by path
    origin: str  # the scenario that numbers without default are from; "" if there is none
    # numbers that are yet to be given, as a form has them, with a text to begin with
    missing: list[dict[str, Any]] = []  # noqa: RUF012, for it is never changed


def retype(source: Source, path: str, wanted: str) -> Retyped:
    """The changes of a scenario with another type for the block at a path."""
    kept = {key: value for key, value in source.changes.items() if not key.startswith(f"{path}.")}
    bare = {**kept, f"{path}.type": wanted}
    try:
        source._replace(changes=bare).assemble()
    except ScenarioError as error:
        problem = error
    else:
        return Retyped(bare, "")
    for name, numbers in scenarios_with_type(str(source.scenario), wanted)[:MOST_TRIES]:
        filled = {**bare, **{f"{path}.{key}": value for key, value in numbers.items()}}
        try:
            source._replace(changes=filled).assemble()
        except ScenarioError:
            continue
        return Retyped(filled, name)
    missing = [] if path == CONTROLS else list(missing_numbers(source, path, wanted))
    if not missing:
        raise ScenarioError(problem.file, f"{path}.type", f"{wanted}: {problem.key}: {problem.problem}")
    return Retyped(bare, "", missing)


def complete_retyped(source: Source, found: Retyped, given: Mapping[str, object]) -> Retyped:
    """The changes of another type with the numbers that it asked for."""
    entries = {one["path"]: one for one in found.missing}
    changes = dict(checked_changes({**found.changes, **{path: given.get(path, "") for path in entries}}))
    try:
        source._replace(changes=changes).assemble()
    except ScenarioError as error:
        path, problem = failure_on_page(error).values()
        if path in entries:
            problem = problem_in_own_unit(problem, str(changes[path]), entries[path])
        raise ScenarioError(error.file, path, problem) from None
    return Retyped(changes, "")


def missing_numbers(source: Source, path: str, wanted: str) -> Iterator[dict[str, Any]]:
    """The numbers without default of a type, with those of a built-in scenario where they are of the unit."""
    assembly = source.assemble()
    signal = assembly.loop.controls.declared()
    maker = maker_at(assembly, path, wanted)
    fields, kinds = declared_fields(maker), argument_types(maker)
    found = scenarios_with_type(str(source.scenario), wanted)
    for name, default in defaults(maker).items():
        if default is None and kinds.get(name) in (float, int):
            field = fields.get(name, Field("", name)).of(signal)
            given = [numbers[name] for _, numbers in found if name in numbers]
            text = next((str(one) for one in given if has_unit(one, field.unit)), "")
            yield number_entry(f"{path}.{name}", kinds[name], field, text)


def maker_at(assembly: Assembly, path: str, wanted: str) -> Any:
    """What makes a type for the block at a path of a loop."""
    first, *names = path.split(".")
    draft: Any = assembly.drafts.get(first)
    hint: Any = argument_types(Loop).get(first)
    for name in names if isinstance(draft, Draft) else ():
        hint = argument_types(draft.maker).get(name)
        draft = draft.members.get(name)
        if not isinstance(draft, Draft):
            break
    if not isinstance(draft, Draft):
        raise ScenarioError("", short(path), "is not a block that can have another type here")
    return maker_named(
        hint, None, TableEntry(FileOrigin("", draft.table.origin.folder), f"{path}.type", wanted)
    )


def has_unit(value: object, unit: str) -> bool:
    """Whether a value is a text with a number of a unit."""
    try:
        si_value(str(value), unit)
    except ValueError:
        return False
    return isinstance(value, str)


def scenarios_with_type(near: str, wanted: str) -> list[tuple[str, Mapping[str, object]]]:
    """The built-in scenarios that have a block of a type, those of a scenario's own folder first."""
    folder = near.partition("/")[0]
    found = [(name, numbers[wanted]) for name, numbers in builtin_numbers().items() if wanted in numbers]
    return sorted(found, key=lambda one: not one[0].startswith(f"{folder}/"))


@cache
def builtin_numbers() -> dict[str, dict[str, Mapping[str, object]]]:
    """What each built-in scenario gives for its blocks, by their types."""
    return {name: dict(numbers_by_type(*assemble(name).drafts.values())) for name in scenarios()}


def numbers_by_type(*drafts: Draft) -> Iterator[tuple[str, Mapping[str, object]]]:
    """What is given for some blocks and those in them, each with its type; inner ones come first."""
    for draft in drafts:
        yield from numbers_by_type(*(one for one in draft.members.values() if isinstance(one, Draft)))
        maker: Any = draft.maker
        entries = {key: entry.value for key, entry in draft.table.entries() if key != "type"}
        if all(key.rpartition(".")[2] != "file" for key in entries):
            yield maker.__qualname__, entries
