"""The scenario of a page as TOML: on its base, with what was changed."""

from collections.abc import Mapping
from typing import Any

from hydroservo.app.source import Source
from hydroservo.scenario import Assembly, scenario_source
from hydroservo.scenario.build import Draft
from hydroservo.scenario.layers import builtin_texts, nest_changes
from hydroservo.scenario.tables import parse_toml


def page_scenario_text(source: Source) -> str:
    """TOML that gives the loop of the page.

    On a built-in scenario it builds by ``base``; a file's own text is written with the changes in it, and
    keeps its base.
    """
    import tomli_w

    made, changes = source.assemble(), nest_changes(source.changes)
    if str(source.scenario) in builtin_texts():
        return tomli_w.dumps({"base": str(source.scenario), **changes})
    text = source.text or scenario_source(source.scenario)
    if not changes:
        return text
    tables = parse_toml(text, str(source.scenario))
    return tomli_w.dumps(merge_changes(tables, changes, made))


def merge_changes(tables: Mapping[str, Any], changes: Mapping[str, Any], made: Assembly) -> dict[str, Any]:
    """A file's tables with changes in them, without what another type does not have."""
    found = merge_tables(tables, changes)
    for name, draft in made.drafts.items():
        if isinstance(found.get(name), dict):
            found[name] = keep_known_keys(found[name], draft)
    return found


def merge_tables(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    found = dict(below)
    for name, value in above.items():
        old = found.get(name)
        found[name] = (
            merge_tables(old, value) if isinstance(value, Mapping) and isinstance(old, Mapping) else value
        )
    return found


def keep_known_keys(table: Mapping[str, Any], draft: Draft) -> dict[str, Any]:
    """A table with the keys that its type has."""
    kept = {name: value for name, value in table.items() if name == "type" or name in draft.members}
    for name, value in kept.items():
        inner = draft.members.get(name)
        if isinstance(value, Mapping) and isinstance(inner, Draft):
            kept[name] = keep_known_keys(value, inner)
    return kept
