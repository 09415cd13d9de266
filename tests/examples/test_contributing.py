"""The house as CONTRIBUTING.md describes it is the one that the import contract knows."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_layers_are_described() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    layers = settings["tool"]["importlinter"]["contracts"][0]["layers"]
    modules = {name.strip() for layer in layers for name in re.split(r"[|:]", layer)} - {"_version"}
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = text[text.index("| Layer | Modules |") : text.index("The engine knows no device")]
    assert modules == set(re.findall(r"`(\w+)`", table))
