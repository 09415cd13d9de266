"""Comparing several scenarios."""

import json

import pandas as pd
import pytest

from hydroservo import Loop, Simulation, simulate
from hydroservo.cli.run import short_names
from hydroservo.control.references import Ramp, Sine, Square, Step
from hydroservo.core.formatting import NONE
from hydroservo.runs.comparison import best_as_read
from hydroservo.testing.examples import example
from tests.support.bases import on_base
from tests.support.commands.runner import SHORT, UNSTABLE, succeeded

pytestmark = pytest.mark.slow  # it runs and draws


def test_compare_marks_the_best_of_each_row():
    text = succeeded("compare", "paper/sine-pi", "paper/sine-backstepping", *SHORT)
    rows = [line.replace("┃", "│").split("│") for line in text.splitlines() if line[0] in "┃│"]
    cells = {row[1].strip(): [cell.strip() for cell in row[2:-1]] for row in rows}
    assert cells["metric"] == ["unit", "paper/sine-pi", "paper/sine-backstepping"]
    unit, pi, backstepping = cells["rms_error"]
    assert unit == "mm/s"
    assert pi.endswith(" *")
    assert float(pi.removesuffix(" *")) < float(backstepping)
    assert "*" not in "".join(cells["position_max"])


def test_compare_marks_nothing_under_unequal_conditions(tmp_path):
    scenarios = [tmp_path / "one.toml", tmp_path / "other.toml"]
    for path, mass in zip(scenarios, ("6 kg", "7 kg"), strict=True):
        path.write_text(on_base(f'plant.mass = "{mass}"\n'))
    said = succeeded("compare", *scenarios, *SHORT)
    assert "*" not in said
    assert "  plant.mass: 6 kg, 7 kg" in said.splitlines()
    out = tmp_path / "out"
    found = json.loads(succeeded("compare", *scenarios, *SHORT, "--json", "--out", out))
    assert found["comparable"] is False
    assert found["differences"] == {"plant.mass": [6.0, 7.0]}
    written = json.loads((out / "metrics.json").read_text())
    assert written.pop("files").keys() == {
        *("comparison.png", "comparison.svg", "metrics.csv", "report.html"),
        *("tables/metrics.csv", "tables/metrics.tex"),
    }
    assert written == found


def test_compare_json_is_one_object_with_every_run_in_order():
    names = ["paper/sine-backstepping", "paper/sine-pi"]
    said = json.loads(succeeded("compare", *names, *SHORT, "--json"))
    assert list(said) == ["runs", "comparable", "differences"]
    assert said["comparable"] is True
    assert said["differences"] == {}
    assert [run["scenario"] for run in said["runs"]] == names
    alone = json.loads(succeeded("run", names[1], *SHORT, "--json"))
    assert said["runs"][1] == alone


def test_compare_writes_metrics_and_a_plot(tmp_path):
    names = ("paper/sine-pi", "paper/sine-backstepping")
    succeeded("compare", *names, *SHORT, "--out", tmp_path)
    files = {path.name for path in tmp_path.iterdir()}
    assert files == {
        *("metrics.csv", "metrics.json", "comparison.png", "comparison.svg", "report.html", "tables")
    }
    assert pd.read_csv(tmp_path / "metrics.csv")["scenario"].tolist() == list(names)
    said = json.loads((tmp_path / "metrics.json").read_text())
    assert [run["scenario"] for run in said["runs"]] == list(names)


def test_compare_says_which_run_diverged():
    text = succeeded("compare", "paper/sine-pi", "paper/sine-pi", *SHORT, *UNSTABLE)
    assert text.count("paper/sine-pi: The run diverged: plant.velocity left physical reach") == 2


def test_files_are_called_by_their_name_alone_where_that_is_clear():
    assert short_names(["a/x.toml", "paper/sine-pi"]) == ["x", "paper/sine-pi"]
    assert short_names(["a/x.toml", "b/x.toml"]) == ["a/x.toml", "b/x.toml"]


def cells_of(text):
    rows = [line.replace("┃", "│").split("│") for line in text.splitlines() if line[:1] in ("┃", "│")]
    return {row[1].strip(): [cell.strip() for cell in row[2:-1]] for row in rows}


def test_runs_whose_numbers_read_the_same_are_both_best_or_none():
    same = 1e-3 + 1e-12
    assert best_as_read([1e-3, same, 2e-3], {0}, [False] * 3) == {0, 1}
    assert best_as_read([1e-3, same], {0}, [False] * 2) == set()
    assert best_as_read([1e-3, same, 1e-3], {0}, [False, False, True]) == set()
    assert best_as_read([1e-3, 2e-3, 1e-3], {0}, [False, False, True]) == {0}
    assert best_as_read([1e-3, None, 2e-3], {0}, [False] * 3) == {0}


def test_a_demand_that_does_not_jump_has_no_settling_time():
    sine, square = "paper/sine-pi", "paper/square-pi"
    short = ("--set", "simulation.duration=0.01s")
    assert not {"settling_time", "overshoot"} & set(cells_of(succeeded("run", sine, *short)))
    assert {"settling_time", "overshoot"} <= set(cells_of(succeeded("run", square, *short)))
    found = cells_of(succeeded("compare", sine, square, *short))
    assert found["settling_time"][1] == found["overshoot"][1] == NONE
    assert found["settling_time"][2] != NONE
    said = json.loads(succeeded("run", sine, *short, "--json"))
    assert said["metrics"]["settling_time"] is not None  # a number as it was recorded


@pytest.mark.parametrize(
    ("reference", "jumps"),
    [
        (Sine(0.03, 0.25), False),
        (Sine(0.03, 0.25, phase=1.0), True),  # the start from rest
        (Square(0.03, 4.0), True),
        (Step(0.0, 0.03, 1.0), True),
        (Ramp(0.0, 0.03, 0.1), False),
    ],
)
def test_which_demands_jump(reference, jumps):
    run = simulate(example(Loop, Simulation(8.0), reference=reference))
    assert bool(run["demand_jumps"]) is jumps
    assert run["demand_reach"] == pytest.approx(0.03, rel=1e-3)
