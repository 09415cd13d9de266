"""Units of work whose tables take a moment, and a program that does them.

``python -m tests.support.work.units FOLDER COUNT WORKERS [SCHEDULER]``
"""

import os
import signal
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa

from hydroservo.core.errors import HydroservoError
from hydroservo.work.execution import do_units
from hydroservo.work.units import UnitStore, WorkUnit, unit_address

MANIFEST = "units.json"
SECONDS = 0.05  # that a unit takes


def numbers(number: int, seconds: float = SECONDS) -> pa.Table:
    """A table that its number alone decides."""
    time.sleep(seconds)
    draws = np.random.default_rng(number).standard_normal(300)
    return pa.table({"unit": np.full(300, number), "draw": draws, "name": [f"unit {number}"] * 300})


def refused(number: int) -> pa.Table:
    raise HydroservoError(f"there is no {number}")


def defective(number: int) -> pa.Table:
    raise ZeroDivisionError(f"of {number}")


def deadly(_number: int) -> pa.Table:
    os.kill(os.getpid(), signal.SIGKILL)
    raise AssertionError


def dies_once(marker: str, number: int) -> pa.Table:
    """Kills its process the first time."""
    try:
        Path(marker).touch(exist_ok=False)
    except FileExistsError:
        return numbers(number, 0.0)
    return deadly(number)


def threads_of_algebra(_number: int) -> pa.Table:
    return pa.table({"threads": [os.environ.get("OPENBLAS_NUM_THREADS"), os.environ.get("OMP_NUM_THREADS")]})


def unit(number: int, does=numbers, **options) -> WorkUnit:
    return WorkUnit(unit_address({"number": number}), partial(does, number, **options), f"unit {number}")


def units(count: int, **options) -> list[WorkUnit]:
    return [unit(number, **options) for number in range(count)]


def contents(folder: Path) -> dict[str, bytes]:
    """Each file below a folder."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def main(folder: str, count: str, workers: str, scheduler: str | None = None) -> None:
    store = UnitStore(folder, MANIFEST, {"count": int(count)})
    do_units(units(int(count)), store, workers=int(workers), scheduler=scheduler)


if __name__ == "__main__":
    main(*sys.argv[1:])
