"""What commands print and write, as they did; ``python -m tests.support.outputs [NAME...]`` records it anew.

With a folder it keeps all of it there as it came, so that two states of the project can be held against each
other to the last bit with ``diff -r``.
"""

import json
import os
import re
import shlex
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tests.support.commands.runner import hydroservo_

FILE = Path(__file__).parents[1] / "regression" / "outputs.json"
EXAMPLES = Path(__file__).parents[2] / "examples"
SHORT = "--set simulation.duration=0.2"  # s
VARY = "--vary plant.mechanism.mass=-50%..+100%"
HASH = r"[0-9a-f]{12,}"

COMMANDS = {  # by what makes them different; examples are files of that folder
    "run position": "run axis/position SHORT",
    "run velocity": "run paper/sine-tsmc SHORT",
    "compare laws": "compare rig/1khz-pi-sine rig/1khz-tsmc-sine SHORT",
    "compare demands": "compare paper/sine-pi paper/square-pi SHORT",
    "batch masses": "batch paper/sine-pi --runs 8 --vary plant.mass=4..8kg SHORT",
    "batch seeds": "batch rig/1khz-tsmc-sine --runs 8 --seeds SHORT",
    "bode velocity": "bode rig/1khz-pi-sine --linear SHORT",
    "bode measured": "bode rig/1khz-pi-sine --realisations 1 --periods 1 SHORT",
    "linearize velocity": "linearize rig/1khz-pi-sine --command 0.1V",
    "linearize force": "linearize axis/force",
    "audit velocity": "audit paper/sine-tsmc SHORT",
    "audit position": "audit examples/axis.toml SHORT",
    "limit sine": "limit rig/1khz-pi-sine SHORT",
    "limit square": "limit rig/1khz-pi-square SHORT",
    "limit periods": "limit rig/1khz-pi-square SHORT --period 1ms,2ms",
    "tune bounded": "tune rig/1khz-pi-sine --candidates 64 SHORT",
    "tune guess": "tune rig/1khz-pi-sine --candidates 0 SHORT",
    "tune two": "tune paper/sine-pi paper/square-pi --candidates 64 --unbounded"
    " --vary 'controller.proportional_gain=0.3..30 V s/m' SHORT",
    "identify fits": "identify examples/axis.toml log/trajectory.csv VARY",
    "identify misfit": "identify examples/axis.toml log/trajectory.csv VARY",
    "map characteristic": "map characteristic log/trajectory.csv"
    " --scenario examples/maps/characteristic.toml",
    "map friction": "map friction log/trajectory.csv --scenario examples/maps/machine.toml",
    "map decay": "map decay log/trajectory.csv --scenario examples/maps/machine.toml",
    "log bench": "log examples/bench_log.csv",
    "log simulated": "log log/trajectory.csv",
    "study two": "study two.toml --workers 1",
    "parts show": "parts show edges/4wrpeh-6-40",
}
SECOND = "--set simulation.duration=1"  # s
STRIBECK = (
    '{type="Stribeck", coulomb="400 N", breakaway="400 N", stribeck_velocity="5 mm/s", viscous="3000 N s/m"}'
)
TWO_LAWS = """
title = "Two laws"
base = "rig/noisy-1khz"
reference = "pi"
set.simulation.duration = "0.2 s"
laws.pi = { scenario = "laws/pi-sine", family = "PI" }
laws.lq = { scenario = "laws/lq-sine", family = "linear quadratic" }
conditions = { train = 2, validation = 2, test = 3, vary."plant.mass" = "-30%..+60%" }
search = { candidates = 256, widen = 0, levels = [1.0, 2.0] }

[known]
KalmanObserver.velocity_noise = "sensors.velocity_noise"
KalmanObserver.hydraulic_force_noise = "sensors.hydraulic_force_noise"
"""

LOGS = {  # scenarios whose runs are the logs that commands read
    "identify fits": f"axis.toml {SECOND}",
    "identify misfit": f"axis.toml {SECOND} --set 'plant.friction={STRIBECK}'",
    "map characteristic": "maps/characteristic.toml",
    "map friction": "maps/friction.toml",
    "map decay": "maps/decay.toml",
    "log simulated": f"axis.toml {SECOND}",
}


def outputs_of(name: str, keep: Path | None = None) -> dict[str, Any]:
    """What a command prints, plain and as JSON, and the names of what it writes.

    Args:
        name: of those in ``COMMANDS``.
        keep: a folder in which all of it is left.
    """
    words = words_of(name)
    with tempfile.TemporaryDirectory() as temporary:
        folder = keep / name.replace(" ", "-") if keep else Path(temporary) / "outputs"
        folder.mkdir(parents=True)
        before = Path.cwd()
        os.chdir(folder)
        try:
            prepare(name)
            plain, machine = hydroservo_(*words, "--out", "out"), hydroservo_(*words, *json_words(name))
        finally:
            os.chdir(before)
        (folder / "stdout").write_text(plain.stdout, "utf-8")
        (folder / "stderr").write_text(plain.stderr, "utf-8")
        (folder / "stdout.json").write_text(machine.stdout, "utf-8")
        files = sorted(path.relative_to(folder).as_posix() for path in (folder / "out").rglob("*.*"))
    assert plain.exit_code == machine.exit_code, name
    said = json.loads(machine.stdout) if machine.stdout.strip() else None
    return {
        "status": plain.exit_code,
        "stdout": without_numbers(plain.stdout),
        "json": sorted(set(keys_of(said))),
        "files": sorted({re.sub(HASH, "HASH", file) for file in files}),
    }


def words_of(name: str) -> list[str]:
    """The words of a command."""
    return shlex.split(COMMANDS[name].replace("SHORT", SHORT).replace("VARY", VARY))


def json_words(name: str) -> tuple[str, ...]:
    return ("--json", "--out", "again") if name.startswith("study") else ("--json",)


def prepare(name: str) -> None:
    """Copy the examples, and write the log that a command reads."""
    shutil.copytree(EXAMPLES, "examples")
    Path("two.toml").write_text(TWO_LAWS, "utf-8")
    if name in LOGS:
        run = hydroservo_(
            "run", *shlex.split(f"examples/{LOGS[name]}"), "--out", "log", "--format", "csv", "--json"
        )
        assert run.exit_code == 0, run.output


def without_numbers(text: str) -> list[str]:
    """The lines of a text, as wide as they may be, with # for each number."""
    lines = (re.sub(r"[\u2500-\u257f]+", "|", line) for line in text.splitlines())
    return [
        re.sub(r"[+\u2212-]?\d[\d.,]*(e[+-]?\d+)?", "#", " ".join(line.split()))
        for line in lines
        if line.strip()
    ]


def keys_of(value: Any, path: str = "") -> Iterator[str]:
    """The paths of all keys of what JSON holds; [] stands for each item of a list."""
    if isinstance(value, Mapping):
        for key, one in value.items():
            below = f"{path}.{key}" if path else key
            yield below
            yield from keys_of(one, below)
    elif isinstance(value, list):
        for one in value:
            yield from keys_of(one, f"{path}[]")


def stored() -> dict[str, dict[str, Any]]:
    """What commands printed and wrote when it was recorded."""
    found: dict[str, dict[str, Any]] = json.loads(FILE.read_text("utf-8"))
    return found


if __name__ == "__main__":
    names = [word for word in sys.argv[1:] if word in COMMANDS]
    folders = [Path(word) for word in sys.argv[1:] if word not in COMMANDS]
    recorded = {name: outputs_of(name, *folders) for name in names or COMMANDS}
    if not folders:
        FILE.write_text(json.dumps({**stored(), **recorded}, indent=1) + "\n", "utf-8")
