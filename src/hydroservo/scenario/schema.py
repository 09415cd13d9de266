"""The JSON Schema of scenarios, by which an editor completes and checks them while they are written."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from hydroservo.control.loop import Loop
from hydroservo.core.curve import Curve
from hydroservo.core.field import OPEN, Field
from hydroservo.core.roles import Monitor
from hydroservo.core.roles.saying import is_role
from hydroservo.scenario.keys import ANY_SIGNAL, Key, first_sentence, keys_of, range_text
from hydroservo.scenario.layers import builtin_texts
from hydroservo.scenario.other_tables import FULL_SCALE
from hydroservo.scenario.records.series import curve_keys
from hydroservo.scenario.registry import Maker, makers, makers_in_role

Schema = dict[str, Any]

DIALECT = "http://json-schema.org/draft-07/schema#"  # what editors of TOML know
QUANTITY = r"^\s*[-+]?(\d|\.\d)"  # a text that begins with a number
TEXT: Schema = {"type": "string"}
TEXTS: Schema = {"type": "array", "items": TEXT}
NUMBERS: Schema = {"type": "array", "items": {"type": ["number", "string"]}}
POINTS: Schema = {"type": "array", "minItems": 2, "items": {**NUMBERS, "minItems": 2, "maxItems": 2}}
WHOLE: Schema = {"type": "integer", "minimum": 0}
KINDS = {float: "number", int: "integer", bool: "boolean"}
LIMITS = {
    "above": "exclusiveMinimum",
    "at_least": "minimum",
    "below": "exclusiveMaximum",
    "at_most": "maximum",
}
TUNE: Schema = {
    "vary": {"$ref": "#/definitions/numbers"},
    "scenarios": TEXTS,
    "weights": NUMBERS,
    "scales": NUMBERS,
    "metric": TEXT,
    "seeds": WHOLE,
    "effort": {"type": "number", "minimum": 0},
    "candidates": WHOLE,
    "seed": WHOLE,
    "bounded": {"type": "boolean"},
    **{name: {"type": ["string", "number"]} for name in ("gain_margin", "phase_margin", "max_sensitivity")},
}
IDENTIFY: Schema = {
    "columns": {"type": "object", "additionalProperties": TEXT},
    "vary": {"$ref": "#/definitions/numbers"},
}


def scenario_schema() -> Schema:
    """The JSON Schema (draft 7) of a scenario with the blocks that are known here, plug-ins' among them::

        Path("hydroservo.schema.json").write_text(json.dumps(hs.scenario.scenario_schema()))

    A scenario that builds on another gives what it changes, so no key is asked for. A text with a unit is
    taken for any quantity: whether it is of the right one, and within its range, is found on loading.
    """
    found: Schema = {
        "$schema": DIALECT,
        "title": "hydroservo scenario",
        "type": "object",
        "definitions": {"numbers": nested_numbers_schema()},
        "properties": {
            "title": with_description(TEXT, "what the scenario is, in a line"),
            "base": with_description(
                {"anyOf": [{"enum": [*builtin_texts()]}, TEXT]}, "the scenario that it changes"
            ),
            "uncertainty": {"$ref": "#/definitions/numbers"},
            "truth": {"$ref": "#/definitions/numbers"},
            "tune": closed_table(TUNE),
            "identify": closed_table(IDENTIFY),
        },
        "additionalProperties": False,
    }
    definitions, tables = found["definitions"], found["properties"]
    for key in keys_of(Loop):
        if key.name not in ("metrics", "command"):
            tables[key.name] = block_schema(key.kind, key.default, definitions)
    scale = with_description(TEXT, 'what 10 V of command stand for: "40 mA", "100 %"; without it "10 V"')
    tables["command"] = closed_table({FULL_SCALE: scale})
    usual = {"usual": with_description({"type": "boolean"}, "whether the usual metrics count too")}
    tables["metrics"] = closed_table(usual) | {
        "additionalProperties": block_schema(Monitor, None, definitions)
    }
    tables["start"]["anyOf"].append({"const": "steady"})
    return found


def block_schema(kind: Any, default: Any, definitions: Schema) -> Schema:
    """The table of a block: any of those that its role, or its class, leaves open."""
    if is_role(kind):
        named = makers_in_role(kind)
    else:
        named = makers(kind if isinstance(kind, type) and hasattr(kind, "_fields") else type(default))
    return {"anyOf": [{"$ref": one} for one in type_references(named, definitions)]}


def type_references(named: Mapping[str, Maker], definitions: Schema) -> Iterator[str]:
    """Where each block stands in the schema, after it has been put there."""
    for name, maker in named.items():
        cls = maker if isinstance(maker, type) else maker.__self__  # type: ignore[attr-defined]
        place = f"{cls.__module__}.{name}"
        if place not in definitions:
            definitions[place] = {}  # a block may nest its own kind
            definitions[place] = type_schema(name, maker, definitions)
        yield f"#/definitions/{place}"


def type_schema(name: str, maker: Maker, definitions: Schema) -> Schema:
    """The table of a block of a known type."""
    known: Schema = {"type": with_description({"enum": [name]}, first_sentence(maker))}
    for key in keys_of(maker):
        if key.name == "given":  # of a start: states by their paths
            known[key.name] = {"$ref": "#/definitions/numbers"}
        elif key.field is None or not key.field.derived:
            known[key.name] = key_schema(key, definitions)
    return closed_table(known) | {"title": name}


def key_schema(key: Key, definitions: Schema) -> Schema:
    """What stands under a key."""
    if key.kind is Curve:
        more = {"full": TEXT} if key.field and not key.field.over else {}
        ways: tuple[Schema, ...] = (dict.fromkeys(curve_keys(key.field), TEXT), {"points": POINTS})
        return {"anyOf": [closed_table(way | more) | {"required": [next(iter(way))]} for way in ways]}
    if key.nests:
        return block_schema(key.kind, key.default, definitions)
    return number_schema(key)


def number_schema(key: Key) -> Schema:
    """A number, and for a quantity a text with its unit."""
    field = (key.field or Field("", key.name)).of(ANY_SIGNAL)
    limits = {LIMITS[name]: getattr(field, name) for name in LIMITS if getattr(field, name) is not None}
    plain: Schema = {"type": KINDS[key.kind], **(limits if key.kind is not bool else {})}
    ways = [plain]
    if key.kind is float:
        ways.append({"type": "string", "pattern": QUANTITY})
    if field.auto is not None:
        ways += [{"const": "auto"}] if field.auto == OPEN else [{"const": "auto"}, {"const": field.auto}]
    found: Schema = ways[0] if len(ways) == 1 else {"anyOf": ways}
    if isinstance(key.default, float | int) and key.default != field.auto:
        found["default"] = key.default
    return with_description(found, number_text(field))


def number_text(field: Field) -> str:
    """A number in words: what it is, its unit and its range."""
    told = ", ".join(part for part in (f"[{field.unit}]" if field.unit else "", range_text(field)) if part)
    return f"{field.meaning} {told}".strip()


def nested_numbers_schema() -> Schema:
    """Numbers by their paths, as nested tables."""
    ways: Sequence[Schema] = [{"type": ["number", "string"]}, {"$ref": "#/definitions/numbers"}]
    return {"type": "object", "additionalProperties": {"anyOf": [*ways]}}


def closed_table(keys: Schema) -> Schema:
    """A table that has these keys alone."""
    return {"type": "object", "properties": keys, "additionalProperties": False}


def with_description(schema: Schema, text: str) -> Schema:
    return {**schema, "description": text}
