"""Scenarios whose commands are in mA or in per cent: what is printed, drawn, written and exported."""

import csv
import json
import re
import tomllib
from pathlib import Path

import pytest

from hydroservo.app.jobs import JOBS
from hydroservo.app.source import Home
from hydroservo.app.worker import do_job
from hydroservo.scenario import load_scenario
from tests.support.commands.runner import failed, succeeded
from tests.support.needs import needs

pytestmark = pytest.mark.slow  # it runs and draws

OPEN = """\
base = "rig/1khz"
controls = { type = "Command" }
reference = { type = "Step", initial = "0 V", final = "AMOUNT", time = "2 ms" }
controller = { type = "OpenLoop" }
simulation = { duration = "20 ms" }
"""
SCALES = {"V": ("1 V", ""), "mA": ("4 mA", '[command]\nfull_scale = "40 mA"\n')}
SCALES["%"] = ("10 %", '[command]\nfull_scale = "100 %"\n')
SHOWN = {"V": ("V", 1.0), "mA": ("mA", 4.0), "%": ("%", 10.0)}


@pytest.fixture(params=SCALES)
def unit(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def scenario(unit: str, tmp_path: Path) -> Path:
    """A volt of command, as a scenario writes it in a unit."""
    amount, table = SCALES[unit]
    file = tmp_path / "one.toml"
    file.write_text(OPEN.replace("AMOUNT", amount) + table)
    return file


def cells_of(text: str, name: str) -> list[str]:
    (line,) = (line for line in text.splitlines() if re.match(rf"[│|] {name} ", line))
    return [cell.strip() for cell in re.split("[│|]", line)[1:-1]]


def test_the_terminal_shows_a_volt_in_the_unit_of_commands(scenario: Path, unit: str) -> None:
    label, size = SHOWN[unit]
    assert cells_of(succeeded("run", scenario), "control_max")[1:3] == [f"{size:g}", label]


def test_files_of_a_run_have_the_unit_of_commands(scenario: Path, unit: str, tmp_path: Path) -> None:
    label, size = SHOWN[unit]
    out = tmp_path / "out"
    succeeded("run", scenario, "--out", out)
    with (out / "trajectory.csv").open() as file:
        assert {float(row[f"controller.u [{label}]"]) for row in csv.DictReader(file)} == {0.0, size}
    with (out / "metrics.csv").open() as file:
        assert float(next(csv.DictReader(file))[f"control_max [{label}]"]) == size
    with (out / "tables" / "metrics.csv").open() as file:
        assert {row["metric"]: row["unit"] for row in csv.DictReader(file)}["control_max"] == label
    assert f"<!-- command [{label}] -->" in (out / "run.svg").read_text("utf-8")
    assert json.loads((out / "metrics.json").read_text())["metrics"]["control_max"] == 1.0


def test_a_log_of_a_run_is_read_back(scenario: Path, unit: str, tmp_path: Path) -> None:
    label, size = SHOWN[unit]
    succeeded("run", scenario, "--out", tmp_path / "out")
    said = succeeded("log", tmp_path / "out" / "trajectory.csv", "--scenario", scenario)
    assert cells_of(said, "command")[4:6] == [f"{size:g}", label]


def test_the_page_has_the_unit_of_commands(scenario: Path, unit: str, tmp_path: Path) -> None:
    class Pipe:
        def poll(self) -> bool:
            return False

        def send(self, _: object) -> None: ...

    label, size = SHOWN[unit]
    said = do_job(JOBS, "run", {}, Home(str(scenario), (), tmp_path), Pipe())
    drawn = {(one["unit"], one["factor"]) for one in said.about["panels"] if one["title"] == "command"}
    assert drawn == {(label, size)}


CURRENT = ("--set", "command.full_scale=40 mA")
PI = ("rig/1khz-pi-sine", "--set", "simulation.duration=20 ms", *CURRENT)


def test_options_take_the_unit_of_commands() -> None:
    volts = succeeded("linearize", "rig/1khz-pi-sine", "--command", "0.5 V")
    current = succeeded("linearize", *PI[:1], *CURRENT, "--command", "2 mA")
    assert volts.splitlines()[0] == current.splitlines()[0]
    of_volt, of_current = (float(cells_of(text, "velocity ")[1]) for text in (volts, current))
    assert of_volt == pytest.approx(4.0 * of_current, rel=1e-3)
    assert "by 1 mA of command" in current
    said = failed("bode", *PI, "--amplitude", "1 %")
    assert "does not convert to V or mA, as commands are by [command] full_scale" in said


def test_a_search_is_in_the_unit_of_commands_and_leaves_volts(tmp_path: Path) -> None:
    out = tmp_path / "found.toml"
    vary = "controller.proportional_gain=8..16 mA s/m"
    said = succeeded("tune", *PI, "--unbounded", "--vary", vary, "--candidates", "64", "--out", out)
    best, low, high, label = cells_of(said, "controller.proportional_gain")[-4:]
    assert (low, high, label) == ("8", "16", "mA s/m")
    found = tomllib.loads(out.read_text())["controller"]["proportional_gain"]
    assert float(best) == pytest.approx(4.0 * found, rel=1e-4)
    assert 2.0 <= found <= 4.0


def test_what_scenarios_do_not_share_is_in_volts(tmp_path: Path) -> None:
    for unit, (amount, table) in SCALES.items():
        name = {"%": "share"}.get(unit, unit)
        (tmp_path / f"{name}.toml").write_text(OPEN.replace("AMOUNT", amount) + table)
    both = succeeded("compare", tmp_path / "mA.toml", tmp_path / "share.toml")
    assert cells_of(both, "control_max")[1:] == ["V", "1", "1"]


def test_ma_without_a_full_scale_is_one_line(tmp_path: Path) -> None:
    file = tmp_path / "bad.toml"
    file.write_text('base = "rig/1khz-pi-sine"\ncontroller.saturation.limit = "40 mA"\n')
    said = failed("run", file)
    assert said.count("\n") == 1
    assert "controller.saturation.limit: '40 mA' does not convert to V" in said
    assert 'add [command] full_scale = "40 mA"' in said


def test_exported_c_has_the_unit_of_commands(tmp_path: Path) -> None:
    needs("cc")
    said = succeeded("export", "c", *PI, "--prefix", "law", "--out", tmp_path)
    assert "samples bit for bit" in said
    header = (tmp_path / "law.h").read_text()
    assert "The command comes and goes in mA, 4 mA a volt" in header
    assert "returns the command [mA], which is also state->u" in header
    assert "double u; /* [mA] command */" in " ".join(header.split())
    assert "double command; /* [mA] mean of u" in " ".join(header.split())
    assert "limit; /* [V] largest command */" in " ".join(header.split())


def test_what_is_exported_of_a_machine_fits_its_controller(tmp_path: Path) -> None:
    needs("cc")
    for part in ("machine", "equations"):
        said = succeeded("export", "c", *PI, "--unit", part, "--prefix", "law", "--out", tmp_path / part)
        assert "samples bit for bit" in said
        header = (tmp_path / part / "law.h").read_text()
        assert "double u; /* [mA] command */" in " ".join(header.split())


def test_what_identify_writes_keeps_the_full_scale(tmp_path: Path) -> None:
    file = tmp_path / "axis.toml"
    file.write_text(
        'base = "rig/1khz-pi-sine"\nsimulation.duration = "1 s"\n'
        'valve.gain = "125 um/mA"\ncommand.full_scale = "40 mA"\n'
        "[uncertainty]\nplant = { damping = 0.0, bulk_modulus = 0.0, leakage = 0.0 }\n"
        "valve.orifice = { discharge_coefficient = 0.0, area_gradient = 0.0, density = 0.0 }\n"
    )
    succeeded("run", file, "--out", tmp_path / "run")
    log, out = tmp_path / "run" / "trajectory.csv", tmp_path / "found"
    said = succeeded("identify", file, log, "--vary", "valve.gain=100..150 um/mA", "--out", out)
    cells = cells_of(said, "valve.gain")
    assert cells[4] == "um/mA"  # as the range was typed
    assert any(cell.startswith("125") for cell in cells)
    found = load_scenario(out / "scenario.toml")
    assert found.command.unit == "mA"
    assert found.valve.gain == pytest.approx(5e-4, rel=1e-4)
