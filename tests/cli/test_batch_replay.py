"""``hydroservo batch``: each run can be replayed alone."""

import shlex

import pytest

from hydroservo.cli.options import replay_command
from hydroservo.runs.provenance import scenario_hash
from tests.support.commands.batches import NAME, again, alone, drawn, replayed
from tests.support.commands.runner import succeeded

pytestmark = pytest.mark.nightly  # tests.regression runs each command

VARIED = ("--vary", "plant.bulk_modulus=-30%..+30%", "--vary", "controller.velocity_gain=1500..2500")


@pytest.mark.parametrize(
    "changes",
    [
        [],
        ["uncertainty.scale=0"],
        ["uncertainty.scale=-1", "plant.mass=7 kg"],
        ["uncertainty.scale='50 %'"],
        ["plant.leakage=0"],
        ["uncertainty.plant.mass=0.25", "controller.model.plant.mass=5"],
        ["truth.plant.mass=7 kg", "truth.plant.damping=70"],
    ],
)
@pytest.mark.parametrize("name", [NAME, pytest.param("paper/square-tsmc", marks=pytest.mark.slow)])
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
    changes = [*changes, "sensors={type='NoisySensors', velocity_noise=5e-4, hydraulic_force_noise=5}"]
    loop, found = drawn(*ranges, changes=changes, runs=20, seeds=True, name=name)
    for i in range(20):
        assert scenario_hash(again(name, changes, found, i)) == scenario_hash(alone(loop, found, i))


@pytest.mark.parametrize("name", ["paper/sine-pi", NAME])
def test_what_is_0_is_set_whether_a_law_has_a_model_or_not(name):
    changes = ["plant.leakage=0"]
    loop, found = drawn("plant.leakage=0..1e-11", changes=changes, name=name)
    assert scenario_hash(again(name, changes, found, 0)) == scenario_hash(alone(loop, found, 0))


def test_a_replay_names_plugins_and_quotes_what_a_shell_would_split(tmp_path):
    changes, plugins = ["plant.mass=7 kg"], [tmp_path / "my file.py"]
    text = replay_command(["hydroservo", "run", NAME], changes, plugins, {"controller.velocity_gain": 60.0})
    assert shlex.split(text) == [
        *("hydroservo", "run", NAME, "--set", "plant.mass=7 kg", "--set", "controller.velocity_gain=60.0"),
        *("--plugin", str(tmp_path / "my file.py")),
    ]


def test_a_replay_takes_the_substeps_of_the_batch():
    changes = ["simulation.substeps=auto", "simulation.duration=5 ms"]
    args = [word for change in changes for word in ("--set", change)]
    text = succeeded("batch", NAME, *args, *VARIED, "--seeds", "--runs", "2", "--metric", "control_rms")
    line = next(line for line in text.splitlines() if line.startswith("Run "))
    again = replayed(line.partition(" To run it alone: ")[2])
    assert again.simulation.substeps >= 1
