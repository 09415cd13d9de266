"""How long a user waits for the first result: the command line in a fresh process."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

__all__ = ["start_up"]

ARGUMENTS = ("run", "paper/sine-tsmc", "--json")


def start_up(rounds: int) -> dict[str, float]:
    """Median seconds of one command with an empty and with a filled cache.

    Python keeps what it has compiled of modules, as where hydroservo is installed.
    """
    cold, warm = [], []
    with tempfile.TemporaryDirectory() as folder:
        command(folder)
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as folder:
            cold.append(command(folder))
            warm.append(command(folder))
    return {"cold": median(cold), "warm": median(warm)}


def command(cache: str) -> float:
    """Seconds of ``hydroservo run paper/sine-tsmc --json`` with this folder as its cache."""
    program = Path(sys.executable).with_name("hydroservo")
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    began = perf_counter()
    subprocess.run(
        [program, *ARGUMENTS],
        env=kept | {"HYDROSERVO_CACHE_DIR": cache},
        stdout=subprocess.DEVNULL,
        check=True,
    )
    return perf_counter() - began
