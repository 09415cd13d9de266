"""Commands that write, each short, in variants whose files differ."""

import json
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

PI = ("paper/sine-pi", "--set", "simulation.duration=50 ms", "--set", "simulation.period=1 ms")
BATCH = ("batch", *PI, "--runs", "600", "--vary", "plant.mass=4..8 kg")
TUNE = (
    "tune",
    *PI,
    "--unbounded",
    "--candidates",
    "16",
    "--vary",
    "controller.proportional_gain=0.3..30 V s/m",
)
STUDY = {
    **{"search.candidates": 64, "search.seeds": 1, "search.widen": 0, "set.simulation.duration": "0.1 s"},
    **{"conditions.train": 1, "conditions.validation": 1, "conditions.test": 2, "conditions.stress": [1.0]},
    **{"conditions.stressed": 1, "limits.conditions": 0},
}


class Command(NamedTuple):
    """A command that writes into a folder.

    Attributes:
        words: what it is called with, from the folder and the number of a variant.
        goes_on: whether the same command goes on where it was killed, so that there is one variant.
        last: the file that takes its place after all others, if several belong together.
        share: of all kills.
        prepare: is called in its process first.
        warm: is called once before all of them, in the process that they are forked from.
    """

    words: Callable[[Path, int], list[str]]
    goes_on: bool = False
    last: str = ""
    share: float = 1.0
    prepare: Callable[[], Any] = lambda: None
    warm: Callable[[], Any] = lambda: None


def run(out: Path, variant: int) -> list[str]:
    return ["run", *PI, "--set", f"plant.mass={5 + variant} kg", "--out", str(out)]


def batch(out: Path, variant: int) -> list[str]:
    files = (f"--out={out / name}" for name in ("runs.csv", "runs.nc", "runs.png"))
    return [*BATCH, "--seed", str(variant), *files]


def batch_in_parts(out: Path, _variant: int) -> list[str]:
    return [*BATCH, "--out", f"{out}/", "--workers", "1"]


def tune(out: Path, variant: int) -> list[str]:
    return [*TUNE, "--seed", str(variant), "--out", str(out / "gains.toml")]


def study(out: Path, _variant: int) -> list[str]:
    changes = [f"--set={path}={json.dumps(value)}" for path, value in STUDY.items()]
    return ["study", "small", "--out", str(out), "--workers", "1", *changes]


def export(out: Path, variant: int) -> list[str]:
    gain = f"controller.proportional_gain={5 + variant}"
    return ["export", "c", "paper/sine-pi", "--set", gain, "--out", str(out)]


def paper(out: Path, _variant: int) -> list[str]:
    return ["paper", "--out", str(out)]


def without_compiler() -> None:
    """Have no C compiler, which takes long and writes nothing into the folder."""
    os.environ["PATH"] = "/nonexistent"


def small_parts() -> None:
    """Make parts of few runs."""
    from hydroservo.scenario import stored_batch

    vars(stored_batch)["MOST"] = 128


@cache
def study_of_the_paper() -> Any:
    """The runs of the paper, which take a minute and write nothing: computed once."""
    from hydroservo.papers.tsmc_eha_2021.study import run_study

    return run_study()


def computed() -> None:
    """Take the runs of the paper as computed."""
    from hydroservo.papers.tsmc_eha_2021 import study

    found = study_of_the_paper()
    vars(study)["run_study"] = lambda _progress: found


COMMANDS = {
    "run": Command(run, last="metrics.json"),
    "batch": Command(batch),
    "batch in parts": Command(batch_in_parts, goes_on=True, prepare=small_parts),
    "tune": Command(tune),
    "study": Command(study, goes_on=True),
    "export": Command(export, prepare=without_compiler),
    "paper": Command(paper, share=0.1, last="metrics.json", prepare=computed, warm=study_of_the_paper),
}
