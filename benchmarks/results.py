"""The file of results: everything measured, and nothing that can be computed from it."""

import json
from pathlib import Path
from typing import Any

__all__ = ["RESULTS", "load", "save"]

RESULTS = Path(__file__).with_name("results.json")

Results = dict[str, Any]  # by instruction set; of processors before the last, by that and their names


def load(path: Path = RESULTS) -> Results:
    """What was measured last, by instruction set; nothing if there is no such file."""
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def save(path: Path, results: Results) -> None:
    """Writes the results."""
    path.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
