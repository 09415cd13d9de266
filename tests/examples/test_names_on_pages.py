"""What cells of the pages import, and the functions that the walks name, is there; cells run but nightly."""

import re
from pathlib import Path
from pkgutil import resolve_name

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md") if "_build" not in path.parts)
IMPORT = re.compile(r"^from (hydroservo[\w.]*) import (\([^)]*\)|.+)$", re.MULTILINE)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(DOCS)))
def test_cells_import_what_is_there(page: Path) -> None:
    for module, names in IMPORT.findall(page.read_text("utf-8")):
        for name in re.findall(r"(\w+)(?: as \w+)?", names):
            resolve_name(f"{module}.{name}")


def test_walks_go_through_functions_that_are_there() -> None:
    steps = re.findall(r'^    \("([\w.]+)", ', (DOCS / "walks.md").read_text("utf-8"), re.MULTILINE)
    assert len(steps) > 20
    for step in steps:
        resolve_name(f"hydroservo.{step}")
