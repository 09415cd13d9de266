"""The keys that a table of a scenario may have, and what its types are, in words."""

import inspect
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from hydroservo.control.loop import Loop, Simulation
from hydroservo.core.block import is_block
from hydroservo.core.curve import Curve
from hydroservo.core.errors import ParameterError, nearest
from hydroservo.core.field import CONTROLLED, OPEN, Field, declared_fields
from hydroservo.core.roles import Monitor
from hydroservo.core.roles.saying import is_role
from hydroservo.scenario.other_tables import FULL_SCALE
from hydroservo.scenario.part_files import PART, part_texts
from hydroservo.scenario.records.series import curve_keys
from hydroservo.scenario.registry import (
    Maker,
    defaults,
    is_block_class,
    known_classes,
    makers,
    makers_in_role,
)
from hydroservo.scenario.role_checks import ROLES, argument_types, possible_roles
from hydroservo.scenario.scenario_files import builtin_texts, is_builtin

ANY_SIGNAL = Field(CONTROLLED, "controlled signal")
SETTINGS = "simulation"  # the table without types
ROLE_IN_TEXT = re.compile(r":\w+:`~?(?:[\w.]*\.)?([^`]*)`")
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


class Key(NamedTuple):
    """A key of a table."""

    name: str  # as it is written
    kind: Any  # float, int or bool, Curve, a role, or a class of blocks
    default: Any  # what holds without it; None if it must be there
    field: Field | None  # the declaration of a number; None of a nested block that declares none

    @property
    def nests(self) -> bool:
        """Whether it is a table of a block."""
        return self.kind is not Curve and (
            is_role(self.kind) or is_block_class(self.kind) or is_block(self.default)
        )

    @property
    def shown(self) -> str:
        """The default as a scenario has it; empty where there is none."""
        if self.kind is Curve:
            return "straight" if self.default is not None and self.default.coefficients.any() else ""
        if is_block(self.default):
            return type(self.default).__name__
        if isinstance(self.default, bool):
            return str(self.default).lower()
        if isinstance(self.default, np.ndarray):
            return "from a file"
        if not isinstance(self.default, int | float):
            return ""
        automatic = self.field is not None and self.default == self.field.auto
        return '"auto"' if automatic else f"{self.default:g}"

    @property
    def meaning(self) -> str:
        """What it is for; of a table, what block that must be."""
        if self.nests:
            return f"a table: {getattr(self.kind, '__name__', 'a block')}"
        return self.field.of(ANY_SIGNAL).meaning if self.field else ""

    def as_dict(self) -> dict[str, str]:
        """All of it in words."""
        field = Field("", "") if self.nests or self.field is None else self.field.of(ANY_SIGNAL)
        return {
            "name": self.name,
            "default": self.shown,
            "unit": f"{field.unit or 1} over {field.over or 1}" if self.kind is Curve else field.unit,
            "range": range_text(field),
            "meaning": self.meaning,
            "source": field.source,
        }


def keys_of(maker: Maker) -> list[Key]:
    """The keys of a table whose ``type`` names a block's class, or a constructor of one, in their order."""
    kinds, fields = argument_types(maker), declared_fields(maker)
    return [
        Key(name, kinds.get(name), default, fields.get(name)) for name, default in defaults(maker).items()
    ]


def range_text(field: Field) -> str:
    """The range of a number, such as ``> 0, ≤ 1``; empty where it may be any."""
    limits = ((">", field.above), ("≥", field.at_least), ("<", field.below), ("≤", field.at_most))
    found = [f"{sign} {limit:g}" for sign, limit in limits if limit is not None]
    return ", ".join(found if field.auto is None else [*found, 'or "auto"'])


class Description(NamedTuple):
    """A type in words."""

    name: str  # as ``type`` gives it
    roles: list[str]  # that its class can play
    text: str  # what it is, its equation, its source and where it fails
    keys: list[Key]  # of its table

    def as_dict(self) -> dict[str, Any]:
        """All of it as JSON has it."""
        return {**self._asdict(), "keys": [key.as_dict() for key in self.keys]}


def types_by_role() -> dict[str, list[str]]:
    """The types of each role that has some, those of a scenario's tables first."""
    tables = [role for role in argument_types(Loop).values() if role in ROLES]
    rest = [role for role in ROLES if role not in tables]
    found = {role.__name__: [*makers_in_role(role)] for role in (*tables, *rest)}
    return {name: types for name, types in found.items() if types}


def role_named(name: str) -> Mapping[str, Maker]:
    """The types of a role, or of a table of a scenario, by their names; none where it is neither."""
    role = Monitor if name.lower() == "metrics" else argument_types(Loop).get(name.lower())
    if role not in ROLES:
        role = next((one for one in ROLES if one.__name__.lower() == name.lower()), None)
    return {} if role is None else makers_in_role(role)


def describe_types(name: str) -> list[Description]:
    """The types of a name in words; there are several where blocks of different roles share it."""
    named = [(cls, maker) for cls in known_classes() if (maker := makers(cls).get(name)) is not None]
    if not named and name.lower() == SETTINGS:
        return [Description(SETTINGS, ["table"], docstring_text(Simulation), keys_of(Simulation))]
    if not named:
        types = types_by_role()
        known = [SETTINGS, *types, *(name for names in types.values() for name in names)]
        shown = f"; `hydroservo scenarios show {name}` shows this one" if is_builtin(name) else ""
        problem = f"is not a type, role or table of a scenario{shown or nearest(name, known)}"
        raise ParameterError("name", name, problem)
    return [
        Description(
            name, [role.__name__ for role in possible_roles(cls)], docstring_text(maker), keys_of(maker)
        )
        for cls, maker in named
    ]


def first_sentence(maker: Maker) -> str:
    """The first sentence of what a type says of itself."""
    return docstring_text(maker).partition("\n\n")[0].replace("\n", " ")


def docstring_text(maker: Maker) -> str:
    """What a type says of itself, without marks of reStructuredText."""
    text = ROLE_IN_TEXT.sub(r"\1", inspect.cleandoc(maker.__doc__ or ""))
    return re.sub(r"::$", ":", text.replace("``", ""), flags=re.M)


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
        "definitions": {"numbers": nested_numbers_schema(), PART: part_schema()},
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
    known: Schema = {
        "type": with_description({"enum": [name]}, first_sentence(maker)),
        PART: {"$ref": "#/definitions/part"},
    }
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


def part_schema() -> Schema:
    """The name of a part, or the path of its file."""
    return with_description({"anyOf": [{"enum": [*part_texts()]}, TEXT]}, "the part that the table changes")


def nested_numbers_schema() -> Schema:
    """Numbers by their paths, as nested tables."""
    ways: Sequence[Schema] = [{"type": ["number", "string"]}, {"$ref": "#/definitions/numbers"}]
    return {"type": "object", "additionalProperties": {"anyOf": [*ways]}}


def closed_table(keys: Schema) -> Schema:
    return {"type": "object", "properties": keys, "additionalProperties": False}


def with_description(schema: Schema, text: str) -> Schema:
    return {**schema, "description": text}
