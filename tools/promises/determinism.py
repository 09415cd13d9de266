"""Counts commands whose bytes depend on where and how they are run.

Each command runs once as a reference, and then in surroundings that are drawn: threads, worker processes,
hash seed, locale, time zone, working directory and Python's version. Strictly rounded ones also run compiled
for lesser processors, with other lanes therefore, and with other kernels of linear algebra. All files, and
what is printed as JSON, must have the reference's bytes, save for keys that say how long something took.

Other interpreters need the same versions of numpy and scipy, with whose searches an identification ends.
"""

import hashlib
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from tools.promises.commands import STUDY

PROGRAM = "from hydroservo.cli import main; main()"
EXAMPLES = Path(__file__).parents[2] / "examples"
LOG = "bench_log.csv"
PI = ("rig/1khz-pi-sine", "--set", "simulation.duration=0.2 s")
TSMC = ("rig/noisy-1khz-tsmc-sine", "--set", "simulation.duration=0.2 s")
LQ = ("laws/lq-sine", "--set", "simulation.duration=50 ms", "--set", "simulation.period=1 ms")
VARIED = ("--runs", "70", "--vary", "plant.mass=4..8 kg", "--seed", "3")
LOCALES = ("tr_TR", "de_DE", "ar_SA", "zh_CN")
ZONES = ("UTC", "Asia/Kathmandu", "America/St_Johns", "Pacific/Kiritimati")
FEATURES = (
    "+sse2",
    "+sse2,+sse3,+ssse3,+sse4.1,+sse4.2,+popcnt",
    "+sse2,+sse4.2,+avx",
    "+sse2,+sse4.2,+avx,+avx2,+bmi,+bmi2",
)
KERNELS = ("Prescott", "Nehalem", "Haswell")
PYTHONS = "HYDROSERVO_PYTHONS"  # other interpreters that have hydroservo, between os.pathsep
MAY_DIFFER = ("seconds", "duration", "elapsed", "per_second")  # keys of JSON, by how they end
PATIENCE = 600.0  # s

Draw = random.Random


class Case(NamedTuple):
    """A command that writes into ``out`` of the folder it is called in.

    Attributes:
        words: it is called with.
        threads: whether it takes a number of threads.
        workers: whether it takes a number of worker processes.
        strict: whether it rounds strictly, so that no processor may make a difference.
    """

    words: Sequence[str]
    threads: bool = False
    workers: bool = False
    strict: bool = False


class Surroundings(NamedTuple):
    """Where and how a command is run."""

    python: str
    options: tuple[str, ...] = ()
    environment: Mapping[str, str] = {}
    folder: str = "a"


CASES = {
    "run": Case(["run", *TSMC, "--out", "out", "--json"]),
    "run, strict": Case(["run", *LQ, "--strict", "--out", "out", "--json"], strict=True),
    "batch": Case(
        ["batch", *PI, *VARIED, "--out", "out/a.csv", "--out", "out/a.nc", "--out", "out/a.png", "--json"],
        threads=True,
    ),
    "batch, strict": Case(
        ["batch", *TSMC, *VARIED, "--strict", "--out", "out/a.parquet", "--json"], threads=True, strict=True
    ),
    "batch in parts": Case(["batch", *PI, *VARIED, "--out", "out/", "--json"], workers=True),
    "tune": Case(["tune", *PI, "--candidates", "64", "--out", "out/gains.toml"], threads=True),
    "study": Case(
        [
            "study",
            "small",
            "--out",
            "out",
            *(f"--set={path}={json.dumps(value)}" for path, value in STUDY.items()),
        ],
        workers=True,
    ),
    "export c": Case(["export", "c", *TSMC, "--out", "out"]),
    "identify": Case(
        ["identify", "rig/1khz-pi-square", LOG, "--vary", "plant.mass=-40%..+70%", "--out", "out", "--json"]
    ),
}


def count_determinism(count: int, seed: int, say: Callable[[str], None] = print) -> list[dict[str, Any]]:
    """Run commands in so many surroundings; a row for each command.

    Raises:
        RuntimeError: a command fails where nothing is changed.
    """
    draw, tally = Draw(seed), Counter[tuple[str, str]]()
    pythons = [sys.executable, *filter(None, os.environ.get(PYTHONS, "").split(os.pathsep))]
    with tempfile.TemporaryDirectory(prefix="determinism-") as name:
        top = Path(name)
        languages = made_locales(top / "locales")
        os.environ["HYDROSERVO_CACHE_DIR"] = str(top / "cache")
        (top / "cache").mkdir(mode=0o700)
        wanted = {case: outcome(one, Surroundings(sys.executable), top) for case, one in CASES.items()}
        for i in range(count):
            case = list(CASES)[i % len(CASES)]
            where = drawn(CASES[case], pythons, languages, draw)
            said = difference(wanted[case], outcome(CASES[case], where, top))
            tally[case, "attempts"] += 1
            tally[case, "broken"] += bool(said)
            if said:
                say(f"{case}: {said} with {where}")
            if i % 20 == 0:
                say(f"{i + 1} of {count}")
    return [
        {"command": case, **{name: tally[case, name] for name in ("attempts", "broken")}} for case in CASES
    ]


def made_locales(folder: Path) -> list[str]:
    """Locales to run in: those of some languages that can be made here, and C's."""
    folder.mkdir()
    os.environ["LOCPATH"] = str(folder)
    maker, found = shutil.which("localedef"), ["C", "C.UTF-8"]
    for name in LOCALES if maker else ():
        command = [str(maker), "-i", name, "-f", "UTF-8", str(folder / f"{name}.UTF-8")]
        if subprocess.run(command, capture_output=True, check=False).returncode == 0:
            found.append(f"{name}.UTF-8")
    return found


def drawn(case: Case, pythons: Sequence[str], languages: Sequence[str], draw: Draw) -> Surroundings:
    """Surroundings for a command."""
    environment = {
        "PYTHONHASHSEED": str(draw.randrange(2**32)),
        "LC_ALL": draw.choice(languages),
        "TZ": draw.choice(ZONES),
    }
    if case.strict:
        environment |= {
            "HYDROSERVO_CPU_FEATURES": draw.choice(FEATURES),
            "OPENBLAS_CORETYPE": draw.choice(KERNELS),
        }
    options: list[str] = []
    for wanted, name in ((case.threads, "--threads"), (case.workers, "--workers")):
        options += [name, str(draw.randint(1, 3))] if wanted else []
    folder = draw.choice(("b", "\u00e7al\u0131\u015fma dizini/\u0131", "c/d/e", "x" * 100))
    return Surroundings(draw.choice(pythons), tuple(options), environment, folder)


def outcome(case: Case, where: Surroundings, top: Path) -> dict[str, str]:
    """The digest of each file that a command writes, and of what it prints.

    Raises:
        RuntimeError: it fails.
    """
    with tempfile.TemporaryDirectory(dir=top) as name:
        folder = Path(name) / where.folder
        folder.mkdir(parents=True)
        shutil.copy(EXAMPLES / LOG, folder)
        command = [where.python, "-c", PROGRAM, *case.words, *where.options]
        environment = {**os.environ, "PYTHONHASHSEED": "0", **where.environment}
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, timeout=PATIENCE, check=False
        )
        if done.returncode:
            raise RuntimeError(f"{case.words[0]} with {where}: {done.stderr.decode()[-500:]}")
        files = {
            path.relative_to(folder).as_posix(): path.read_bytes()
            for path in sorted(folder.rglob("*"))
            if path.is_file()
        }
    del files[LOG]
    if "--json" in case.words:
        files["what it prints"] = done.stdout
    return {path: hashlib.sha256(plain(path, content)).hexdigest() for path, content in files.items()}


def plain(path: str, content: bytes) -> bytes:
    """Content without what may differ."""
    if not (path.endswith(".json") or content.startswith(b"{")):
        return content
    try:
        return json.dumps(kept(json.loads(content))).encode()
    except ValueError:
        return content


def kept(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: kept(one) for key, one in value.items() if not key.endswith(MAY_DIFFER)}
    return [kept(one) for one in value] if isinstance(value, list) else value


def difference(wanted: Mapping[str, str], found: Mapping[str, str]) -> str:
    """Which files are not the same; "" for none."""
    return ", ".join(
        sorted(path for path in wanted.keys() | found.keys() if wanted.get(path) != found.get(path))
    )
