"""A machine for the public record of a hydraulic crane: fitted on one half, run freely on the other.

Read by the page on that record, which shows what is computed here. The record, its licence and the machine
are in examples/crane.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import hydroservo as hs
from hydroservo.control.loop import Loop
from hydroservo.identification.result import Identified

FOLDER = Path(__file__).resolve().parents[1] / "examples" / "crane"
SCENARIO, FILE = FOLDER / "crane.toml", FOLDER / "crane.csv"
HALF = 512  # samples
PRESSURE, POSITION = 1e6, 0.1  # Pa and m for 1 of the record, as the scenario assumes

Samples = NDArray[np.float64]


class Record(NamedTuple):
    """What was measured, or what a model shows of it, in the record's own units."""

    valve: Samples
    pressure: Samples
    position: Samples


def record() -> Record:
    """What was measured."""
    table = pd.read_csv(FILE)
    return Record(*(table[name].to_numpy() for name in Record._fields))


def fitted(folder: Path) -> Identified:
    """The machine as identify finds it from the first half.

    Args:
        folder: a copy of :data:`FOLDER`, into which the first half is written.
    """
    first = folder / "first_half.csv"
    rows = FILE.read_text(encoding="utf-8").splitlines()[: 1 + HALF]
    first.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return hs.identify(folder / SCENARIO.name, first, {})


def free_run(loop: Loop) -> Record:
    """The machine that the valve alone drives through all of the record, from rest where that begins.

    The record's pressure is 0 at rest.
    """
    run, measured = hs.simulate(loop), record()
    pressure, position = (run[f"plant.{name}"].to_numpy() for name in ("pressure_a", "position"))
    moved = (position - position[0]) / POSITION
    return Record(measured.valve, (pressure - pressure[0]) / PRESSURE, measured.position[0] + moved)


def linear() -> Samples:
    """The pressure as an ARX(2,2) with a constant foretells it, fitted on the first half by least squares.

    It runs freely, but begins each half with the two pressures that were measured there.
    """
    valve, measured, _ = record()
    known = [measured[1:-1], measured[:-2], valve[1:-1], valve[:-2], np.ones(valve.size - 2)]
    fit = slice(HALF - 2)
    weights = np.linalg.lstsq(np.stack(known, axis=1)[fit], measured[2:][fit], rcond=None)[0]
    found = measured.copy()
    for k in range(2, valve.size):
        if k not in (HALF, HALF + 1):
            found[k] = weights @ (found[k - 1], found[k - 2], valve[k - 1], valve[k - 2], 1.0)
    return found


def errors(simulated: Samples, measured: Samples) -> tuple[float, float]:
    """The rms errors in the first half and in the second."""
    squares = (simulated - measured) ** 2
    return float(np.sqrt(squares[:HALF].mean())), float(np.sqrt(squares[HALF:].mean()))


def error_rows(run: Record) -> Iterator[tuple[Any, ...]]:
    """Errors of a free run beside those of the linear model, and of none."""
    _, pressure, position = record()
    rows = (
        ("pressure", "the first half's mean", np.full(pressure.size, pressure[:HALF].mean()), pressure),
        ("", "ARX(2,2)", linear(), pressure),
        ("", "the machine", run.pressure, pressure),
        ("position", "the first half's mean", np.full(position.size, position[:HALF].mean()), position),
        ("", "the machine", run.position, position),
    )
    for signal, model, shown, measured in rows:
        yield signal, model, *(f"{one:.3f}" for one in errors(shown, measured))
