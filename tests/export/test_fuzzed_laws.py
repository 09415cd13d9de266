"""Many random laws: each is refused, or does in C what it does in Python, bit for bit.

``python tests/export/test_fuzzed_laws.py COUNT [FIRST]`` tries so many, from that seed on, and counts.
"""

import signal
import struct
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from random import Random
from typing import NamedTuple

import pytest
from benchmarks.targets.sources import write_unit
from benchmarks.targets.tools import FLAGS, ToolError, output, warnings
from fuzzed_laws import fuzzed_law
from small_laws import R, Y, law

from hydroservo.export.of_loop import exported_unit
from hydroservo.export.parts import block_of
from hydroservo.export.translate.scope import TranslationError
from hydroservo.export.unit import Part, Unit
from needs import needs

ROWS = [
    (Y, R),
    (Y._replace(velocity=-1.75), R._replace(value=3.5)),
    (Y._replace(velocity=40.0), R._replace(value=-0.0)),
    (Y._replace(velocity=0.0), R._replace(value=-9.0)),
]
CORPUS = (
    200859,
    202240,
    205335,
    206815,
    212038,
    213458,
)  # choices of short literals, once computed with 32 bits
AT_ONCE = 25  # laws in one program
LIMITS = "-Wno-type-limits"  # a random comparison may well be always false
SANITIZED = ("-O1", "-fsanitize=undefined,address", "-fno-sanitize-recover=all")
LAW_LASTS = 2  # s
PROGRAM_LASTS = 20  # s


class Tried(NamedTuple):
    """A law that C and Python can be asked about."""

    seed: int
    unit: Unit
    expected: list[str]


class TooLongError(Exception):
    """A law did not end in Python."""


@contextmanager
def limited() -> Iterator[None]:
    def stop(*_: object) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(LAW_LASTS)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def tried(seed: int, folder: Path) -> Tried | str:
    """A law with what Python makes of it; or the word for why it is not asked about."""
    own = folder / f"law{seed}"
    own.mkdir()
    random = Random(seed)  # noqa: S311 - to be played again
    loop = law(own, fuzzed_law(random), turns=random.randint(1, 4), reverse=random.random() < 0.5)
    block = block_of(loop, Part.CONTROLLER)
    try:
        with limited():
            state, expected = block.init(), []
            for y, r in ROWS:
                state = block.step(state, y, r)
                expected.append(" ".join(bits(float(x)) for x in state))
    except (ArithmeticError, NameError, TypeError, TooLongError):
        return "stopped"  # in Python
    try:
        unit = exported_unit(loop, Part.CONTROLLER, prefix=f"law{seed}", title="a law")
    except TranslationError as error:
        said = str(error)
        return "refused" if said.startswith(f"{own}/law.py, line ") and "\n" not in said else "badly refused"
    return Tried(seed, unit, expected)


def bits(x: float) -> str:
    return "nan" if x != x else struct.pack(">d", x).hex()  # noqa: PLR0124


def driver(laws: list[Tried]) -> str:
    """A program that prints the states of some laws."""
    lines = ["#include <inttypes.h>", "#include <stdio.h>", "#include <string.h>"]
    lines += [f'#include "law{one.seed}.h"' for one in laws]
    lines += [
        "static void show(double x) {",
        "    uint64_t bits;",
        "    memcpy(&bits, &x, sizeof bits);",
        '    if (x != x) { printf(" nan"); } else { printf(" %016" PRIx64, bits); }',
        "}",
        "int main(void) {",
    ]
    for one in laws:
        p = one.unit.prefix
        names = [argument.name for argument in one.unit.arguments]
        lines += ["    {", f"        {p}_state state;", f"        {p}_init(&state, &{p}_defaults);"]
        lines += [f"        {p}_{name} {name};" for name in names]
        given = "".join(f", &{name}" for name in names)
        for y, r in ROWS:
            records = {"measurement": y, "demand": r}
            for argument in one.unit.arguments:
                for x in argument.signals:
                    number = getattr(records[argument.name], x.path.partition(".")[2])
                    lines.append(f"        {argument.name}.{x.place} = {float(number).hex()};")
            lines.append(f"        {p}_step(&state, &{p}_defaults{given});")
            lines += [
                f'        printf("{one.seed}");',
                "        show(state.u);",
                "        show(state.beside);",
            ]
            lines.append('        printf("\\n");')
        lines.append("    }")
    return "\n".join([*lines, "    return 0;", "}", ""])


def wrong(laws: list[Tried], folder: Path, flags: tuple[str, ...]) -> list[str]:
    """What C does otherwise than Python, each with the law's number."""
    (folder / "driver.c").write_text(driver(laws))
    sources = [write_unit(one.unit, folder) for one in laws]
    program = folder / "program"
    try:
        strict, driver_file = (*FLAGS, *warnings(laws[0].unit), LIMITS), folder / "driver.c"
        output(["gcc", *strict, *flags, "-I", folder, *sources, driver_file, "-o", program, "-lm"])
        said = output(["timeout", str(PROGRAM_LASTS), program])
    except ToolError as error:
        if len(laws) == 1:
            return [f"law {laws[0].seed}: {error}"]
        return [one for part in laws for one in wrong([part], folder, flags)]
    expected = [f"{one.seed} {line}" for one in laws for line in one.expected]
    pairs = zip(said.splitlines(), expected, strict=True)
    return sorted({f"law {b.split()[0]}: {a} is not {b}" for a, b in pairs if a != b})


def campaign(first: int, count: int, folder: Path, flags: tuple[str, ...]) -> tuple[Counter[str], list[str]]:
    """How many laws agreed, were refused, stopped in Python or were wrong; and those that were."""
    counts: Counter[str] = Counter()
    found: list[str] = []
    asked: list[Tried] = []
    for seed in range(first, first + count):
        one = tried(seed, folder)
        if isinstance(one, str):
            counts[one] += 1
        else:
            asked.append(one)
        if asked and (len(asked) == AT_ONCE or seed == first + count - 1):
            failures = wrong(asked, folder, flags)
            numbers = {text.split(":")[0] for text in failures}
            counts["wrong"] += len(numbers)
            counts["agreed"] += len(asked) - len(numbers)
            found += failures
            asked = []
    return counts, found


@pytest.mark.parametrize("flags", [("-O2",), SANITIZED], ids=["optimized", "sanitized"])
def test_random_laws_agree_or_are_refused(flags: tuple[str, ...], tmp_path: Path) -> None:
    needs("gcc")
    counts, found = campaign(0 if flags == SANITIZED else 1000, 50, tmp_path, flags)
    assert found == []
    assert counts["agreed"] >= 10
    assert not counts["badly refused"]


@pytest.mark.parametrize("flags", [("-O2",), SANITIZED], ids=["optimized", "sanitized"])
def test_laws_that_were_wrong_once_agree(flags: tuple[str, ...], tmp_path: Path) -> None:
    needs("gcc")
    asked = [tried(seed, tmp_path) for seed in CORPUS]
    assert all(isinstance(one, Tried) for one in asked)
    assert wrong([one for one in asked if isinstance(one, Tried)], tmp_path, flags) == []


if __name__ == "__main__":
    total, start = int(sys.argv[1]), int((*sys.argv, "0")[2])
    for at in range(start, start + total, 500):
        with tempfile.TemporaryDirectory() as place:
            size = min(500, start + total - at)
            tally, bad = campaign(at, size, Path(place), ("-O2",) if at // 500 % 4 else SANITIZED)
        print(at, dict(tally), flush=True)
        print(*bad[:5], sep="\n", flush=True)
