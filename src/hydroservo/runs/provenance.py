"""What was run, as text and as a hash."""

import hashlib
import json
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
import tomli_w

from hydroservo._version import __version__
from hydroservo.control.controlled.this_signal import ThisSignal
from hydroservo.core.block import Block, is_block
from hydroservo.core.command_scale import CommandScale
from hydroservo.core.group import group_class
from hydroservo.show import Origin


def block_tables(block: Block) -> dict[str, Any]:
    """A block as nested tables: the type's name and every value in SI units.

    Arrays (recorded signals) are named by their length and SHA-256, not written out. In what a person reads
    commands is no part of it: the same loop in volts and in mA has one description.
    """
    named = type(block) is not group_class(block._fields)  # and no mere group of names
    table: dict[str, Any] = {"type": type(block).__name__} if named else {}
    if not type(block).__module__.startswith("hydroservo."):
        table["module"] = type(block).__module__  # of a plugin: holds a digest of its text
    for name in block._fields:
        value = getattr(block, name)
        if name == "controls" or isinstance(value, ThisSignal | CommandScale):  # which a loop says once
            continue
        if is_block(value):
            table[name] = block_tables(value)
        elif isinstance(value, np.ndarray):
            digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
            table[name] = f"{value.size} numbers, sha256 {digest}"
        else:
            table[name] = value
    return table


def canonical_toml(loop: Block) -> str:
    """A loop as canonical TOML in SI units, without what it is judged by, which changes nothing in a run."""
    tables = block_tables(loop)
    del tables["metrics"]
    tables["controls"] = block_tables(loop.controls)
    return toml_of_json(json.dumps(tables))


@lru_cache(maxsize=64)
def toml_of_json(tables: str) -> str:
    """Tables in JSON as TOML, which takes ten times as long to write: one loop is often run again.

    JSON tells 1 from 1.0 and 0.0 from -0.0, as equality does not.
    """
    return tomli_w.dumps(json.loads(tables))


def scenario_hash(loop: Block) -> str:
    """Twelve hexadecimal digits that name what is asked for, whatever its file looked like."""
    return hashlib.sha256(canonical_toml(loop).encode()).hexdigest()[:12]


def provenance(loop: Block, asked: Block) -> dict[str, Any]:
    """The attributes that every result carries."""
    return {
        "scenario": canonical_toml(loop),
        "hash": scenario_hash(asked),
        "version": __version__,
        "seed": loop.simulation.seed,
    }


def origin_of(name: str, attributes: Mapping[Any, Any]) -> Origin:
    """The origin of a result."""
    return Origin(name, str(attributes["hash"]), int(attributes["seed"]), str(attributes["scenario"]))


def origin_of_loop(name: str, loop: Block) -> Origin:
    """The origin of what was found of a loop without a run."""
    return origin_of(name, provenance(loop, loop))
