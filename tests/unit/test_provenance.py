"""The scenario that a result carries is a file that runs, with the same numbers."""

import warnings
from pathlib import Path

import pytest

from hydroservo import HydroservoWarning, ScenarioError, load_scenario, simulate
from hydroservo.runs.results import metrics_of

BRIEF = {"simulation.duration": 0.05}


@pytest.mark.parametrize(
    "name", ["axis/crane", "axis/position-lq", "laws/mpc-sine", "paper/square-tsmc", "rig/encoder-tsmc-sine"]
)
def test_a_result_is_run_again_from_its_own_scenario(tmp_path: Path, name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HydroservoWarning)
        first = simulate(load_scenario(name, BRIEF), record=())
        (tmp_path / "again.toml").write_text(first.attrs["scenario"], "utf-8")
        again = simulate(load_scenario(tmp_path / "again.toml"), record=())
    assert again.attrs["scenario"] == first.attrs["scenario"]
    assert str(metrics_of(again)) == str(metrics_of(first))


def test_another_type_at_the_top_is_refused(tmp_path: Path) -> None:
    (tmp_path / "wrong.toml").write_text('base = "paper/sine-pi"\ntype = "Machine"\n', "utf-8")
    with pytest.raises(ScenarioError, match=r"wrong.toml: type: unknown key \(value 'Machine'\)"):
        load_scenario(tmp_path / "wrong.toml")
