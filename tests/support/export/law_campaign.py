"""Many random laws, each in Python, in C, and in machine code alone or in vector lanes.

``python -m tests.support.export.law_campaign COUNT [FIRST [st]]`` tries so many from a seed on, and counts;
with ``st`` in Structured Text too, which takes a second each.
"""

import math
import re
import signal
import struct
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from random import Random
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np

from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, values
from hydroservo.core.errors import LoopError
from hydroservo.engine import flat
from hydroservo.engine.compiling import argument_shape, compiled_function
from hydroservo.engine.lanes import LANES, aligned_rows, lane_index
from hydroservo.engine.llvm.entries import DOUBLES, INTEGERS, kernel_text
from hydroservo.engine.machine_code import object_code
from hydroservo.engine.native import CompileError, Native
from hydroservo.export.of_loop import exported_block, exported_unit
from hydroservo.export.parts import block_of
from hydroservo.export.unit import CModule, Part, Precision
from hydroservo.export.vectors import rows_at
from hydroservo.language.scope import TranslationError
from hydroservo.runs.run import runnable_loop
from tests.support.export.fuzzed_laws import fuzzed_law
from tests.support.export.small_laws import R, Y, loop_of
from tests.support.export.structured_text import evaluated
from tools.targets.compilers import FLAGS, ToolError, output, warnings
from tools.targets.sources import write_unit

ROWS = [
    (Y, R),
    (Y._replace(velocity=-1.75), R._replace(value=3.5)),
    (Y._replace(velocity=40.0), R._replace(value=-0.0)),
    (Y._replace(velocity=0.0), R._replace(value=-9.0)),
    (Y._replace(velocity=3.25), R._replace(value=1.5)),
    (Y._replace(velocity=-0.5), R._replace(value=0.0625)),
    (Y._replace(velocity=1e300), R._replace(value=-1e300)),
    (Y._replace(velocity=math.nan), R._replace(value=math.inf)),
]
STOPS = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    MemoryError,
    NameError,
    RecursionError,
    TypeError,
    ValueError,
)
PERIOD = 1e-3  # s
BEYOND = re.compile("out of the array's|may outgrow 0 to")
AT_ONCE = 50  # laws in one program
RANDOM_ST = "random numbers have no Structured Text"
LIMITS = "-Wno-type-limits"  # a random comparison may well be always false
SANITIZED = ("-O1", "-fsanitize=undefined,address", "-fno-sanitize-recover=all")
BUILDS = (SANITIZED, *[("-O1",)] * 3, ("-O2",))  # in turn
LAW_LASTS = 3.0  # s of this process, however busy the machine is
PROGRAM_LASTS = 20  # s


class Tried(NamedTuple):
    """A law that C and Python can be asked about."""

    name: str
    unit: CModule
    expected: list[str]


class TooLongError(BaseException):
    """A law did not end in Python; nothing that catches exceptions is to catch this."""


@contextmanager
def limited() -> Iterator[None]:
    def stop(*_: object) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, LAW_LASTS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def tried(name: str, text: str, folder: Path, inlined: bool = False, st: bool = False) -> Tried | str:
    """A law with what Python makes of it; or the word for why it is not asked about."""
    own = folder / name
    own.mkdir()
    loop = loop_of(own, text)
    try:
        with limited(), np.errstate(all="ignore"):
            block = block_of(runnable_loop(loop), Part.CONTROLLER)
            states = stepped(block)
            unit = exported_unit(loop, Part.CONTROLLER, prefix=name, title="a law", inlined=inlined)
            problem = machine_problem(name, loop.controller)
    except TooLongError:
        return "stopped"
    except TranslationError as error:
        return refused(str(error), own, contiguous(loop.controller))
    except LoopError:  # it stops in Python at the first sample
        return "stopped"
    except Exception:  # whatever the translation stumbles over
        return f"fails: {traceback.format_exc()}"
    if problem or not states:
        return f"fails: {problem}" if problem else "stopped"
    rows = rows_at(states, [signal.place for signal in unit.states])
    expected = [" ".join(map(bits, row)) for row in rows.tolist()]
    problem = text_problem(loop, name, expected, inlined) if st else ""
    return f"fails: {problem}" if problem else Tried(name, unit, expected)


def text_problem(loop: Loop, name: str, expected: list[str], inlined: bool) -> str:
    """What Structured Text gives otherwise than Python; empty for nothing."""
    form = {"title": "a law", "precision": Precision.DOUBLE, "inlined": inlined}
    try:
        unit, module = exported_block(loop, Part.CONTROLLER, prefix=name, **form)  # type: ignore[arg-type]
        places = [(argument.name, one.path) for argument in unit.arguments for one in argument.signals]
        inputs = [
            [getattr({"measurement": y, "demand": r}[of], path.partition(".")[2]) for of, path in places]
            for y, r in ROWS[: len(expected)]
        ]
        found = [" ".join(map(bits, row)) for row in evaluated(module, inputs)]
    except TranslationError as error:
        return "" if str(error) == RANDOM_ST else f"refused as Structured Text alone: {error}"
    except Exception:  # whatever it stumbles over
        return f"in Structured Text: {traceback.format_exc()}"
    pairs = zip(found, expected, strict=True)
    return next((f"in Structured Text {a} is not {b}" for a, b in pairs if a != b), "")


def refused(said: str, folder: Path, law: Block) -> str:
    """The word for a law that is refused, in one line and alike."""
    other = refusal(law)
    if BEYOND.search(said) and other == "it is not":  # how long an array is, a kernel is told when it runs
        return "refused"
    if not said.startswith(f"{folder}/law.py, line ") or "\n" in said:
        return "badly refused"
    return "refused" if said.endswith(other) else f"fails: {said}, but compiled {other}"


def stepped(block: Block) -> list[Block]:
    """The states of a law, as far as Python goes."""
    state, states = block.init(), []
    with suppress(*STOPS):
        for y, r in ROWS:
            state = block.step(state, y, r)
            states.append(state)
    return states


def machine_problem(name: str, law: Block) -> str:
    """What strict machine code gives otherwise than Python, alone or in lanes in turn; empty for nothing."""
    return (alone if crc32(name.encode()) % 2 else in_lanes)(contiguous(law))


def contiguous(law: Block) -> Block:
    """A law whose arrays stand in memory as the engine wants them."""
    arrays = {name: value for name, value in law._asdict().items() if isinstance(value, np.ndarray)}
    return law._replace(**{name: np.ascontiguousarray(value) for name, value in arrays.items()})


def alone(law: Block) -> str:
    """What strict machine code gives otherwise than Python; empty for nothing."""
    step = compiled_function(type(law).step)
    for before, (y, r), after in samples(law):
        found = step(law, before, y, r, PERIOD)
        if list(map(bits, values(found))) != list(map(bits, values(after))):
            return f"{found} is not {after}"
    return ""


def in_lanes(law: Block) -> str:
    """The same of strict machine code that steps many laws side by side."""
    start, (y, r), rows = law.init(), ROWS[0], samples(law)
    width = len(values(start))
    build, load, store = (
        flat.builder(law),
        flat.loader(start, lane_index(0)),
        flat.storer(start, lane_index(0)),
    )
    measured, demanded = flat.loader(y, lane_index(width)), flat.loader(r, lane_index(width + len(y)))

    def many(constants, tables, memory):  # type: ignore[no-untyped-def]
        law = build(constants, tables)
        for lane in range(LANES):
            s = law.step(load(memory, lane), measured(memory, lane), demanded(memory, lane), PERIOD)
            store(memory, lane, s)
        return 0

    many.__module__ = flat.__name__  # whose functions may use memory
    text = kernel_text("many", many, (DOUBLES, INTEGERS, DOUBLES))
    memory = aligned_rows(width + len(y) + len(r))
    for lane in range(LANES if rows else 0):
        before, (y, r), _ = rows[lane % len(rows)]
        memory[:, lane] = [*values(before), *y, *r]
    Native(object_code("many", text, strict=True))(flat.block_numbers(law), flat.block_arrays(law), memory)
    for lane in range(LANES if rows else 0):
        after = values(rows[lane % len(rows)][2])
        if list(map(bits, memory[:width, lane])) != list(map(bits, after)):
            return f"{memory[:width, lane]} is not {after} in lanes"
    return ""


def samples(law: Block) -> list[tuple[Block, Any, Block]]:
    """The states of a law before and after each sample, as far as Python goes."""
    state, found = law.init(), []
    with suppress(*STOPS):
        for y, r in ROWS:
            after = law.step(state, y, r, PERIOD)
            found.append((state, (y, r), after))
            state = after
    return found


def refusal(law: Block) -> str:
    """Why machine code refuses a law."""
    try:
        _, first, _ = compiled_function(type(law).init).made((argument_shape(law),))
        given = (law, law.init(), *ROWS[0], PERIOD)
        _, after, _ = compiled_function(type(law).step).made(tuple(map(argument_shape, given)))
    except CompileError as error:
        return str(error)
    return "it is not" if after == first else "it must return the record that init returns, with floats in it"


def bits(x: float) -> str:
    return "nan" if x != x else struct.pack(">d", x).hex()  # noqa: PLR0124


def driver(laws: list[Tried]) -> str:
    """A program that prints the states of some laws."""
    lines = ["#include <inttypes.h>", "#include <stdio.h>", "#include <string.h>"]
    lines += [f'#include "{one.name}.c"' for one in laws]
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
        parameters = "" if one.unit.inlined else f", &{p}_defaults"
        lines += ["    {", f"        {p}_state state;", f"        {p}_init(&state{parameters});"]
        lines += [f"        {p}_{name} {name}; (void){name};" for name in names]
        given = "".join(f", &{name}" for name in names)
        for y, r in ROWS[: len(one.expected)]:
            records = {"measurement": y, "demand": r}
            for argument in one.unit.arguments:
                for x in argument.signals:
                    number = getattr(records[argument.name], x.path.partition(".")[2])
                    lines.append(f"        {argument.name}.{x.place} = {in_c(number)};")
            lines.append(f"        {p}_step(&state{parameters}{given});")
            lines.append(f'        printf("{one.name}");')
            lines += [f"        show(state.{x.place});" for x in one.unit.states]
            lines.append('        printf("\\n");')
        lines.append("    }")
    return "\n".join(["#include <math.h>", *lines, "    return 0;", "}", ""])


def with_own_names(one: Tried) -> str:
    """A law's source with its name in those of its functions: many laws are compiled as one text."""
    text = one.unit.source
    own = "|".join({*re.findall(r"^static \w+ (\w+)\(", text, re.MULTILINE)})
    return re.sub(rf"\b({own})\(", rf"{one.name}_\1(", text) if own else text


def in_c(x: float) -> str:
    return float(x).hex() if math.isfinite(x) else "(double)NAN" if math.isnan(x) else "(double)INFINITY"


def wrong(laws: list[Tried], folder: Path, flags: tuple[str, ...]) -> list[str]:
    """What C does otherwise than Python, each with the law's name."""
    for one in laws:
        write_unit(one.unit._replace(source=with_own_names(one)), folder)
    file, program = folder / "driver.c", folder / "program"
    file.write_text(driver(laws))
    try:
        strict = (*FLAGS, *warnings(laws[0].unit), LIMITS)
        output(["gcc", *strict, *flags, "-I", folder, file, "-o", program, "-lm"])
        said = output(["timeout", str(PROGRAM_LASTS), program])
    except ToolError as error:
        if len(laws) == 1:
            return [f"{laws[0].name}: {error}"]
        return [one for part in laws for one in wrong([part], folder, flags)]
    expected = [f"{one.name} {line}" for one in laws for line in one.expected]
    pairs = zip(said.splitlines(), expected, strict=True)
    return sorted({f"{b.split()[0]}: {a} is not {b}" for a, b in pairs if a != b})


def campaign(
    first: int, count: int, folder: Path, flags: tuple[str, ...], st: bool = False
) -> tuple[Counter[str], list[str]]:
    """How many laws agreed, were refused, stopped in Python or were wrong; and those that were."""
    counts: Counter[str] = Counter()
    found: list[str] = []
    asked: list[Tried] = []
    for seed in range(first, first + count):
        text = fuzzed_law(Random(seed))
        one = tried(f"law{seed}", text, folder, inlined=seed % 4 == 0, st=st)
        if isinstance(one, str):
            word, _, _ = one.partition(":")
            counts[word] += 1
            found += [f"law{seed}: {one}"] if word in {"fails", "badly refused"} else []
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


if __name__ == "__main__":
    total, start = int(sys.argv[1]), int((*sys.argv, "0")[2])
    for at in range(start, start + total, 500):
        with tempfile.TemporaryDirectory() as place:
            size = min(500, start + total - at)
            tally, bad = campaign(at, size, Path(place), BUILDS[at // 500 % len(BUILDS)], "st" in sys.argv)
        print(at, dict(tally), flush=True)
        print(*bad, sep="\n", flush=True)
