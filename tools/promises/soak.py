"""Mixed work for a given time, and whether memory or open files grow with it.

One process runs commands that write files, one after the other; another serves a page on loopback and has
workers that compute for it. Work comes in rounds, each the same pieces in another order with other numbers,
and after each round the memory that the system counts for each is read, and how many files are open.
"""

import io
import random
import shutil
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import psutil
from scipy.stats import theilslopes

from tools.promises.commands import COMMANDS
from tools.promises.forked import warm_up
from tools.promises.served import Page, served

WARM = 1 / 3  # of the rounds, in which caches fill
NOISE = 0.01  # of the memory: a growth over all the time that is more counts as one
FEWEST = 6  # rounds, whatever time they take
SHOWN = 60  # points of a curve, at most
MIB = 2**20
VARIANTS = 100
PAGE = "rig/1khz-pi-sine"
SAID = io.StringIO()  # one for all: click keeps each stream that it has written to
SHORT = {"simulation.duration": "0.1 s"}

Draw = random.Random
Work = Callable[[Path, Draw], None]


class Sample(NamedTuple):
    """What a process and those below it have after a round."""

    seconds: float
    memory: float  # MiB that are resident
    files: int


def count_soak(count: int, seed: int, say: Callable[[str], None] = print) -> list[dict[str, Any]]:
    """Work for ``count`` seconds or some rounds; a row for commands, one for a page with its workers."""
    warm_up()
    draw, begun = Draw(f"{seed}"), time.monotonic()
    done, failed = [0, 0], [0, 0]
    samples: tuple[list[Sample], list[Sample]] = ([], [])
    with tempfile.TemporaryDirectory(prefix="soak-") as folder, served(PAGE) as page:
        pieces = [*((0, work) for work in commands()), *((1, work) for work in requests(page))]
        while (now := time.monotonic() - begun) < count or len(samples[0]) < FEWEST:
            for which, work in draw.sample(pieces, len(pieces)):
                done[which] += 1
                try:
                    work(Path(folder), draw)
                except Exception as error:
                    failed[which] += 1
                    say(f"after {now:.0f} s: {type(error).__name__}: {error}")
            for one, pid in zip(samples, (psutil.Process().pid, page.pid), strict=True):
                one.append(sampled(pid, begun, {page.pid}))
            say(f"{len(samples[0])}: {samples[0][-1]}, {samples[1][-1]}")
    names = ("commands in one process", "a page and its workers")
    return [row_of(*one) for one in zip(names, samples, done, failed, strict=True)]


def commands() -> list[Work]:
    """Commands in this process, each over the files of the one before; those that go on begin anew."""

    def work(name: str) -> Work:
        def one(folder: Path, draw: Draw) -> None:
            out = folder / name
            called(COMMANDS[name].words(out, draw.randrange(VARIANTS)))
            if COMMANDS[name].goes_on:
                shutil.rmtree(out)

        return one

    def in_format(folder: Path, draw: Draw) -> None:
        form = draw.choice(("csv", "parquet", "netcdf", "mat"))
        called([*COMMANDS["run"].words(folder / "formats", draw.randrange(VARIANTS)), "--format", form])

    def bode(folder: Path, draw: Draw) -> None:
        mass = f"plant.mass={draw.uniform(5.0, 9.0)} kg"
        called(["bode", PAGE, "--set", mass, "--out", str(folder / "bode.png")])

    return [*(work(name) for name in COMMANDS if name != "paper"), in_format, bode]


def called(words: Sequence[str]) -> None:
    """Do a command in this process.

    Raises:
        RuntimeError: it fails.
    """
    from hydroservo.cli.commands import app

    SAID.seek(0)
    SAID.truncate()
    with redirect_stdout(SAID), redirect_stderr(SAID):
        try:
            app(list(words), prog_name="hydroservo")
        except SystemExit as end:
            if end.code:
                raise RuntimeError(f"{' '.join(words)}: {SAID.getvalue()[-300:]}") from None


def requests(page: Page) -> list[Work]:
    """What a page asks for: of its workers, and with other numbers each time."""

    def work(job: str, **request: object) -> Work:
        def one(_folder: Path, draw: Draw) -> None:
            page.asked(job, changes=SHORT | {"plant.mass": draw.uniform(5.0, 9.0)}, **request)

        return one

    kinds = ("csv", "parquet", "mat", "png", "svg", "c")
    jobs = [work("run", form=True), work("run"), work("form"), work("toml"), work("frequency")]
    return [*jobs, *(work("export", kind=kind) for kind in kinds)]


def sampled(pid: int, begun: float, other: set[int]) -> Sample:
    """A process with those below it, but not those in ``other`` and below."""
    memory, files = 0.0, 0
    waiting = [psutil.Process(pid)]
    while waiting:
        process = waiting.pop()
        memory += process.memory_info().rss / MIB
        files += process.num_fds()
        waiting += [child for child in process.children() if child.pid not in other]
    return Sample(time.monotonic() - begun, memory, files)


def growth(samples: Sequence[Sample]) -> tuple[float, float]:
    """How much memory grew over all samples [MiB], by the median of the slopes between any two; at least.

    The second is the lower end of that slope's 95% interval.
    """
    seconds, memory, _ = zip(*samples, strict=True)
    slope, _, low, _ = theilslopes(memory, seconds)
    span = seconds[-1] - seconds[0]
    return slope * span, low * span


def row_of(name: str, samples: Sequence[Sample], done: int, failed: int) -> dict[str, Any]:
    """What is shown of a process."""
    warm = samples[int(WARM * len(samples)) :]
    by, at_least = growth(warm)
    usual = median(one.memory for one in warm)
    grows, leaks = at_least > NOISE * usual, warm[-1].files > max(one.files for one in warm[: len(warm) // 2])
    every = -(-len(samples) // SHOWN)
    return {
        "process": name,
        "attempts": done,
        "broken": failed + bool(grows) + leaks,
        "rounds": len(samples),
        "memory [MiB]": round(usual),
        "growth [MiB]": round(by, 1),
        "at least [MiB]": round(at_least, 1),
        "open files": f"{warm[0].files} to {warm[-1].files}",
        "failed": failed,
        "curve": [[round(one.seconds), round(one.memory, 1)] for one in samples[::every]],
    }
