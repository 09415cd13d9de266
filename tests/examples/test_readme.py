"""The README is short and true: its lines for CI, its links, its scenario, its table and its Python."""

import re
import shutil
import tomllib
from pathlib import Path
from runpy import run_path

import pytest

import hydroservo as hs

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("name", "ends_with"), [("paper", "hydroservo paper"), ("test", "pytest")])
def test_line_for_ci(name: str, ends_with: str) -> None:
    found = re.findall(rf"^<!-- ci: {name} -->\n```sh\n(.*)\n```$", README, re.MULTILINE)
    assert len(found) == 1
    assert found[0].startswith("python3 -m venv .venv && ")
    assert found[0].endswith(ends_with)


def test_each_extra_of_a_user_is_named() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    of_developers = {"bench", "test", "docs", "dev"}
    start = (ROOT / "docs" / "start.md").read_text(encoding="utf-8")
    install = start.partition("## Install")[2].partition("\n## ")[0]
    assert set(re.findall(r"^\| `(\w+)` \|", install, re.MULTILINE)) == set(extras) - of_developers


def test_links_lead_somewhere() -> None:
    targets = [*re.findall(r"\]\(([^)]+)\)", README), *re.findall(r'src="([^"]+)"', README)]
    assert targets
    assert [target for target in targets if not (ROOT / target.partition("#")[0]).exists()] == []


def test_no_number_is_typed() -> None:
    """Measured numbers belong in what a command makes."""
    text = re.sub(
        r"<!-- axis: begin -->.*?<!-- axis: end -->|```.*?```|<img [^>]*>", "", README, flags=re.DOTALL
    )
    text = text.replace("Python 3.11", "").replace("BSD-3-Clause", "")
    assert re.findall(r"\d+", text) == []


def test_the_first_screen_is_an_example() -> None:
    (block,) = re.findall(r"^```toml\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)
    assert (ROOT / "examples" / "axis.toml").read_text(encoding="utf-8").endswith(f"\n\n{block}")
    assert "\n.venv/bin/hydroservo run examples/axis.toml --out axis\n" in README


def test_it_is_read_in_a_few_minutes() -> None:
    assert len(README.split()) <= 800


def test_its_python_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    (text,) = re.findall(r"^```python\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)
    exec(compile(text, "README", "exec"), {"__name__": "readme"})
    assert (tmp_path / "axis.png").exists()


@pytest.mark.slow
def test_the_first_table_is_what_its_script_makes() -> None:
    axis = run_path(str(ROOT / "scripts" / "axis"))
    run = hs.simulate(hs.load_scenario(ROOT / "examples" / "axis.toml"), strict=True)
    assert f"{axis['BEGIN']}{axis['table'](run)}{axis['END']}" in README


def test_the_fronts_have_points_of_each_law_in_each_cell_at_the_references_own_activity() -> None:
    import pandas as pd

    assert "docs/_static/velocity-fronts.svg" in README
    points = pd.read_csv(ROOT / "docs" / "_static" / "velocity-fronts.csv")
    assert points.groupby(["cell", "law"]).ngroups == points["cell"].nunique() * points["law"].nunique()
    own = points[(points["law"] == "pi") & (points["level"] == 1.0)]
    assert len(own) == points["cell"].nunique() == 8
    assert (own["error over the reference's"] == 1.0).all()
