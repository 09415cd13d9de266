"""Whole studies, small ones: the same bits however they are run, and each number repeated alone."""

import html
import json
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import hydroservo as hs
from hydroservo.cli.commands import app
from hydroservo.studies.cells import laws_in_cells, search_units
from hydroservo.studies.report.folder import conditions_in, repeat_commands, write_study_report
from hydroservo.studies.report.view import study_view
from hydroservo.studies.spec_file import read_study
from hydroservo.studies.study import StudyResult
from tests.support.commands.processes import HYDROSERVO, needs_posix
from tests.support.plugins import LAW

pytestmark = pytest.mark.slow
KILLS = 4
TINY: dict[str, Any] = {
    "search.candidates": 256,
    "search.seeds": 2,
    "search.widen": 0,
    "set.simulation.duration": "0.5 s",
    "conditions.train": 2,
    "conditions.validation": 2,
    "conditions.test": 4,
    "conditions.stress": [1.0, 2.0],
    "conditions.stressed": 2,
    "limits.conditions": 2,
}

FEW = {**TINY, "search.seeds": 1}


def parts(folder: Path, name: str = "parts") -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in (folder / name).iterdir()}


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> StudyResult:
    return hs.study("small", tmp_path_factory.mktemp("tiny"), changes=TINY, workers=1)


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> StudyResult:
    return hs.study("small", tmp_path_factory.mktemp("few"), changes=FEW, workers=1)


def test_there_is_a_row_for_each_point_and_condition(tiny: StudyResult) -> None:
    table = tiny.table
    assert table.groupby(["law", "cell", "search_seed"]).ngroups == 4 * 2 * 2
    counts = table.groupby(["law", "cell", "search_seed", "point", "split"])["condition"].nunique().unstack()
    assert counts["train"].eq(2).all()
    assert counts["validation"].eq(2).all()
    judged = counts["test"].notna()
    assert judged.groupby(["law", "cell", "search_seed"]).any().all()
    assert counts[judged][["test", "stress"]].eq(4).all().all()
    assert not table["lost"].any()


def test_each_law_has_margins_and_a_price_in_each_cell(tiny: StudyResult) -> None:
    cells = tiny.verdicts.levels["1"].cells.values()
    for cell in cells:
        assert cell.properties.keys() == cell.standings.keys()
        assert cell.properties["pi"].margins.stable
    operations = [
        next(cell.properties[law].target.operations or 0 for cell in cells if law in cell.properties)
        for law in ("pi", "lq", "terminal")
    ]
    assert 0 < operations[0] < operations[1] < operations[2]


def test_a_row_is_repeated_alone_bit_for_bit(tiny: StudyResult) -> None:
    rows = tiny.table[(tiny.table["law"] == "terminal") & (tiny.table["cell"] == "high")]
    conditions = json.loads((tiny.folder / "conditions" / "high.json").read_text("utf-8"))
    for split, number in (("test", 1), ("stress", 2)):
        row = rows[(rows["split"] == split) & (rows["condition"] == number)].iloc[-1]
        condition = conditions[split][str(number)]
        scenario = tiny.folder / "scenarios" / "high" / "terminal" / f"{condition['kind']}.toml"
        loop = hs.load_scenario(scenario, {**condition["set"], **json.loads(row["parameters"])})
        assert float(hs.simulate(loop, strict=True)["rms_error"]) == row["error"]


def killed_now_and_then(folder: Path, changes: dict[str, Any]) -> int:
    """Run a study as a command that is killed until it ends; how often it was."""
    words = [*HYDROSERVO, "study", "small", "--out", str(folder), "--workers", "2"]
    words += [f"--set={path}={json.dumps(value)}" for path, value in changes.items()]
    draw = np.random.default_rng(1)
    for kills in range(KILLS + 1):
        with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as running:
            try:
                running.wait(None if kills == KILLS else draw.uniform(0.0, 8.0))
            except subprocess.TimeoutExpired:
                running.kill()
                continue
        assert running.returncode == 0
        return kills
    raise AssertionError


@pytest.mark.nightly
@needs_posix
def test_neither_kills_nor_processes_nor_what_was_done_before_change_a_bit(
    tiny: StudyResult, tmp_path: Path
) -> None:
    folder = tmp_path / "again"
    assert killed_now_and_then(folder, {**TINY, "search.seeds": 1}) > 2
    half = parts(folder)
    assert len(half) == len(parts(tiny.folder)) // 2
    hs.study("small", folder, changes=TINY, workers=2)
    assert parts(folder) == parts(tiny.folder)
    assert half.items() <= parts(folder).items()
    assert parts(folder, "limits") == parts(tiny.folder, "limits")
    assert parts(folder, "properties") == parts(tiny.folder, "properties")
    assert (folder / "study.json").read_bytes() == (tiny.folder / "study.json").read_bytes()


def test_cells_of_one_machine_have_the_same_limits(tiny: StudyResult) -> None:
    cells = tiny.limits.set_index(["cell", "condition"]).unstack("condition")
    assert (cells.loc["low"] == cells.loc["high"]).all()
    assert len(parts(tiny.folder, "limits")) == 2
    assert len(pd.read_parquet(tiny.folder / "limits")) == 2
    assert tiny.limits["converged"].all()


def test_no_run_of_any_law_leaves_less_than_the_clairvoyant_limit(tiny: StudyResult) -> None:
    tests = tiny.table[tiny.table["split"] == "test"]
    runs = tests.merge(tiny.limits, on=["cell", "condition"])
    assert len(runs) == 2 * tests.groupby(["law", "cell", "search_seed", "point"]).ngroups
    assert (runs["error"] >= runs["clairvoyant"] * (1.0 - 1e-4)).all()
    assert (runs["causal"] >= runs["clairvoyant"] * (1.0 - 1e-4)).all()
    for cell in tiny.verdicts.levels["1"].cells.values():
        assert (cell.limit.conditions, cell.limit.open, cell.limit.below) == ([0, 1], 0, 0)
        assert all(one.high >= one.clairvoyant > 1.0 for one in cell.limit.laws.values())


def test_a_limit_that_is_missing_is_sought_again_and_more_leave_those_there_are(
    tiny: StudyResult, tmp_path: Path
) -> None:
    folder = tmp_path / "one"
    shutil.copytree(tiny.folder, folder)
    before = parts(folder, "limits")
    (folder / "limits" / min(before)).unlink()
    again = hs.study("small", folder, changes=TINY, workers=1)
    assert parts(folder, "limits") == before
    assert again.verdicts.as_dict() == tiny.verdicts.as_dict()
    more = hs.study("small", folder, changes={**TINY, "limits.conditions": 3}, workers=1)
    assert before.items() < parts(folder, "limits").items()
    assert more.table.equals(tiny.table)
    none = hs.study("small", folder, changes={**TINY, "limits.conditions": 0}, workers=1)
    assert none.limits.empty
    assert parts(folder) == parts(tiny.folder)


def test_what_another_study_left_waits_beside_the_table(few: StudyResult, tmp_path: Path) -> None:
    folder = shutil.copytree(few.folder, tmp_path / "two")
    other = hs.study("small", folder, changes={**FEW, "conditions.test": 6}, workers=2)
    assert len(parts(folder)) == 8
    assert len(pd.read_parquet(folder / "parts")) == len(other.table)
    tested = few.table[few.table["split"] == "test"].groupby(["law", "cell", "point"]).ngroups
    assert len(other.table) == len(few.table) + 2 * tested
    again = hs.study("small", folder, changes=FEW, workers=1)
    assert again.table.equals(few.table)
    assert len(pd.read_parquet(folder / "parts")) == len(few.table)


def test_what_a_study_has_no_more_has_no_scenarios(few: StudyResult, tmp_path: Path) -> None:
    folder = shutil.copytree(few.folder, tmp_path / "three")
    third = {"axes.noise.levels.third": {"value": 0.05}}
    hs.study("small", folder, changes={**FEW, **third}, workers=1)
    own = folder / "scenarios" / "third" / "pi" / "own.toml"
    own.write_text("")
    hs.study("small", folder, changes=FEW, workers=1)
    assert [*(folder / "scenarios" / "third").rglob("*.toml")] == [own]
    assert {file.stem for file in (folder / "conditions").iterdir()} == {"low", "high"}
    own.unlink()
    hs.study("small", folder, changes={**FEW, "laws.lq.family": "LQ"}, workers=1)
    assert len([*(folder / "scenarios").rglob("*.toml")]) == 4 * 2 * 2  # laws, cells, kinds


def test_what_is_done_is_not_done_again(tiny: StudyResult) -> None:
    before = {file: file.stat().st_mtime_ns for file in (tiny.folder / "parts").iterdir()}
    again = hs.study("small", tiny.folder, changes=TINY, workers=1)
    assert {file: file.stat().st_mtime_ns for file in (tiny.folder / "parts").iterdir()} == before
    assert again.table.equals(tiny.table)
    assert again.verdicts.as_dict() == tiny.verdicts.as_dict()


def test_only_what_changed_is_done(few: StudyResult, tmp_path: Path) -> None:
    folder = shutil.copytree(few.folder, tmp_path / "changed")
    before = {file.name: file.stat().st_mtime_ns for file in (folder / "parts").iterdir()}
    hs.study("small", folder, changes={**FEW, "laws.lq.set": {"controller.effort": 1e-3}}, workers=2)
    after = {file.name: file.stat().st_mtime_ns for file in (folder / "parts").iterdir()}
    assert len(after) == len(before)
    assert len(before.items() & after.items()) == len(before) * 3 // 4  # three laws of four


def test_a_command_of_the_report_gives_its_number(tiny: StudyResult, monkeypatch: pytest.MonkeyPatch) -> None:
    write_study_report(tiny.table, tiny.manifest, tiny.verdicts, tiny.folder)
    found = study_view(tiny.manifest, tiny.verdicts)
    one = repeat_commands(tiny.table, found, conditions_in(tiny.folder))["high", "terminal"]
    page = html.unescape((tiny.folder / "report.html").read_text("utf-8"))
    assert one.command in page
    monkeypatch.chdir(tiny.folder)
    result = CliRunner().invoke(app, [*shlex.split(one.command)[1:], "--json"])
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["metrics"]["rms_error"] == one.error


OWN = """
base = "machines/own.toml"
plugins = ["law.py"]
laws.pi.scenario = "laws/pi-sine"
laws.own = { scenario = "own.toml" }
set.reference = { type = "Recorded", series = { file = "demand.csv", column = "v [m/s]", time = "t [s]" } }
conditions = { train = 1, validation = 1, test = 2, vary."plant.mass" = "-30%..+30%" }
search = { candidates = 256, widen = 0 }
"""
MACHINE = """
base = "rig/noisy-1khz"
load.type = "Constant"
simulation.duration = "0.4 s"
"""
OF_PLUGIN = """
base = "machines/own.toml"
reference = { type = "Sine", amplitude = "1 mm/s", frequency = "1 Hz" }
controller = { type = "SpawnedLaw", gain = 2.0 }
tune.vary."controller.gain" = "0.1..10 V s/m"
"""


def own_files(folder: Path, name: str) -> Path:
    """A study of files of one's own: machine, recording, and a law of a plug-in with its class's name."""
    (folder / "machines").mkdir(parents=True)
    plugin = LAW.replace("class Law(", f"class {name}(")
    demand = "t [s],v [m/s]\n0,0\n0.1,0.02\n0.3,-0.02\n1,0\n"
    texts = {
        "study.toml": OWN,
        "own.toml": OF_PLUGIN.replace("SpawnedLaw", name),
        "machines/own.toml": MACHINE,
    }
    for file, text in {**texts, "law.py": plugin, "demand.csv": demand}.items():
        (folder / file).write_text(text, "utf-8")
    return folder / "study.toml"


def test_a_study_of_files_of_ones_own_can_move_with_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = own_files(tmp_path / "there", "SpawnedLaw")
    found = hs.study(study, tmp_path / "there" / "deep" / "out", workers=2)
    (tmp_path / "there").rename(tmp_path / "elsewhere")
    folder = tmp_path / "elsewhere" / "deep" / "out"
    report = study_view(found.manifest, found.verdicts)._replace(level="8")
    one = repeat_commands(found.table, report, conditions_in(folder))["all", "own"]
    monkeypatch.chdir(folder)
    result = CliRunner().invoke(app, [*shlex.split(one.command)[1:], "--json"])
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["metrics"]["rms_error"] == one.error


def test_what_a_plugin_says_is_part_of_what_its_searches_depend_on(tmp_path: Path) -> None:
    study = own_files(tmp_path, "ChangedLaw")

    def keys(law: str) -> set[str]:
        asked = read_study(study)
        return {
            unit.key
            for one in laws_in_cells(asked)
            if one.law.name == law
            for unit in search_units(asked, one, 1.0)
        }

    before = {law: keys(law) for law in ("pi", "own")}
    plugin = tmp_path / "law.py"
    plugin.write_text(plugin.read_text("utf-8").replace("self.gain *", "0.5 * self.gain *"), "utf-8")
    assert keys("pi") == before["pi"]
    assert not keys("own") & before["own"]
