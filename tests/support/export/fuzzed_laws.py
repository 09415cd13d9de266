"""Random laws as texts, of what ``law_parts`` holds."""

import re
from collections.abc import Callable, Mapping, Sequence
from random import Random
from textwrap import indent

from tests.support.export import law_parts as parts

LAW = '''\
class Law(NamedTuple):
    """A law of a test: u = ..."""

    gain: Annotated[float, Field("V s/m", "gain of the law", "this test")] = 3.0
    turns: Annotated[int, Field("", "whole number", "this test", at_least=1, at_most=9)] = {turns}
    reverse: bool = {reverse}
{fields}
    def init(self):
        return {first}
{methods}
    def step(self, s, y, r, dt):
{step}
'''
FIELDS = {
    "table": "table: np.ndarray = np.array([1.5, -0.0, 4.25])",
    "grid": "grid: np.ndarray = np.arange(6.0).reshape(3, 2).T",
    "series": "series: TimeSeries = RECORD",
    "band": "band: Band = Band()",
}
FIRST = (
    "a, b, c = y.velocity, r.value, 1.0",
    "k, n, flag = 1, 2, y.velocity > 0.5",
    "p, q = Pair(y.velocity, 0.25), Nest(Pair(2.0, r.value), 1.0)",
)
LAST = "return LawState(a * b - c, {x} + 1.0 * (k - n), Inner({y}, s.u))"
MADE = ("self.made({x}, {m})", "self.made({x}, k, {y}, flag={so})")  # calls of a helper method
MADE_HEAD = """\
def made(self, a, k, b=0.75, flag=True):
    c, n, p, q = b, 3, Pair(a, b), Nest(Pair(b, a), 1.0)
"""
MADE_LAST = "return {x}"
ODDITY = 0.3  # how many laws hold something that is mostly refused


class Writer:
    """Random texts of statements and expressions, of these names."""

    def __init__(
        self, random: Random, reals: Sequence[str], forms: Sequence[str], simple: Sequence[str], last: str
    ) -> None:
        self.random, self.forms, self.simple, self.last = random, forms, simple, last
        self.reals, self.targets = [*reals] * 3 + [*parts.EXTREMES], ["a", "b", "c"]
        self.counters: list[str] = []

    def filled(self, form: str, depth: int) -> str:
        """A form with all that stands for something in its place, nested to this depth."""
        return form.format_map(Filling(self, depth))

    def real(self, depth: int) -> str:
        if depth <= 0 or self.random.random() < 0.3:
            return self.random.choice([*self.reals, *self.some_counters()])
        return self.filled(self.random.choice(self.forms), depth - 1)

    def whole(self, depth: int) -> str:
        if depth <= 0 or self.random.random() < 0.5:
            return self.random.choice([*parts.WHOLES, *self.some_counters()])
        return self.filled(self.random.choice(parts.WHOLE_FORMS), depth - 1)

    def counter(self) -> str:
        counter = self.random.choice(parts.COUNTERS)
        self.counters += [counter] if counter not in self.counters else []
        return counter

    def some_counters(self) -> list[str]:
        """What may have no value here, or one of another kind, and so not often."""
        return self.counters if self.random.random() < 0.1 else []

    def condition(self, depth: int) -> str:
        forms = parts.CONDITIONS if depth <= 0 else parts.CONDITION_FORMS
        return self.filled(self.random.choice(forms), depth - 1)

    def pair(self, depth: int) -> str:
        return "p" if depth <= 0 else self.filled(self.random.choice(parts.RECORD_FORMS), depth - 1)

    def statement(self, depth: int) -> str:
        if depth > 0 and self.random.random() < 0.4:
            return self.filled(self.random.choice(parts.AROUND), depth)
        return self.filled(self.random.choice(self.simple), 2)

    def block(self, depth: int) -> str:
        lines = [self.statement(depth) for _ in range(self.random.randint(1, 3))]
        return indent("\n".join(lines), "    ")


class Filling(dict[str, str]):
    """What stands in a form; the same for each time it stands there."""

    def __init__(self, writer: Writer, depth: int) -> None:
        self.writer, self.depth = writer, depth

    def __missing__(self, key: str) -> str:
        self[key] = self.made(key)
        return self[key]

    def made(self, key: str) -> str:
        writer, depth = self.writer, self.depth
        choose = writer.random.choice
        ways: dict[str, Callable[[], str]] = {
            "x": lambda: writer.real(min(depth, 2)),
            "y": lambda: writer.real(min(depth, 2)),
            "m": lambda: writer.whole(min(depth, 1)),
            "n": lambda: writer.whole(min(depth, 1)),
            "so": lambda: writer.condition(min(depth, 1)),
            "p": lambda: writer.pair(min(depth, 2)),
            "t": lambda: choose([one for one in writer.targets if one not in self.values()]),
            "t2": lambda: choose([one for one in writer.targets if one not in self.values()]),
            "w": lambda: choose("kn"),
            "i": writer.counter,
            "count": lambda: choose(parts.COUNTS),
            "last": lambda: writer.filled(writer.last, 1),
            "short": lambda: writer.block(0),
        }
        return ways.get(key, lambda: writer.block(depth - 1))()


def step_of(random: Random, odd: bool) -> str:
    """The statements of a step."""
    writer = Writer(random, parts.REALS, (*parts.REAL_FORMS, *MADE), parts.SIMPLE, LAST)
    first = [*FIRST]
    if random.random() < 0.3:
        first.append(f"i = {random.choice(('5.0', '5', 'a', 'k'))}")
        writer.counters.append("i")
    if random.random() < 0.2:
        name = random.choice(parts.NAMES)
        first.append(f"{name} = 1.5")
        writer.reals += [name] * 3
        writer.targets.append(name)
    if random.random() < 0.05:
        first.append(random.choice(parts.SHADOWS))
    lines = [writer.statement(2) for _ in range(random.randint(2, 6))]
    if odd:
        lines.insert(random.randint(0, len(lines)), writer.filled(random.choice(parts.ODD), 2))
    return "\n".join([*first, *lines, writer.filled(LAST, 1)])


def method_of(random: Random) -> str:
    """A helper method with random statements."""
    own = [one for one in parts.REALS if not one.startswith(("y.", "r.", "s.", "dt"))]
    simple = [one for one in parts.SIMPLE if not one.startswith("s = ")]
    writer = Writer(random, own, parts.REAL_FORMS, simple, MADE_LAST)
    lines = [writer.statement(1) for _ in range(random.randint(1, 4))]
    return MADE_HEAD + indent("\n".join([*lines, writer.filled(MADE_LAST, 1)]), "    ") + "\n"


def parted(text: str, between: str) -> dict[str, str]:
    """The classes, functions or numbers in a text, by name."""
    pieces = [f"{piece.strip()}\n" for piece in text.split(between)]
    return {re.sub(r"^(class|def) ", "", piece).split("(")[0].split(" ")[0]: piece for piece in pieces}


def used(texts: Mapping[str, str], name: str, text: str) -> list[str]:
    """Those texts whose name stands in a text, or in another one that does; in their order."""
    names: set[str] = set()
    size = -1
    while size < len(names):
        size = len(names)
        known = "\n".join([text, *(texts[one] for one in names)])
        names |= {one for one in texts if re.search(name.format(one), known)}
    return [one for key, one in texts.items() if key in names]


def fuzzed_law(random: Random) -> str:
    """The text of a file with a random law."""
    odd = random.random() < ODDITY
    step, first = step_of(random, odd), random.choice(parts.FIRST_STATES)
    decorated = f"@{random.choice(parts.DECORATORS)}\ndef decorated(self, x=1.0):\n    return 0.5 * x\n"
    known = {**parted(parts.METHODS, "\n\n"), "made": method_of(random), "decorated": decorated}
    methods = used(known, r"self\.{}\b", step)
    body = "\n".join([first, *methods, step])
    law = LAW.format(
        turns=random.randint(1, 4),
        reverse=random.random() < 0.5,
        fields="".join(f"    {one}\n" for one in used(FIELDS, r"self\.{}\b", body)),
        first=first,
        methods="".join(f"\n{indent(one, '    ')}" for one in methods),
        step=indent(step, "        "),
    )
    records = used(parted(parts.RECORDS, "\n\n\n"), r"\b{}\b", law)
    levels = parts.LEVELS + (parts.ODD_LEVELS if odd else ())
    edges = parts.EDGES + (parts.ODD_EDGES if odd else ())
    head = parts.HEAD.format(level=random.choice(levels), edge=random.choice(edges))
    return "\n\n".join([head, *records, law])
