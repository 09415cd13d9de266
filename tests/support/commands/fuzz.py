"""Runs command lines by number, and says which of them did what no command line may do.

    python -m tests.support.commands.fuzz --first 0 --count 1000 --processes 2

A command may end with 0, or with 2 and one line that says why; it may not end otherwise, die, print a
traceback or leave a hidden file. One that takes too long is interrupted, and must then end with 130.
"""

import argparse
import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from tests.support.commands.cases import Case, case, lay

ROOT = Path(__file__).parents[3]
FUZZ = (sys.executable, "-m", "tests.support.commands.fuzz")

PATIENCE = 10.0  # s, after which a command is interrupted
AGAIN = 2.0  # s, after which it is again, for Python drops an interrupt that comes in a callback
CHUNK = 250  # cases of a process
USER_ERROR, INTERRUPTED = 2, 130


def outcome(number: int) -> dict[str, Any]:
    """What the command of a case did in this process."""
    one, here = case(number), Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        lay(Path(folder), one)
        os.chdir(folder)
        try:
            status, out, err, seconds = called(one)
            asked = {Path(word).name for word in one.words if "\0" not in word}
            left = [str(path) for path in Path().rglob(".*") if path.name not in asked]
        finally:
            os.chdir(here)
    found = {"number": number, "kind": one.kind, "status": status, "seconds": seconds}
    return found | {"faults": faults(one, status, out, err, left, seconds), "said": err[-400:]}


def called(one: Case) -> tuple[Any, str, str, float]:
    """The exit status, stdout, stderr and seconds of a command."""
    from hydroservo.cli.commands import app

    out, err = io.StringIO(), io.StringIO()
    start = time.monotonic()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in the background of a script
    signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
    signal.setitimer(signal.ITIMER_REAL, PATIENCE, AGAIN)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings():
            app(one.words, prog_name="hydroservo")
        status: Any = 0
    except SystemExit as end:
        status = end.code or 0
    except BaseException as error:
        status = f"{type(error).__name__}: {error}"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    return status, out.getvalue(), err.getvalue(), time.monotonic() - start


def faults(one: Case, status: Any, out: str, err: str, left: list[str], seconds: float) -> list[str]:
    """What a command did that none may do."""
    said = [line for line in err.splitlines() if not line.startswith("hydroservo: warning: ")]
    found = [f"left {name}" for name in left]
    if "Traceback" in err:
        found.append("a traceback")
    if status == INTERRUPTED and seconds >= PATIENCE:
        return found
    if status not in (0, USER_ERROR):
        found.append(f"ended with {status}")
    if not one.words or one.words == ["export"] or {"-h", "--help", "--version"} & set(one.words):
        return found  # help has been shown
    if status == USER_ERROR and not (len(said) == 1 and said[0].startswith("hydroservo: ")):
        found.append(f"said {len(said)} lines for an error")
    if status == USER_ERROR and out:
        found.append("printed before it failed")
    if (
        status == 0
        and "--json" in one.words
        and one.words[0] in ("run", "compare", "batch", "tune", "export")
    ):
        with contextlib.suppress(ValueError):
            json.loads(out)
            return found
        found.append("printed no JSON")
    return found


def outcomes(first: int, count: int) -> Iterator[dict[str, Any]]:
    """The outcomes of cases in processes of their own; of one that kills its process, that it did."""
    number = first
    while number < first + count:
        last = min(number + CHUNK, first + count)
        command = [*FUZZ, "--worker", f"--first={number}", f"--count={last - number}"]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
        for line in done.stdout.splitlines():
            number += 1
            yield json.loads(line)
        if number < last:
            yield {
                "number": number,
                "kind": case(number).kind,
                "status": done.returncode,
                "seconds": 0.0,
                "faults": [f"killed its process: {done.returncode}"],
                "said": done.stderr[-400:],
            }
            number += 1


def work(first: int, count: int) -> None:
    for number in range(first, first + count):
        print(json.dumps(outcome(number)), flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.worker:
        work(given.first, given.count)
        return 0
    size = -(-given.count // given.processes)
    parts = [(given.first + i * size, min(size, given.count - i * size)) for i in range(given.processes)]
    tally: Counter[tuple[str, str]] = Counter()
    bad: list[int] = []

    def watched(first: int, count: int) -> None:
        for one in outcomes(first, count):
            tally[one["kind"], str(one["status"])] += 1
            if one["faults"]:
                bad.append(one["number"])
                print(one["number"], case(one["number"]).words, one["faults"], one["said"], sep="\n    ")
            if tally.total() % 1000 == 0:
                print(f"{tally.total():,} cases, {len(bad):,} with a fault", flush=True)

    with ThreadPoolExecutor(given.processes) as pool:
        for done in [pool.submit(watched, *part) for part in parts]:
            done.result()
    for (kind, status), number in sorted(tally.items()):
        print(f"{kind:16} {status:>5} {number:7,}")
    print(f"{given.count:,} cases, {len(bad):,} with a fault")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
