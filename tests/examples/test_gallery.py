"""The gallery of the documentation: each notebook is a script that leaves a picture."""

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

from tests.support.tiers import mostly

GALLERY = Path(__file__).parents[2] / "docs" / "gallery"
INDEX = (GALLERY / "index.md").read_text(encoding="utf-8")
SCRIPTS = sorted(path.stem for path in GALLERY.glob("*.py"))
HERE = [name for name in SCRIPTS if name != "laws_in_a_study"]

TRUE = {  # of the logs' machines, in SI units
    "a_matrix_of_matlab": {"plant.mechanism.mass": 90.0, "valve.orifice.rated_flow": 17.0 / 6e4},
    "boom_behind_a_can_bus": {
        "load.amplitude": 5e3,
        "valve.time_constant": 0.06,
        "valve.orifice.rated_flow": 24.0 / 6e4,
    },
    "export_of_a_rig": {"plant.mass": 8.0, "plant.bulk_modulus": 9e8, "valve.time_constant": 0.012},
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")
    yield tmp_path
    plt.close("all")


@pytest.mark.slow  # runs and searches
@pytest.mark.filterwarnings("default")  # a script may warn, as a notebook does
@pytest.mark.parametrize("name", mostly(pytest.mark.nightly, HERE, ["my_cylinder", "own_law"]))
def test_a_script_leaves_its_picture(name: str, folder: Path) -> None:
    spec = importlib.util.spec_from_file_location(name, GALLERY / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    finally:
        del sys.modules[name]
    assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    for path, value in TRUE.get(name, {}).items():
        assert module.found.parameters[path].value == pytest.approx(value, rel=0.01)


@pytest.mark.nightly  # processes of its own
def test_the_study_is_a_program(folder: Path) -> None:
    line = [sys.executable, GALLERY / "laws_in_a_study.py"]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (folder / "laws_in_a_study.png").read_bytes().startswith(b"\x89PNG")


def test_the_index_shows_each_with_its_picture() -> None:
    shown = re.findall(r"pictures/(\w+)\.png\n:target: (\w+)\.html\n:alt: (.+)\n\n\{doc\}`(\w+)`", INDEX)
    assert len(SCRIPTS) == 13
    assert sorted(name for name, *_ in shown) == SCRIPTS
    for name, target, title, linked in shown:
        assert name == target == linked
        assert (GALLERY / f"{name}.py").read_text(encoding="utf-8").splitlines()[1] == f"# # {title}"
        assert (GALLERY / "pictures" / f"{name}.png").is_file()
