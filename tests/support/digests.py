"""Digests of what the built-in scenarios give; ``python -m tests.support.digests`` writes them anew.

A change that is to change no number leaves them as they are; one that does says in CHANGELOG.md what and why.
"""

import hashlib
import json
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from hydroservo import HydroservoWarning, simulate
from hydroservo.scenario import load_scenario
from tests.support.scenarios import LOOPS

FILE = Path(__file__).parents[1] / "regression" / "digests.json"


def digests_of(scenario: str) -> dict[str, str]:
    """A digest of each recorded number's bits over a strict run, and of each metric's."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HydroservoWarning)
        data = simulate(load_scenario(scenario), strict=True)
    return {str(name): digest(one.values) for name, one in sorted(data.variables.items())}


def digest(values: ArrayLike) -> str:
    """Of the bits of some numbers; all nan are one."""
    numbers = np.asarray(values, dtype=np.float64)
    plain = np.where(np.isnan(numbers), np.nan, numbers)
    return hashlib.sha256(plain.tobytes()).hexdigest()[:16]


def stored() -> dict[str, dict[str, str]]:
    """The digests of each built-in scenario, as they were."""
    found: dict[str, dict[str, str]] = json.loads(FILE.read_text("utf-8"))
    return found


if __name__ == "__main__":
    digests = {name: digests_of(name) for name in LOOPS}
    FILE.write_text(json.dumps(digests, indent=1) + "\n", "utf-8")
