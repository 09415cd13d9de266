"""Random laws as texts: counters, names used again, records behind guards, early returns, whole numbers."""

from random import Random
from textwrap import indent

__all__ = ["fuzzed_law"]

REALS = ("a", "b", "c", "y.velocity", "r.value", "self.gain", "SLOPE", "ROOT", "0.5", "-3.0", "dt", "s.u")
WHOLES = ("k", "n", "k", "n", "2", "-3", "self.turns", "TURNS", "1000000000", "46341", "(1 << 40)", "7")
TARGETS = ("a", "b", "c", "i", "_")
COUNTERS = ("i", "j", "_", "k", "i", "j")
COUNTS = ("3", "self.turns", "n - n + 2", "1", "0", "5", "i", "40")
REAL_FORMS = (
    "({0} + {1})", "({0} - {1})", "{0} * {1}", "-({0} - {1})", "({0} / (1.0 + {1} * {1}))",
    "ops.maximum({0}, {1})", "ops.where({0} > {1}, {0}, -{1})", "({0} if {0} > {1} else {1})",
    "(self.turned({0}).left if {0} >= 0.0 else {1})", "({1} if {0} < 0.0 else self.turned({0}).right)",
    "Pair({0}, {1}).right", "Pair({0}, {1}).left", "{0} + self.counted({2})", "({0} * {2})",
    "self.early({0}, {1})",
)  # fmt: skip
WHOLE_FORMS = ("({0} + {1})", "({0} - {1})", "({0} * {1})", "({0} // 3)", "-{0}", "({0} if a > b else {1})")
CONDITIONS = (
    "{0} > {1}", "not {0} <= {1}", "{0} < {1} or {1} > 1.0", "{0} < {1} < 2.0", "{2} > {3}",
    "({0} >= 0.0 and self.turned({0}).right > {1})", "({0} < 0.0 or self.turned({0}).left > {1})",
    "{2} == {3} and {0} > {1}", "self.reverse or {0} > {1}",
    "not ({0} < 0.0 or not self.turned({0}).left > {1})",
)  # fmt: skip


class Writer:
    """The text of one random law."""

    def __init__(self, random: Random) -> None:
        self.random = random

    def real(self, depth: int = 2) -> str:
        if depth == 0 or self.random.random() < 0.3:
            pool = (*REALS, "i", "_") if self.random.random() < 0.15 else REALS
            return self.random.choice(pool)
        form = self.random.choice(REAL_FORMS)
        return form.format(self.real(depth - 1), self.real(depth - 1), self.whole(1))

    def whole(self, depth: int = 2) -> str:
        if depth == 0 or self.random.random() < 0.4:
            return self.random.choice((*WHOLES, "i", "j") if self.random.random() < 0.4 else WHOLES)
        return self.random.choice(WHOLE_FORMS).format(self.whole(depth - 1), self.whole(depth - 1))

    def condition(self) -> str:
        form = self.random.choice(CONDITIONS)
        return form.format(self.real(1), self.real(1), self.whole(1), self.whole(1))

    def block(self, depth: int) -> str:
        lines = [self.statement(depth) for _ in range(self.random.randint(1, 3))]
        return indent("\n".join(lines), "    ")

    def statement(self, depth: int) -> str:
        roll = self.random.random()
        if depth > 0 and roll < 0.4:
            return self.around(depth - 1)
        return self.simple()

    def around(self, depth: int) -> str:
        kind = self.random.randrange(6)
        if kind == 0:
            return f"if {self.condition()}:\n{self.block(depth)}"
        if kind == 1:
            return f"if {self.condition()}:\n{self.block(depth)}\nelse:\n{self.block(depth)}"
        if kind == 2:
            last = f"return LawState({self.real()}, 1.0 * {self.whole(1)})"
            return f"if {self.condition()}:\n{self.block(0)}\n    {last}"
        if kind == 3:
            return (
                f"w = {self.real(1)}\nw = w * w\nwhile 1.0 < w < 1e9:\n{self.block(depth)}\n    w = 0.25 * w"
            )
        counter, count = self.random.choice(COUNTERS), self.random.choice(COUNTS)
        return f"for {counter} in range({count}):\n{self.block(depth)}"

    def simple(self) -> str:
        target = self.random.choice(TARGETS) if self.random.random() < 0.3 else self.random.choice("abc")
        kind = self.random.randrange(8)
        found = {
            0: lambda: f"{target} += {self.real()}",
            1: lambda: f"{self.random.choice('kn')} = {self.whole()}",
            2: lambda: f"{self.random.choice('kn')} += {self.whole(1)}",
            3: lambda: f"a, {target if target != 'a' else 'b'} = {self.real(1)}, {self.real(1)}",
            4: lambda: f"b, _ = self.pair({self.real(1)}, {self.real(1)})",
            5: lambda: f"p = Pair({self.real(1)}, {self.real(1)})\n{target} = p.left - p.right",
        }
        return found.get(kind, lambda: f"{target} = {self.real()}")()


def fuzzed_law(random: Random) -> str:
    """The statements of a step."""
    writer = Writer(random)
    lines = [writer.statement(3) for _ in range(random.randint(2, 7))]
    first = ["a, b, c = y.velocity, r.value, 1.0", "k, n = 1, 2"]
    if random.random() < 0.3:
        first.append(f"i = {random.choice(('5.0', '5', 'a', 'k'))}")
    if random.random() < 0.3:
        first.append("_ = 1.5")
    return "\n".join([*first, *lines, "return LawState(a * b - c, 1.0 * (k - n))"])
