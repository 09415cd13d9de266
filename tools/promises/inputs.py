"""Counts inputs that are not what they should be: scenarios, overrides, logs and results of plug-ins.

An input may give a loop or be refused in one line. What is wrong for sure must be refused, and what gives a
loop must give the same one again from its canonical text. One of a number of inputs is watched, and kept to
draw from if it reaches lines that none before it did.
"""

import json
import multiprocessing
import os
import random
import signal
import tempfile
import traceback
import warnings
from collections import Counter, deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import hydroservo
from hydroservo.core.errors import HydroservoError, HydroservoWarning
from hydroservo.core.group import group
from tools.promises.given import KINDS, Given, again, stock

PACKAGE = Path(hydroservo.__file__).parent
CHUNK = 20_000  # inputs of a process, which draws from what ships and from what it found itself
WATCHED = 24  # one of so many inputs is watched
PATIENCE = 5.0  # s of a processor, after which an input hangs
WALL = 3600.0  # s, after which a process does

MEMORY = Path("/dev/shm")  # noqa: S108 - where files cost least

Draw = random.Random
Fault = tuple[str, str]  # its sort, and what it is
Tally = Counter[tuple[str, str]]  # of kind and column


class Hung(BaseException):
    """An input takes too long."""


class Verdict(NamedTuple):
    """What came of an input.

    Attributes:
        refused: whether it was.
        fault: what may not be; "" for nothing.
        place: where in the code that was.
    """

    refused: bool
    fault: str = ""
    place: str = ""


def count_inputs(count: int, seed: int, say: Callable[[str], None] = print) -> list[dict[str, Any]]:
    """Try so many inputs; a row for each kind. What is wrong is said, the first of each sort."""
    tally: Tally = Counter()
    seen: set[str] = set()
    for number, found, faults in side_by_side(count, seed):
        tally.update(found)
        for sort, said in faults:
            if sort not in seen:
                say(said)
            seen.add(sort)
        broken = sum(value for (_, name), value in tally.items() if name == "broken")
        say(f"{number:,} inputs, {broken:,} broken")
    columns = ("attempts", "broken", "refused", "kept")
    kinds = [*KINDS, *({"?"} if tally["?", "broken"] else ())]  # an input that its process did not outlive
    return [{"kind": kind, **{name: tally[kind, name] for name in columns}} for kind in kinds]


def side_by_side(count: int, seed: int) -> Iterator[tuple[int, Tally, list[Fault]]]:
    """What came of inputs in turn, chunk by chunk, and how many there were until then; a process a core."""
    chunks: deque[Chunk] = deque()
    firsts = range(0, count, CHUNK)
    ends = (min(first + CHUNK, count) for first in firsts)
    for first in firsts:
        chunks.append(Chunk(seed, first, min(CHUNK, count - first)))
        if len(chunks) == len(os.sched_getaffinity(0)):
            yield next(ends), *chunks.popleft().result()
    for one in chunks:
        yield next(ends), *one.result()


class Chunk:
    """Inputs that are tried in a process of their own."""

    def __init__(self, seed: int, first: int, number: int) -> None:
        self.folder = tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.exists() else None)
        self.pipe, there = multiprocessing.Pipe(duplex=False)
        arguments = (seed, first, number, Path(self.folder.name), there)
        self.process = multiprocessing.get_context("fork").Process(target=work, args=arguments)
        self.process.start()
        there.close()

    def result(self) -> tuple[Tally, list[Fault]]:
        """What came of them, and the faults found, each with its sort."""
        with self.folder as folder:
            try:
                found, faults = self.pipe.recv() if self.pipe.poll(WALL) else (None, [])
            except EOFError:
                found = None
            if found is None:
                self.process.kill()
                files = {path.name: path.read_bytes().decode("latin-1") for path in Path(folder).iterdir()}
                said = f"a process died or hung: {json.dumps(files)}"
                found, faults = Counter({("?", "broken"): 1}), [("?", said)]
            self.process.join()
        return found, faults


def work(seed: int, first: int, number: int, folder: Path, pipe: Any) -> None:
    """Try inputs and send what came of them."""
    tally: Tally = Counter()
    faults: list[Fault] = []
    for kind, one, verdict, kept in inputs_of(seed, first, number, folder):
        row = {"attempts": 1, "broken": bool(verdict.fault), "refused": verdict.refused, "kept": kept}
        tally.update({(kind, name): int(value) for name, value in row.items()})
        if verdict.fault:
            said = json.dumps([kind, verdict.fault, verdict.place, one.what])
            faults.append((f"{kind} {verdict.place}", said))
    pipe.send((tally, faults))


def inputs_of(seed: int, first: int, number: int, folder: Path) -> Iterator[tuple[str, Given, Verdict, bool]]:
    """Inputs by their kind, what came of each, and whether it is kept."""
    draw, from_ = Draw(f"{seed} {first}"), stock()
    lines = Lines()
    makes, shares = zip(*KINDS.values(), strict=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", HydroservoWarning)
        for i in range(number):
            kind, make = draw.choices([*zip(KINDS, makes, strict=True)], shares)[0]
            given = make(from_, draw)
            watched = i % WATCHED == 0 and bool(given.text)
            verdict = lines.watch(lambda g=given: judged(g, folder)) if watched else judged(given, folder)
            kept = watched and lines.more()
            if kept:
                from_.keep(given.text)
            yield kind, given, verdict, kept


class Lines:
    """Which lines of hydroservo were reached so far."""

    def __init__(self) -> None:
        from coverage import Coverage

        self.coverage = Coverage(data_file=None, include=[f"{PACKAGE}/*"], config_file=False)
        self.known = 0

    def watch(self, function: Callable[[], Verdict]) -> Verdict:
        """Call a function and see which lines it reaches."""
        self.coverage.start()
        try:
            return function()
        finally:
            self.coverage.stop()

    def more(self) -> bool:
        """Whether there are more than when this was asked last."""
        data = self.coverage.get_data()
        before, self.known = self.known, sum(len(data.lines(file) or ()) for file in data.measured_files())
        return self.known > before


def hang(*_: Any) -> None:
    raise Hung


def judged(one: Given, folder: Path) -> Verdict:
    """What comes of an input."""
    for name, content in one.files.items():
        (folder / name).write_bytes(content)
    signal.signal(signal.SIGPROF, hang)
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    try:
        loop = one.use(folder)
        fault = same_again(loop, folder) if loop is not None else ""
    except HydroservoError as error:
        said = str(error)
        plain = said.isprintable() and len(said) < 2000
        return Verdict(True, "" if plain else f"more than a line: {said[:200]!r}", "" if plain else "line")
    except Hung:
        return Verdict(False, f"took more than {PATIENCE:g} s", "hang")
    except BaseException as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        return Verdict(
            False, f"{type(error).__name__}: {error}"[:300], f"{Path(frame.filename).name}:{frame.lineno}"
        )
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    if one.wrong:
        return Verdict(False, f"accepted {one.wrong}", one.wrong)
    return Verdict(False, fault, fault[:40])


def same_again(loop: Any, folder: Path) -> str:
    """What is wrong with what a loop's canonical text gives; "" for nothing, or with recorded signals."""
    bare = loop._replace(metrics=group({}))
    if "TimeSeries" in repr(bare):
        return ""
    try:
        other = again(loop, folder)._replace(metrics=group({}))
    except HydroservoError as error:
        return f"its canonical text is refused: {error}"
    return "" if repr(other) == repr(bare) else "its canonical text is another loop"
