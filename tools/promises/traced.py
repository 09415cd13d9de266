"""Commands whose calls of the system are listened to by strace, which lets one of them fail."""

import ctypes
import os
import re
import subprocess
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from tools.promises.forked import Ended, start

CALLS = {
    "write": "write,pwrite64,writev,pwritev",
    "fsync": "fsync,fdatasync",
    "rename": "rename,renameat,renameat2",
    "mmap": "mmap",
    "open": "open,openat,creat",
    "mkdir": "mkdir,mkdirat",
    "unlink": "unlink,unlinkat,rmdir",
}
KINDS = {call: kind for kind, calls in CALLS.items() for call in calls.split(",")}
CALL = re.compile(r"(\d+) +(\w+)\(")
INJECTED = "(INJECTED)"
BY_ANY = 0x59616D61, -1  # PR_SET_PTRACER, PR_SET_PTRACER_ANY: where only parents may trace


class Fault(NamedTuple):
    """The calls of a kind that fail: in each thread the one of a number, with an error of the system."""

    kind: str
    number: int
    error: str


class Traced(NamedTuple):
    """How a command ended, the calls of each kind by their thread, and those that failed."""

    ended: Ended
    calls: dict[tuple[str, str], list[str]]
    failed: list[str]


def traced(command: list[str], folder: Path, prepare: Callable[[], Any], fault: Fault | None) -> Traced:
    """Do a command, and let calls of it fail.

    Args:
        command: what follows ``hydroservo``.
        folder: for what it says.
        prepare: is called in its process first, before anything is counted.
        fault: what fails; None for nothing.

    Raises:
        RuntimeError: strace cannot trace.
    """
    begins, go = os.pipe()
    waiting, ready = os.pipe()

    def held() -> None:
        os.close(go)
        ctypes.CDLL(None).prctl(*BY_ANY, 0, 0, 0)
        prepare()
        os.write(ready, b"1")
        os.read(begins, 1)  # which ends when strace is there
        for one in (ready, waiting, begins):
            os.close(one)

    begun = start(command, folder, held)
    os.close(ready)
    os.read(waiting, 1)
    log = folder / "calls.txt"
    words = listener(begun.pid, log, fault)
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as listens:
        said = listens.stderr.readline() if listens.stderr else ""
        if "attached" not in said:
            begun.kill()
            raise RuntimeError(said)
        os.close(go)
        result = begun.ended()
    for one in (begins, waiting):
        os.close(one)
    calls = defaultdict(list)
    for line in log.read_text("utf-8", "replace").splitlines():
        if found := CALL.match(line):
            calls[found[1], KINDS[found[2]]].append(line)
    return Traced(result, calls, [line for made in calls.values() for line in made if INJECTED in line])


def listener(pid: int, log: Path, fault: Fault | None) -> list[str]:
    """The strace that listens to a process, writes a log, and lets calls fail."""
    words = ["strace", "-f", "-y", "-o", str(log), "-p", str(pid), "-e", "signal=none"]
    if fault is None:
        return [*words, "-e", f"trace={','.join(CALLS.values())}"]
    calls = CALLS[fault.kind]
    return [*words, "-e", f"trace={calls}", "-e", f"inject={calls}:error={fault.error}:when={fault.number}"]
