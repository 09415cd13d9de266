"""Inputs by their kind: what is drawn of each, what hydroservo makes of it, and what it must refuse.

Each kind is a function of a :class:`Stock` and of draws, and gives a :class:`Given`.
"""

import json
import math
import random
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import tomli_w

from hydroservo.scenario import Assembly, assemble, load_scenario, parse_override, scenario_source, scenarios
from tools.promises.logs import drawn_log, read, wrong_log
from tools.promises.mutations import (
    canonical,
    drawn_value,
    mutated_tables,
    mutated_text,
    numbers_of,
    tables_of,
)
from tools.promises.results import drawn_plugin, run_plugin

Draw = random.Random
Wrong = tuple[str, Any]  # what is wrong, and a value that has it
MOST = 512  # inputs that a stock keeps because they reach new lines
DIMENSIONS = {"m": "1 kg", "kg": "1 bar", "Pa": "1 mm", "s": "1 V", "V": "1 s", "N": "1 m/s", "": "1 bar"}


class Given(NamedTuple):
    """An input.

    Attributes:
        what: the input, in words that JSON has.
        files: that it is in, by their names.
        use: what hydroservo does with it, in the folder of its files; returns a loop if there is one.
        wrong: what is wrong with it, so that it must be refused; "" where nobody knows.
        text: of a scenario, for the stock.
    """

    what: Any
    files: Mapping[str, bytes]
    use: Callable[[Path], Any]
    wrong: str = ""
    text: str = ""


class Stock(NamedTuple):
    """What inputs are drawn from: scenarios that ship, and inputs that reached new lines."""

    names: list[str]
    texts: list[str]
    tables: list[dict[str, Any]]
    numbers: dict[str, list[tuple[str, Any, Any]]]  # of each shipped scenario: path, declaration, value
    keys: list[str]  # of overrides

    def keep(self, text: str) -> None:
        """Draw from a scenario's text too; the oldest of such texts goes when there are too many."""
        self.texts.append(text)
        tables = tables_of(text)
        if tables is not None:
            self.tables.append(tables)
        for kept, first in ((self.texts, len(self.names)), (self.tables, 2 * len(self.names))):
            if len(kept) > first + MOST:
                del kept[first]


def stock() -> Stock:
    """A stock of what ships."""
    names = list(scenarios())
    made: dict[str, Assembly] = {name: assemble(name) for name in names}
    texts = [scenario_source(name) for name in names]
    tables = [found for text in texts if (found := tables_of(text)) is not None]
    tables += [canonical(one.loop) for one in made.values()]
    numbers = {name: list(numbers_of(one.drafts)) for name, one in made.items()}
    keys = sorted({path for one in numbers.values() for path, _, _ in one})
    return Stock(names, texts, tables, numbers, keys)


def load(folder: Path) -> Any:
    """The loop of the scenario in a folder."""
    return load_scenario(folder / "a.toml")


def again(loop: Any, folder: Path) -> Any:
    """The loop that another's canonical text makes."""
    (folder / "again.toml").write_text(tomli_w.dumps(canonical(loop)), "utf-8")
    return load_scenario(folder / "again.toml")


def by_structure(from_: Stock, draw: Draw) -> Given:
    tables = mutated_tables(draw.choice(from_.tables), from_.tables, draw)
    try:
        text = tomli_w.dumps(tables)
    except (TypeError, ValueError):  # a key that is no text
        text = ""
    content = text.encode("utf-8", "replace")
    return Given(text, {"a.toml": content}, load, text=content.decode())


def by_characters(from_: Stock, draw: Draw) -> Given:
    content = mutated_text(draw.choice(from_.texts), draw.choice(from_.texts), draw)
    text = content.decode("utf-8", "replace")
    return Given(content.decode("latin-1"), {"a.toml": content}, load, text=text)


def overrides(from_: Stock, draw: Draw) -> Given:
    """A scenario that ships, with texts that ``--set`` takes."""
    name, texts = draw.choice(from_.names), []
    for _ in range(draw.choice((1, 1, 2, 4))):
        path = draw.choice(from_.keys if draw.random() < 0.3 else [one[0] for one in from_.numbers[name]])
        if draw.random() < 0.3:
            path = draw.choice(
                (
                    path.rpartition(".")[0] + ".type",
                    path.partition(".")[0],
                    path + ".x",
                    path[:-1],
                    f"truth.{path}",
                )
            )
        value = drawn_value(draw)
        texts.append(f"{path}={value if isinstance(value, str) else json.dumps(value, default=str)}")

    def use(_folder: Path) -> Any:
        return load_scenario(name, dict(map(parse_override, texts)))

    return Given([name, *texts], {}, use)


def wrong(from_: Stock, draw: Draw) -> Given:
    """A scenario that ships, with one number that it must refuse."""
    name = draw.choice(from_.names)
    path, field, value = draw.choice(from_.numbers[name])
    said, bad = draw.choice(list(wrongs(field, value)))
    if said == "an unknown key":
        path, bad = f"{path.rpartition('.')[0]}.{bad}", value if math.isfinite(value) else 1.0
    return Given([name, path, repr(bad)], {}, lambda _folder: load_scenario(name, {path: bad}), said)


def wrongs(field: Any, value: Any) -> Any:
    """Each way in which a number can be wrong, with a value that is."""
    yield "an unknown key", "unheard_of"
    yield from (("a wrong type", one) for one in ([1.0], {}, "much"))
    yield "not a number", math.nan
    yield "not a number", "nan"
    if not isinstance(value, bool):
        yield "a wrong type", True
    if field.auto != math.inf:
        yield "infinite", math.inf
    if isinstance(value, float) and field.unit in DIMENSIONS:
        yield "a wrong dimension", DIMENSIONS[field.unit]
    if isinstance(value, int):
        yield "a fraction", 0.5
    low = field.above if field.at_least is None else field.at_least
    high = field.below if field.at_most is None else field.at_most
    if low is not None and field.auto != low - 1.0:
        yield "out of range", low - 1.0 - abs(low)
    if high is not None:
        yield "out of range", high + 1.0 + abs(high)
    if field.above is not None and field.auto != field.above:
        yield "out of range", field.above


def twice(from_: Stock, draw: Draw) -> Given:
    """A scenario that ships, with one of its lines twice."""
    lines = draw.choice(from_.texts[: len(from_.names)]).splitlines()
    at = draw.choice([i for i, line in enumerate(lines) if line[:1].isalnum() and " = " in line])
    text = "\n".join([*lines[:at], lines[at], *lines[at:]])
    return Given(
        text,
        {"a.toml": text.encode()},
        load,
        "a key that is there twice" if lines[at].count('"""') != 1 else "",
    )


def log(_from: Stock, draw: Draw) -> Given:
    name, content, what = drawn_log(draw)
    return Given(what, {name: content}, lambda folder: read(folder / name))


def refused_log(_from: Stock, draw: Draw) -> Given:
    name, content, what, said = wrong_log(draw)
    return Given(what, {name: content}, lambda folder: read(folder / name), said)


def plugin(_from: Stock, draw: Draw) -> Given:
    text = drawn_plugin(draw)
    return Given(text, {"law.py": text.encode()}, lambda folder: run_plugin(folder / "law.py"))


KINDS: dict[str, tuple[Callable[[Stock, Draw], Given], float]] = {
    "scenario, by its structure": (by_structure, 0.34),
    "scenario, by its characters": (by_characters, 0.12),
    "overrides": (overrides, 0.24),
    "a wrong number": (wrong, 0.16),
    "a key twice": (twice, 0.02),
    "log": (log, 0.08),
    "a wrong log": (refused_log, 0.03),
    "result of a plug-in": (plugin, 0.05),
}
"""What is drawn, and how often."""
