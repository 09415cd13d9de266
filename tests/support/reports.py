"""What every folder with a report must hold, whatever command left it."""

import base64
import html
import json
import re
from collections.abc import Mapping
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pandas as pd

from hydroservo.show.files import METRICS, foreign_files

EMBEDDED = re.compile(r"base64,([^\"]*)")


class Links(HTMLParser):
    """All that a page refers to, and the tags that it left open."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str | None] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found += [value for name, value in attrs if name in ("href", "src")]
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def page(folder: Path) -> str:
    return (folder / "report.html").read_text(encoding="utf-8")


def text_of(folder: Path) -> str:
    """The text of a page, as it is read."""
    plain = re.sub(r"<style>.*?</style>|<[^>]*>", " ", page(folder), flags=re.DOTALL)
    return html.unescape(plain)


def check_offline(folder: Path) -> None:
    """A page refers to nothing outside it."""
    links, text = Links(), page(folder)
    links.feed(text)
    assert links.open == []
    assert all(str(one).startswith(("#", "data:image/svg+xml;base64,")) for one in links.found)
    assert "http" not in EMBEDDED.sub("", text)


def check_report(folder: Path, said: Mapping[str, Any]) -> None:
    """The page opens offline and has the pictures and tables beside it; the folder has all numbers.

    Args:
        folder: with a report.
        said: what ``--json`` printed.
    """
    check_offline(folder)
    kept = json.loads((folder / METRICS).read_text(encoding="utf-8"))
    named = kept.pop("files")
    assert kept == said
    assert foreign_files(folder) == []
    assert "report.html" in named
    shown = {base64.b64decode(one) for one in EMBEDDED.findall(page(folder))}
    assert shown == {file.read_bytes() for file in folder.glob("*.svg")}
    read = " ".join(text_of(folder).split())
    assert page(folder).count("<tbody>") >= len([one for one in named if one.endswith(".tex")])
    tables = [folder / one for one in named if one.startswith("tables/") and one.endswith(".csv")]
    assert tables
    for file in tables:
        assert str(file.relative_to(folder).with_suffix(".tex")) in named
        texts = pd.read_csv(file, dtype=str, keep_default_na=False).drop(columns="unit", errors="ignore")
        for row in texts.itertuples(index=False, name=None):
            for cell in row:
                assert is_number(cell) or " ".join(cell.split()) in read


def is_number(cell: str) -> bool:
    """Whether a cell of a table is a number, which the page rounds and scales."""
    try:
        float(cell)
    except ValueError:
        return False
    return True
