"""The numbers of a result as JSON, and the file of them that names all others of its folder."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hydroservo.core.errors import HydroservoError
from hydroservo.core.outputs import digests, write_text

METRICS = "metrics.json"
"""The file of a folder of results that names all others."""


def as_json(value: Any) -> str:
    """Text of a JSON object; null for a number that is not finite."""
    return json.dumps(plain(value), indent=2, allow_nan=False)


def write_metrics(folder: Path, content: Mapping[str, Any]) -> Path:
    """Write ``metrics.json`` beside the other files of a result, with the SHA-256 of each of them."""
    return write_text(folder / METRICS, as_json({**content, "files": digests(folder)}) + "\n")


def foreign_files(folder: Path | str) -> list[str]:
    """Which files that a folder's ``metrics.json`` names are missing, or are not those of its run.

    There are some where files were changed, where two commands wrote at the same time, or where one was
    killed in the instant in which its files took their places. Files that ``metrics.json`` does not name are
    left out.

    Raises:
        HydroservoError: there is no such file, or it cannot be read.
    """
    folder = Path(folder)
    try:
        named = dict(json.loads((folder / METRICS).read_text(encoding="utf-8"))["files"])
        found = digests(folder, [name for name in named if (folder / name).is_file()])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise HydroservoError(f"{folder / METRICS}: cannot be read as that of a result: {error}") from None
    return [name for name, digest in named.items() if found.get(name) != digest]


def plain(value: Any) -> Any:
    """The value as JSON can hold it: None for every number in it that is not finite."""
    if isinstance(value, Mapping):
        return {key: plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
