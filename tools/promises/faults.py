"""Lets one call of the system after the other fail under commands, and looks at what they say and leave.

Each attempt is a command in which the nth call of a kind fails with an error that such a call can have. It
may end well, with all of its files, where that call does not matter; or else with exit status 2 and one line
on stderr.
"""

import os
import random
import shutil
import tempfile
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from tools.promises.commands import COMMANDS, Command
from tools.promises.forked import start, warm_up
from tools.promises.left import files_in
from tools.promises.traced import CALLS, Fault, traced
from tools.promises.trials import Trial, broken, set_up

ERRORS = {
    "write": ("ENOSPC", "EDQUOT", "EIO"),
    "fsync": ("ENOSPC", "EDQUOT", "EIO", "EROFS"),
    "rename": ("ENOSPC", "EDQUOT", "EIO", "EROFS", "EACCES"),
    "mmap": ("ENOMEM", "EACCES"),
    "open": ("ENOSPC", "EDQUOT", "EIO", "EROFS", "EACCES", "EMFILE"),
    "mkdir": ("ENOSPC", "EDQUOT", "EIO", "EROFS", "EACCES"),
    "unlink": ("EIO", "EROFS", "EACCES"),
}
SHARES = {"study": 0.1, "paper": 0.1}  # which take long
EVERY = 10  # attempts, after which a command is left alone
COUNTED = ("attempts", "broken", "one line", "did not matter")

Say = Callable[[str], None]
Draw = random.Random


def bode(out: Path, variant: int) -> list[str]:
    mass = f"plant.mass={5 + variant} kg"
    return ["bode", "rig/1khz-pi-sine", "--set", mass, "--out", str(out / "bode.png")]


def without_kernels() -> None:
    """Have no kernels, so that they are compiled and kept."""
    place = Path(os.environ["HYDROSERVO_CACHE_DIR"])
    shutil.rmtree(place, ignore_errors=True)


MORE = {"bode": Command(bode), "run, compiled": COMMANDS["run"]._replace(prepare=without_kernels, share=0.5)}


def count_faults(count: int, seed: int, say: Say = print) -> list[dict[str, Any]]:
    """Let ``count`` calls fail, divided among commands; a row for each kind of call.

    Raises:
        RuntimeError: a command fails where nothing else does, or strace cannot trace.
    """
    warm_up()
    commands = {name: one._replace(share=SHARES.get(name, one.share)) for name, one in COMMANDS.items()}
    commands |= MORE
    shares = sum(one.share for one in commands.values())
    tallies = {kind: Counter[str]() for kind in CALLS}
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        for name, one in commands.items():
            trial = set_up(one, Path(folder) / name, Draw(f"{seed} {name}"))
            for fault, found, problems in faults_of(trial, round(count * one.share / shares)):
                tallies[fault.kind].update(found)
                for problem in problems:
                    say(f"{name}, {fault}: {problem}")
    return [{"call": kind, **{key: tally[key] for key in COUNTED}} for kind, tally in tallies.items()]


def faults_of(trial: Trial, number: int) -> Iterator[tuple[Fault, Counter[str], list[str]]]:
    """Let so many calls of a command fail: each with what it adds to a tally, and how the promise broke.

    After some it is left alone, and must end well.
    """
    folders, folder = trial.folders, trial.folders.out.parent
    numbers: dict[str, set[int]] = defaultdict(set)
    if trial.command.goes_on:  # over a complete folder it makes next to none of its calls
        shutil.rmtree(folders.out)
    for (_, kind), made in traced(trial.words(0), folder, trial.prepare, None).calls.items():
        numbers[kind] |= {i + 1 for i, line in enumerate(made) if of_a_file(line)}
    for i, fault in enumerate(drawn(numbers, number, trial.draw), 1):
        if trial.command.goes_on and i % 2:  # so that late calls come; the others go on from what is there
            shutil.rmtree(folders.out, ignore_errors=True)
        variant, before = trial.draw.randrange(len(trial.wanted)), files_in(folders.out)
        ended, _, failed = traced(trial.words(variant), folder, trial.prepare, fault)
        if not all(map(of_a_file, failed)):  # another number than before: Python itself may crash
            shutil.rmtree(folders.out, ignore_errors=True)
            continue
        problems = broken(trial, variant, before, ended, failed)
        if i % EVERY == 0:
            before = files_in(folders.out)
            after = start(trial.words(variant), folder, trial.prepare).ended()
            problems += [f"left alone then: {one}" for one in broken(trial, variant, before, after, [])]
        if ended.status == 0 and trial.command.goes_on:
            shutil.rmtree(folders.out)
        outcome = "one line" if ended.status else "did not matter"
        hit = int(bool(failed))
        yield fault, Counter({"attempts": hit, "broken": int(bool(problems)), outcome: hit}), problems


def of_a_file(call: str) -> bool:
    """Whether a call that strace tells of is not one for memory alone."""
    return "MAP_ANONYMOUS" not in call


def drawn(numbers: Mapping[str, set[int]], number: int, draw: Draw) -> list[Fault]:
    """So many faults, of each kind as many; all of a kind before one comes again.

    Args:
        numbers: those of the calls that may fail, by their kind.
        number: of faults.
        draw: from which they are drawn.
    """
    found: list[Fault] = []
    kinds = [kind for kind in CALLS if numbers.get(kind)]
    for i, kind in enumerate(kinds):
        share = number * (i + 1) // len(kinds) - number * i // len(kinds)
        faults = [Fault(kind, n, error) for n in sorted(numbers[kind]) for error in ERRORS[kind]]
        while share > 0:
            found += draw.sample(faults, min(share, len(faults)))
            share -= len(faults)
    return draw.sample(found, len(found))
