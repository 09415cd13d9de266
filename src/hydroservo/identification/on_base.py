"""The text of a scenario that builds on another."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hydroservo._version import __version__
from hydroservo.errors import one_line
from hydroservo.scenario.catalogue import builtin_texts


def on_base(
    scenario: str, tables: Mapping[str, Any], folder: Path | str, command: str, remarks: Sequence[str] = ()
) -> str:
    """TOML that lays what was found over a scenario.

    Args:
        scenario: what it builds on, a built-in name or a path.
        tables: what was found.
        folder: where its file will stand, from which a scenario in a file is found again.
        command: that found it.
        remarks: what a reader of it should know, in a line each.
    """
    import tomli_w

    base = scenario if scenario in builtin_texts() else os.path.relpath(scenario, folder)
    origin = one_line(f"# Found by hydroservo {__version__} {command}; SI units.")
    lines = [origin, *(one_line(f"# {one}") for one in remarks)]
    return "\n".join(lines) + f"\n{tomli_w.dumps({'base': base, **tables})}"
