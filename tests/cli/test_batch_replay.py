"""``hydroservo batch``: each run can be replayed alone."""

import shlex

import pytest
from cli_runner import succeeded
from test_batch_ranges import drawn

from hydroservo import Loop
from hydroservo.block import replace
from hydroservo.cli.replay import Origin, command
from hydroservo.provenance import scenario_hash
from hydroservo.scenario import load_scenario, parse_override

NAME = "paper/sine-backstepping"  # whose controller has a model of the machine
VARIED = ("--vary", "plant.bulk_modulus=-30%..+30%", "--vary", "controller.velocity_gain=1500..2500")


def replayed(text: str | None) -> Loop:
    """The loop that a printed command simulates."""
    assert text is not None
    words = shlex.split(text)
    assert words[:2] == ["hydroservo", "run"]
    assert set(words[3::2]) == {"--set"}
    return load_scenario(words[2], dict(map(parse_override, words[4::2])))


@pytest.mark.parametrize(
    "changes",
    [
        [],
        ["uncertainty.scale=0"],
        ["uncertainty.scale=-1", "plant.mass=7 kg"],
        ["uncertainty.scale='50 %'"],
        ["plant.leakage=0"],
        ["uncertainty.plant.mass=0.25", "controller.model.plant.mass=5"],
    ],
)
@pytest.mark.parametrize("name", [NAME, "paper/square-tsmc"])
def test_a_run_is_replayed_to_the_bit(name, changes):
    ranges = (
        "plant.mass=-50%..50%",
        "plant.bulk_modulus=500..900MPa",
        "plant.leakage=1e-11..9e-11",
        "load.amplitude=-150..150N",
        "supply.supply_pressure=20..60bar",
        "controller.model.plant.damping=10..90",
        "sensors.velocity_noise=0..1mm/s",
    )
    changes = [*changes, "sensors.type=NoisySensors"]
    loop, found = drawn(*ranges, changes=changes, runs=20, seeds=True, name=name)
    for i in range(20):
        settings, parameters = found.of_run(i)
        again = replayed(command(Origin(name, changes, ()), settings, parameters))
        assert scenario_hash(again) == scenario_hash(replace(loop, parameters))


@pytest.mark.parametrize("name", ["paper/sine-pi", NAME])
def test_what_is_0_is_set_whether_a_law_has_a_model_or_not(name):
    changes = ["plant.leakage=0"]
    loop, found = drawn("plant.leakage=0..1e-11", changes=changes, name=name)
    settings, parameters = found.of_run(0)
    again = replayed(command(Origin(name, changes, ()), settings, parameters))
    assert scenario_hash(again) == scenario_hash(replace(loop, parameters))


def test_a_replay_names_plugins_and_quotes_what_a_shell_would_split(tmp_path):
    (tmp_path / "my file.py").write_text(
        "from typing import NamedTuple\n\nclass Mine(NamedTuple):\n    pass\n"
    )
    origin = Origin(NAME, ["plant.mass=7 kg"], [tmp_path / "my file.py"])
    text = command(origin, {"controller.velocity_gain": 60.0}, {"controller.velocity_gain": 60.0})
    assert shlex.split(text) == [
        *("hydroservo", "run", NAME, "--set", "plant.mass=7 kg", "--set", "controller.velocity_gain=60.0"),
        *("--plugin", str(tmp_path / "my file.py")),
    ]


def test_a_replay_takes_the_substeps_of_the_batch():
    changes = ["simulation.substeps=auto", "simulation.duration=5 ms"]
    args = [word for change in changes for word in ("--set", change)]
    text = succeeded("batch", NAME, *args, *VARIED, "--seeds", "--runs", "2", "--metric", "control_rms")
    line = next(line for line in text.splitlines() if line.startswith("run "))
    again = replayed(line.partition("; alone: ")[2])
    assert again.simulation.substeps >= 1
