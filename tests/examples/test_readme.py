"""The README's two lines are where CI finds them, and its picture and links are there."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("name", "ends_with"), [("paper", "hydroservo paper"), ("test", "pytest")])
def test_line_for_ci(name: str, ends_with: str) -> None:
    found = re.findall(rf"^<!-- ci: {name} -->\n```sh\n(.*)\n```$", README, re.MULTILINE)
    assert len(found) == 1
    assert found[0].startswith("python3 -m venv .venv && ")
    assert found[0].endswith(ends_with)


def test_links_lead_somewhere() -> None:
    targets = [target for target in re.findall(r"\]\(([^)]+)\)", README) if "://" not in target]
    assert targets
    assert [target for target in targets if not (ROOT / target.partition("#")[0]).exists()] == []


def test_no_number_is_typed() -> None:
    """Measured numbers belong in what a command makes."""
    generated = r"<!-- (?:benchmarks|rig): begin -->.*?<!-- (?:benchmarks|rig): end -->"
    text = re.sub(rf"{generated}|```.*?```|\(https?:[^)]*\)|`[^`]*`", "", README, flags=re.DOTALL)
    text = (
        text.replace("doi:10.1007/s42401-021-00087-w", "")
        .replace("Python 3.11", "")
        .replace("BSD-3-Clause", "")
    )
    assert re.findall(r"\d+", text) == []
