"""The text of a scenario that builds on another."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hydroservo._version import __version__
from hydroservo.errors import one_line
from hydroservo.scenario.catalogue import builtin_texts

__all__ = ["on_base"]


def on_base(scenario: str, tables: Mapping[str, Any], folder: Path | str, command: str) -> str:
    """TOML that lays what was found over a scenario.

    Args:
        scenario: what it builds on, a built-in name or a path.
        tables: what was found.
        folder: where its file will stand, from which a scenario in a file is found again.
        command: that found it.
    """
    import tomli_w

    base = scenario if scenario in builtin_texts() else os.path.relpath(scenario, folder)
    origin = one_line(f"# Found by hydroservo {__version__} {command}; SI units.")
    return f"{origin}\n{tomli_w.dumps({'base': base, **tables})}"
