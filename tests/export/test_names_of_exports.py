"""Prefixes and titles of exports."""

from importlib import resources
from pathlib import Path

import fmpy
import pytest

from hydroservo.control.loop import Loop
from hydroservo.core.errors import ParameterError
from hydroservo.export.c.project import write_c_project
from hydroservo.export.fmu import write_fmu
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.texts import checked_prefix, default_prefix
from hydroservo.export.unit import Part, Precision
from tests.support.export.projects import TITLE, check, unit

FMU_SOURCES = sorted(file.name for file in (resources.files("hydroservo.export.fmu") / "sources").iterdir())


@pytest.mark.parametrize(
    ("name", "prefix"),
    [
        ("paper/sine-tsmc", "sine_tsmc"),
        ("rig/1khz-pi-sine", "law_1khz_pi_sine"),
        ("dir/My Law.v2.toml", "my_law_v2"),
        ("math.toml", "law_math"),
        ("model.toml", "law_model"),
        ("fmi3-test.toml", "law_fmi3_test"),
        ("double.toml", "law_double"),
        ("-.toml", "law"),
    ],
)
def test_the_prefix_comes_from_the_scenarios_name(name: str, prefix: str) -> None:
    assert default_prefix(name, Part.CONTROLLER) == checked_prefix(prefix) == prefix
    assert checked_prefix(default_prefix(name, Part.MACHINE)).startswith("machine")


@pytest.mark.parametrize(
    "prefix",
    [
        "",
        "1st",
        "a-b",
        "../up",
        "a b",
        "é",
        "_a",
        "math",
        "Float",
        "double",
        "a\n",
        "model",
        "Instance",
        "fmi2x",
    ],
)
def test_a_prefix_that_names_cannot_begin_with(prefix: str, loop: Loop) -> None:
    with pytest.raises(ParameterError, match=r"^prefix = "):
        exported_unit(loop, Part.CONTROLLER, prefix=prefix, title=TITLE)


@pytest.mark.parametrize("file", ["model.c", *FMU_SOURCES])
def test_no_source_of_an_fmu_has_the_name_of_another(file: str) -> None:
    with pytest.raises(ParameterError, match="not a name that C or FMI uses"):
        checked_prefix(Path(file).stem)


@pytest.mark.parametrize(
    "title", ["a */ b /* c\nd\r\x0be %d %n $(CC) $x \\", "*//*/*/ <b> & \x07 {x} {{ y }} \\\n"]
)
def test_any_title_goes_into_comments(title: str, loop: Loop, tmp_path: Path) -> None:
    for precision in Precision:
        folder = tmp_path / precision
        made, vectors = unit(loop, precision=precision, title=title)
        write_c_project(made, vectors, folder)
        done = check(folder)
        assert (done.returncode, done.stderr) == (0, "")
        assert (folder / "README.md").read_text().startswith(f"# {made.title}\n\n")


def test_a_title_is_one_line_that_a_comment_may_hold(loop: Loop, tmp_path: Path) -> None:
    made = unit(loop, title="a <*/ b\n\x07 /*/ \\")[0]
    assert made.title == "a <* / b \\x07 / * /"
    file = write_fmu(made, tmp_path / "law.fmu", stop_time=1.0)
    assert fmpy.read_model_description(str(file)).modelName == made.title
