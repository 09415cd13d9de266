"""What results say of runs, held against labels that an independent calculation gives.

A run is followed twice more by hand, the second time from a start that is off by a billionth. Where the two
do not agree, as about a law that makes of rounding a switch, the run has no label.
"""

import random
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from hydroservo import Loop, simulate
from hydroservo.core.block import Block, leaves
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.run import runnable_loop
from hydroservo.runs.step_sizes import machine_paths
from tools.promises.drawn_loops import AIMS, drawn
from tools.promises.reference import Followed, follow

VERDICTS = tuple(AIMS)
TOLERANCE = 1e-10  # of the reference's steps
NUDGE = 1e-9  # of its second start
LARGEST_ERROR = 1e-3  # of a state's largest value, as what says that steps are too coarse promises
SURE = 0.1  # of that: how far both references may be apart
VACUUM = -101325.0  # [Pa] gauge
REACH = {"plant.velocity": 100.0, "plant.pressure_a": 1e9, "plant.pressure_b": 1e9}  # as documented

Labels = dict[str, bool | None]
Draw = random.Random


class Judged(NamedTuple):
    """What a result says, and what is true, by verdict; None where there is no such verdict, or no label."""

    said: Labels
    true: Labels


def count_verdicts(count: int, seed: int, say: Callable[[str], None] = print) -> list[dict[str, Any]]:
    """Judge so many runs, as many about the border of each verdict; a row for each verdict."""
    draw, judged = Draw(seed), []
    for number in range(count):
        loop = drawn(VERDICTS[number % len(VERDICTS)], draw)
        judged.append(judge(loop))
        wrong = [name for name in VERDICTS if outcome(judged[-1], name) in ("false", "missed")]
        if wrong:
            say(f"run {number}: {', '.join(f'{outcome(judged[-1], name)}: {name}' for name in wrong)}")
    return [{"verdict": name, **tallied(judged, name)} for name in VERDICTS]


def judge(loop: Loop) -> Judged:
    """What the result of a loop says, and what is true of it."""
    paths = machine_paths(loop)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        data = simulate(loop, record=paths)
        whole = runnable_loop(loop)
    states = np.stack([data[path].values for path in paths[:-1]], axis=1)
    return Judged(said_of(data), labels_of(whole, states))


def said_of(data: Any) -> Labels:
    """What a result says of its run."""
    lines = " ".join(warnings_of(data))
    return {
        "diverged": bool(data["diverged"]),
        "left the stroke": bool(data["stroke_left"]),
        "below vacuum": "below absolute zero" in lines if "pressure_min" in data else None,
        "steps too coarse": "too coarse to be trusted" in lines,
    }


def labels_of(loop: Block, states: np.ndarray) -> Labels:
    """What is true of a loop that is ready, and of the states of a run of it, shape (samples, states)."""
    paths = [path for path, _ in leaves(loop.machine(loop.init()))]
    reach = np.array([REACH.get(path, np.inf) for path in paths])
    try:
        found = [follow(loop, TOLERANCE, reach, nudge) for nudge in (0.0, NUDGE)]
    except RuntimeError:
        return dict.fromkeys(VERDICTS)
    first, second = (labelled(loop, paths, one, states) for one in found)
    labels: Labels = {name: first[name] if first[name] == second[name] else None for name in VERDICTS}
    if apart(found[0].states, found[1].states) > SURE * LARGEST_ERROR:
        labels["steps too coarse"] = None
    return labels


def labelled(loop: Block, paths: list[str], found: Followed, states: np.ndarray) -> Labels:
    """What one calculation says of a loop, and of a run's states."""
    least, most = dict(zip(paths, found.least, strict=True)), dict(zip(paths, found.most, strict=True))
    low, high = least["plant.position"], most["plant.position"]
    pressures = [value for path, value in least.items() if path.startswith("plant.pressure")]
    return {
        "diverged": found.lost,
        "left the stroke": bool(low < 0.0 or high > loop.plant.stroke),
        "below vacuum": bool(min(pressures) < VACUUM) if pressures and not found.lost else None,
        "steps too coarse": None if found.lost else apart(states, found.states) > LARGEST_ERROR,
    }


def apart(states: np.ndarray, exact: np.ndarray) -> float:
    """The largest difference of a state from its exact values, over the largest of those."""
    if states.shape != exact.shape or not np.isfinite(states).all():
        return float("inf")
    differences, largest = np.abs(states - exact).max(axis=0), np.abs(exact).max(axis=0)
    return float((differences / np.where(largest > 0.0, largest, 1.0)).max())


def outcome(one: Judged, name: str) -> str:
    """Of one verdict on one run."""
    said, true = one.said[name], one.true[name]
    if said is None or true is None:
        return "no label"
    if said == true:
        return "rightly said" if said else "rightly not said"
    return "false" if said else "missed"


def tallied(judged: list[Judged], name: str) -> dict[str, int]:
    """How often a verdict was right and wrong; of the wrong ones, how often steps were said too coarse."""
    kinds = ("rightly said", "rightly not said", "false", "missed", "no label")
    found = [(outcome(one, name), bool(one.said["steps too coarse"])) for one in judged]
    tally = {kind: sum(what == kind for what, _ in found) for kind in kinds}
    wrong = [coarse for what, coarse in found if what in ("false", "missed")]
    warned = sum(wrong) if name != "steps too coarse" else 0
    attempts = len(judged) - tally["no label"]
    return {"attempts": attempts, **tally, "wrong and warned": warned, "broken": len(wrong) - warned}
