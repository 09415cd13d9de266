"""The glossary has few words, each of them in use, and a class that it names is one alone."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "glossary.md"
ENTRY = re.compile(r"^\| ([a-z][a-z ]*) \| ([^|]+) \| (?:`(\w+)`)? ?\|$", re.MULTILINE)
ENTRIES = {word: (meaning, name) for word, meaning, name in ENTRY.findall(PAGE.read_text("utf-8"))}
CLASSES = {word: name for word, (_, name) in ENTRIES.items() if name}


@pytest.fixture(scope="module")
def sources() -> str:
    return "\n".join(path.read_text("utf-8") for path in (ROOT / "src" / "hydroservo").rglob("*.py"))


def test_it_is_short() -> None:
    rows = [line for line in PAGE.read_text("utf-8").splitlines() if line.startswith("| ")]
    assert len(rows) == len(ENTRIES) + 1  # the heading; an entry is a row, and no word has two
    assert len(ENTRIES) <= 40
    assert list(ENTRIES) == sorted(ENTRIES)
    assert max(len(meaning.split()) for meaning, _ in ENTRIES.values()) <= 22


def test_both_doors_lead_to_it() -> None:
    assert "docs/glossary.md" in (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    assert "\nglossary\n" in (ROOT / "docs" / "index.md").read_text("utf-8")


@pytest.mark.parametrize("word", ENTRIES)
def test_each_word_is_used(word: str, sources: str) -> None:
    pages = [path for path in (ROOT / "docs").rglob("*.md") if path != PAGE]
    text = "\n".join(path.read_text("utf-8") for path in pages) + sources
    assert re.search(rf"\b{word}s?\b", text, re.IGNORECASE)


@pytest.mark.parametrize("name", CLASSES.values(), ids=list(CLASSES))
def test_each_class_is_defined_once(name: str, sources: str) -> None:
    assert re.findall(rf"^class {name}\b", sources, re.MULTILINE) == [f"class {name}"]
