"""Kills commands at random instants and looks at what they left.

Half of the instants are drawn evenly over the time that a command takes. The others lie where it matters: up
to some milliseconds after one of its calls that make, open for writing, rename or remove a file, drawn evenly
among all of them.
"""

import os
import random
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from tools.promises.commands import COMMANDS, Command
from tools.promises.forked import Ended, Started, start, warm_up
from tools.promises.left import Files, damage, files_in

EVENTS = ("os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.truncate")
AFTER = 3e-3  # s, at most, between a call and the kill
EVERY = 10  # kills of a command, after which it runs to its end
KILLED = -9

Draw = random.Random


class Trial(NamedTuple):
    """A command in its folder: what it should leave, and how long that takes."""

    command: Command
    out: Path
    wanted: tuple[Files, ...]  # by variant
    seconds: float
    events: int


def count_kills(count: int, seed: int, say: Callable[[str], None] = print) -> list[dict[str, Any]]:
    """Kill each command so many times that all together are killed ``count`` times; a row for each.

    Raises:
        RuntimeError: a command fails without being killed.
    """
    warm_up()
    shares = sum(one.share for one in COMMANDS.values())
    rows = []
    with tempfile.TemporaryDirectory(prefix="kills-") as folder:
        os.environ["HYDROSERVO_CACHE_DIR"] = str(Path(folder) / "cache")
        os.environ["TMPDIR"] = folder
        (Path(folder) / "cache").mkdir(mode=0o700)
        for name, one in COMMANDS.items():
            number = round(count * one.share / shares)
            rows.append(kills_of(name, one, number, Path(folder) / name, Draw(f"{seed} {name}"), say))
            say(f"{name}: {rows[-1]}")
    return rows


def kills_of(
    name: str, command: Command, number: int, folder: Path, draw: Draw, say: Callable[[str], None]
) -> dict[str, Any]:
    command.warm()
    trial = prepared(command, folder)
    tally = dict.fromkeys(("attempts", "broken", "ended first", "run to their end", "parts reported"), 0)
    while tally["attempts"] < number:
        to_the_end = tally["run to their end"] < tally["attempts"] // EVERY
        variant, before = draw.randrange(len(trial.wanted)), files_in(trial.out)
        result, told = (whole if to_the_end else one_kill)(trial, folder, variant, draw)
        faults = judged(trial, variant, before, files_in(trial.out), result, told)
        tally["attempts"] += result.status == KILLED
        tally["broken"] += bool(faults)
        tally["ended first"] += result.status != KILLED and not to_the_end
        tally["run to their end"] += to_the_end
        tally["parts reported"] += len(told)
        for fault in faults:
            say(f"{name}, after {tally['attempts']} kills: {fault}")
        if result.status == 0 and command.goes_on:
            shutil.rmtree(trial.out)
    return {"command": name, **tally}


def prepared(command: Command, folder: Path) -> Trial:
    """A command after it ran, twice, in each variant."""
    out, wanted = folder / "out", []
    for variant in range(1 if command.goes_on or command.share < 1.0 else 2):
        for _ in range(2):  # the first compiles
            shutil.rmtree(out, ignore_errors=True)
            read, write = os.pipe()
            begun = start(command.words(out, variant), folder, lambda w=write: watched(command, w, -1))
            os.close(write)
            result = begun.ended()
            events = len(lines_of(read))
            os.close(read)
            if result.status:
                raise RuntimeError(result.err)
        wanted.append(files_in(out))
    shutil.rmtree(out)
    return Trial(command, out, tuple(wanted), result.seconds, events)


def whole(trial: Trial, folder: Path, variant: int, _draw: Draw) -> tuple[Ended, list[str]]:
    """Let a command run to its end."""
    return start(trial.command.words(trial.out, variant), folder, trial.command.prepare).ended(), []


def one_kill(trial: Trial, folder: Path, variant: int, draw: Draw) -> tuple[Ended, list[str]]:
    """Begin a command and kill it; what it reported as done by then."""
    at_event = draw.random() < 0.5
    number = draw.randrange(trial.events) if at_event else -1
    read, write = os.pipe()
    begun = start(
        trial.command.words(trial.out, variant), folder, lambda: watched(trial.command, write, number)
    )
    os.close(write)
    if at_event:
        told = lines_of(read, until="now")
        time.sleep(draw.uniform(0.0, AFTER))
    else:
        told = []
        time.sleep(draw.uniform(0.0, trial.seconds))
    killed(begun)
    result = begun.ended()
    told += lines_of(read)
    os.close(read)
    return result, [line for line in told if line not in ("event", "now")]


def killed(begun: Started) -> None:
    try:
        begun.kill()
    except ProcessLookupError:
        return


def watched(command: Command, pipe: int, number: int) -> None:
    """Report to a pipe each call that changes a file, that of a number with another word, and parts done."""
    from hydroservo.work.units import UnitStore

    command.prepare()
    seen = 0

    def hear(event: str, args: tuple[Any, ...]) -> None:
        nonlocal seen
        if event in EVENTS or (event == "open" and isinstance(args[2], int) and args[2] & 3):
            os.write(pipe, b"now\n" if seen == number else b"event\n")
            seen += 1

    write = UnitStore.write

    def reported(self: UnitStore, key: str, table: Any) -> None:
        write(self, key, table)
        os.write(pipe, f"{self.part(key).relative_to(self.folder)}\n".encode())

    UnitStore.write = reported  # type: ignore[method-assign]
    sys.addaudithook(hear)


def lines_of(pipe: int, until: str = "") -> list[str]:
    """The lines that come through a pipe, up to one, or to its end."""
    content = b""
    while not (until and content.endswith(f"{until}\n".encode())):
        piece = os.read(pipe, 1 if until else 65536)
        if not piece:
            break
        content += piece
    return content.decode().splitlines()


def judged(
    trial: Trial, variant: int, before: Files, after: Files, result: Ended, told: list[str]
) -> list[str]:
    """What is wrong with what a command left; hidden files of one that was killed are not."""
    faults = damage(before, after, trial.wanted[variant], trial.command.last)
    faults += [f"{name} was reported done and is not there" for name in set(told) - after.keys()]
    if result.status == 0 and after != trial.wanted[variant]:
        faults.append("it ended well and left other files than it should")
    if result.status not in (0, KILLED) or "Traceback" in result.err:
        faults.append(f"it ended with {result.status}: {result.err[-300:]}")
    return faults
