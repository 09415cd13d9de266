"""What counting a promise came to, in the file that the documentation reads."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hydroservo.core.outputs import write_text

FOUND = Path(__file__).parents[2] / "docs" / "promises.json"

Row = Mapping[str, Any]


def keep(name: str, command: str, seed: int, rows: Sequence[Row], found: Path = FOUND, **more: Any) -> None:
    """Write a promise's part of the file, whole or not at all; other parts stay.

    Args:
        name: of the promise.
        command: that counts it.
        seed: that it was counted from.
        rows: what is shown in its table; each says how many attempts there were, and how many ``broken``.
        found: the file.
        more: what else the page shows.
    """
    parts = json.loads(found.read_text("utf-8")) if found.exists() else {}
    attempts, broken = (sum(row[key] for row in rows) for key in ("attempts", "broken"))
    part = {"command": command, "seed": seed, "attempts": attempts, "broken": broken, "rows": list(rows)}
    parts[name] = part | more
    write_text(found, json.dumps(parts, indent=1, sort_keys=True) + "\n")
