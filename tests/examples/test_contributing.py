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
    table = text[text.index("| Floor | Packages |") : text.index("The engine knows no device")]
    assert modules == set(re.findall(r"`(\w+)`", table))


def test_test_folders_hold_tests_alone() -> None:
    folders = [path for path in (ROOT / "tests").iterdir() if path.is_dir() and path.name != "support"]
    modules = [path for folder in folders for path in folder.rglob("*.py")]
    assert [path for path in modules if path.name != "conftest.py" and path.name[:5] != "test_"] == []
    imported = re.compile(r"^\s*(?:from|import) (?:\.|tests\.(?!support)|test_)", re.MULTILINE)
    assert [path for path in modules if imported.search(path.read_text(encoding="utf-8"))] == []


def test_what_is_shared_knows_no_test_and_no_benchmark() -> None:
    shared = {
        "tools": r"tests|benchmarks",
        "tests/support": r"tests\.(?!support)|benchmarks",
        "docs": r"tests",
    }
    for folder, forbidden in shared.items():
        imported = re.compile(rf"^\s*(?:from|import) (?:{forbidden})\b", re.MULTILINE)
        files = [path for path in (ROOT / folder).rglob("*") if path.suffix in {".md", ".py"}]
        assert files
        assert [path for path in files if imported.search(path.read_text(encoding="utf-8"))] == []
