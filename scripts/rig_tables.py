#!/usr/bin/env python3
"""Writes the two tables of the rig in the README anew; about a minute.

The gains stand in the built-in scenarios, whose [tune] finds them again: hydroservo tune rig/1khz-pi-sine.
"""

import json
import math
import subprocess
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from hydroservo import replace, simulate, simulate_batch
from hydroservo.block import leaves
from hydroservo.scenario import load_scenario

README = Path(__file__).parents[1] / "README.md"
FAMILIES = ("1khz", "10khz", "noisy-1khz", "noisy-10khz", "encoder")
LAWS, DEMANDS = {"pi": "PI", "tsmc": "TSMC"}, ("sine", "square")
SETTLED = (1.0, 1.99)  # [s] between the start and the square's jump
LEAST = 1e-3  # [mV] of a line that is worth mentioning
POWERS = ("controller.power_gain_1", "controller.power_gain_2")  # of the law, not of its observer
INVERTED_PI = {
    "controller.type": "ValveInversion",
    "controller.time_constant": "10 ms",
    "controller.controller.type": "PI",
    "controller.controller.proportional_gain": "1 V s/m",  # until the search has found one
}
INVERTED_RANGES = {
    "controller.controller.proportional_gain": "0.03..30 V s/m",
    "controller.controller.integral_gain": "10..10000 V/m",
    "controller.reach": "0.5..3",  # from the shortest that there is
}

Row = tuple[str, ...]


def main() -> None:
    header = ("loop", *(f"{law}, {demand}" for demand in DEMANDS for law in LAWS.values()))
    write_table("rig", header, errors())
    write_table("rig limits", ("what the table does not show", *DEMANDS), limits())


def write_table(mark: str, header: Row, rows: Iterable[Row]) -> None:
    """A table into the README, between the comments that name it."""
    begin, end = f"<!-- {mark}: begin -->\n", f"<!-- {mark}: end -->"
    before, _, rest = README.read_text(encoding="utf-8").partition(begin)
    after = rest.partition(end)[2]
    lines = [header, ("---", *["---:"] * (len(header) - 1)), *rows]
    text = "".join(f"| {' | '.join(line)} |\n" for line in lines)
    README.write_text(before + begin + text + end + after, encoding="utf-8")


def errors() -> Iterator[Row]:
    """The rms errors of each loop, in mm/s."""
    for family in FAMILIES:
        cells = [f"{rms(f'{family}-{law}-{demand}'):.3g}" for demand in DEMANDS for law in LAWS]
        yield f"`rig/{family}-...`", *cells


def limits() -> Iterator[Row]:
    """What says how far the errors are those of the laws."""
    changes = inverted_pi()
    cells = [f"{rms(f'1khz-pi-{demand}', changes):.3g}" for demand in DEMANDS]
    yield "`rig/1khz-...`: PI behind TSMC's valve inversion, tuned with TSMC's weights", *cells
    for family in FAMILIES:
        numbers = dict(leaves(load_scenario(f"rig/{family}-tsmc-sine")))
        off = {path: 0.0 for path in numbers if path.endswith(POWERS)}
        cells = [f"{rms(f'{family}-tsmc-{demand}', off):.3g}" for demand in DEMANDS]
        yield f"`rig/{family}-...`: TSMC, its terminal powers switched off", *cells
    for law, name in LAWS.items():
        cells = [chatter(f"10khz-{law}-{demand}") for demand in DEMANDS]
        yield f"`rig/10khz-...`: {name}, the chatter of its command", *cells


def inverted_pi() -> dict[str, object]:
    """PI behind the inversion that TSMC has, with what a search finds under the weights that TSMC had."""
    command = ["hydroservo", "tune", "rig/1khz-pi-sine", "--weights", "1,8", "--candidates", "1024", "--json"]
    command += [word for path, value in INVERTED_PI.items() for word in ("--set", f"{path}={value}")]
    command += [word for path, text in INVERTED_RANGES.items() for word in ("--vary", f"{path}={text}")]
    done = subprocess.run(command, stdout=subprocess.PIPE, check=True, text=True)  # noqa: S603 - ours
    return INVERTED_PI | json.loads(done.stdout)["parameters"]


def rms(scenario: str, changes: Mapping[str, object] | None = None) -> float:
    """rms error [mm/s], mean over twenty seeds."""
    runs = simulate_batch(load_scenario(f"rig/{scenario}", changes), {"simulation.seed": np.arange(20)})
    return math.inf if runs["diverged"].any() else 1e3 * float(runs["rms_error"].mean())


def chatter(scenario: str) -> str:
    """The strongest line of a command above a tenth of the sampling rate, long after the start."""
    loop = load_scenario(f"rig/{scenario}")
    period = loop.simulation.period
    loop = replace(loop, {"simulation.duration": SETTLED[1], "simulation.record_period": period})
    run = simulate(loop, record=["controller.u"])
    u = run["controller.u"].values[run["time"].values >= SETTLED[0]]
    lines = 2.0 / u.size * np.abs(np.fft.rfft(u * np.hanning(u.size))) / np.hanning(u.size).mean()
    rates = np.fft.rfftfreq(u.size, period)
    strongest = int(np.argmax(np.where(rates > 0.1 / period, lines, 0.0)))
    size = 1e3 * float(lines[strongest])
    return "none" if size < LEAST else f"{size:.2g} mV at {1e-3 * rates[strongest]:.2g} kHz"


if __name__ == "__main__":
    main()
