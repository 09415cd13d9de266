"""``hydroservo batch``: what is printed and written, and what it says where something is wrong."""

import json
import re
import shlex
import time

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
import xarray as xr
from scipy.io import loadmat

import hydroservo
from hydroservo import simulate
from hydroservo.cli import batch as command_module
from hydroservo.cli.messages import progress_with_rate
from hydroservo.control.metrics import declared_metrics, usual
from hydroservo.runs.batch_finding import batch_finding, remarkable_run
from hydroservo.runs.provenance import provenance, scenario_hash
from hydroservo.runs.trace import metric_attributes
from hydroservo.scenario import load_scenario, parse_override
from tests.support.commands.processes import heavy_libraries_of, leaves_nothing, needs_posix, on_terminal
from tests.support.commands.runner import failed, hydroservo_, succeeded

pytestmark = pytest.mark.nightly  # tests.regression runs each command

NAME = "paper/sine-backstepping"  # whose controller has a model of the machine
NOISY = "sensors={type='NoisySensors', velocity_noise='0.5 mm/s', hydraulic_force_noise='5 N'}"
SHORT = ("--set", "simulation.duration=5 ms", "--set", NOISY)
VARIED = ("--vary", "plant.bulk_modulus=-30%..+30%", "--vary", "controller.velocity_gain=1500..2500")
BATCH = ("batch", NAME, *SHORT, *VARIED, "--seeds")
LOOP = load_scenario(NAME)
METRICS = declared_metrics(usual(LOOP))
FLAGS = ("demand_jumps", "diverged", "stroke_left")
NUMBERS = [name for name in METRICS if name not in FLAGS]


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A strict batch in every format, and how it ended."""
    out = tmp_path_factory.mktemp("batch")
    files = [out / f"runs.{ending}" for ending in ("csv", "parquet", "nc", "mat", "png")]
    options = [word for file in files for word in ("--out", file)]
    return hydroservo_(*BATCH, "--runs", "40", "--strict", *options), out


@pytest.fixture(scope="module")
def said():
    return json.loads(succeeded(*BATCH, "--runs", "40", "--strict", "--json"))


@pytest.fixture(scope="module")
def table(done):
    return pd.read_parquet(done[1] / "runs.parquet")


def test_json_is_one_object_with_the_quantiles_of_the_table(said, table):
    assert list(said) == [
        *(
            "scenario",
            "hash",
            "version",
            "seed",
            "runs",
            "varied",
            "metrics",
            "diverged",
            "stroke_left",
            "oscillating",
            "warnings",
        )
    ]
    loop = load_scenario(NAME, dict(map(parse_override, SHORT[1::2])))
    assert (said["scenario"], said["hash"]) == (NAME, scenario_hash(loop))
    assert (said["version"], said["seed"], said["runs"]) == (hydroservo.__version__, 0, 40)
    assert said["varied"] == {
        "plant.bulk_modulus": pytest.approx([4.9e8, 9.1e8]),
        "controller.velocity_gain": [1500.0, 2500.0],
        "simulation.seed": [0, 39],
    }
    assert list(said["metrics"]) == NUMBERS
    for name, spread in said["metrics"].items():
        worst = table[name].min() if name == "position_min" else table[name].max()
        expected = [*np.quantile(table[name], [0.05, 0.5, 0.95]), worst]
        assert list(spread.values()) == (expected if np.isfinite(worst) else [None] * 4)
    assert said["diverged"] == said["stroke_left"] == 0


def test_each_row_is_the_strict_run_of_its_settings(table):
    others = {name: name for name in ("controller.velocity_gain", "simulation.seed")}
    truth = {"truth.plant.bulk_modulus": "plant.bulk_modulus"}
    deviation = {"uncertainty.plant.bulk_modulus": "uncertainty.plant.bulk_modulus"}
    for i, machine in ((0, truth), (39, truth), (39, deviation)):
        given = {path: table[name][i].item() for path, name in (machine | others).items()}
        changes = dict(map(parse_override, SHORT[1::2])) | given
        single = simulate(load_scenario(NAME, changes), record=(), strict=True)
        for name in METRICS:
            np.testing.assert_array_equal(table[name][i], single[name].item())


def test_the_screen_shows_ranges_spreads_verdict_and_a_replay(done, table):
    text = done[0].stdout
    rows = {line.split()[1]: line.split() for line in text.splitlines() if line.startswith(("│", "|"))}
    assert rows["plant.bulk_modulus"][3:8:2] == ["4900", "9100", "bar"]
    hidden = {"settling_time", "overshoot"}  # a sine does not jump
    assert set(NUMBERS) - set(rows) == {*hidden, "diverged_at"}
    spread = [*np.quantile(table["rms_error"], [0.05, 0.5, 0.95]), table["rms_error"].max()]
    assert rows["rms_error"][3:11:2] == [f"{1e3 * value:.4g}" for value in spread]
    assert rows["rms_error"][11] == "mm/s"
    assert "No run diverged, and no piston left its stroke." in text
    assert re.search(r"s, [\d.,]+ runs per second", done[0].stderr)
    worst = int(table["steady_rms_error"].argmax())
    line = next(line for line in text.splitlines() if line.startswith("Run "))
    start, _, replay = line.partition(" To run it alone: ")
    assert start == f"Run {worst} has the worst steady_rms_error."
    again = json.loads(succeeded(*shlex.split(replay)[1:], "--json"))
    assert again["metrics"]["steady_rms_error"] == table["steady_rms_error"].max()


def test_an_open_loop_is_judged_by_a_metric_that_it_has():
    driven = (
        "controls.type=Command",
        "controller.type=OpenLoop",
        "reference={type='Step', initial=0, final=1}",
    )
    changes = [word for change in driven for word in ("--set", change)]
    open_loop = ("batch", NAME, "--runs", "4", "--vary", "plant.mass=4..8kg", *SHORT, *changes)
    done = hydroservo_(*open_loop)
    assert done.exit_code == 0
    assert (
        f"{NAME}: the loop has no steady_rms_error; position_max is shown, and --metric takes" in done.stderr
    )
    assert re.search(r"^Run \d has the worst position_max\. To run it alone: ", done.stdout, re.MULTILINE)
    assert "steady_rms_error': must be one of control_rms" in failed(
        *open_loop, "--metric", "steady_rms_error"
    )


def test_every_format_holds_the_table(done, table):
    _, out = done
    csv = pd.read_csv(out / "runs.csv")
    assert list(csv.columns[:5]) == [
        *("run", "plant.bulk_modulus [Pa]", "controller.velocity_gain [1/s]"),
        *("simulation.seed", "uncertainty.plant.bulk_modulus"),
    ]
    csv.columns = [name.partition(" [")[0] for name in csv.columns]
    mat = loadmat(out / "runs.mat", simplify_cells=True)
    with xr.open_dataset(out / "runs.nc", engine="scipy") as netcdf:
        for name in table.columns.drop("run"):
            for values in (csv[name], netcdf[name], mat[name.replace(".", "_")]):
                np.testing.assert_array_equal(values, table[name])
        assert netcdf["plant.bulk_modulus"].attrs["units"] == "Pa"
        assert json.loads(netcdf.attrs["varied"])["controller.velocity_gain"] == [1500.0, 2500.0]
    assert table["run"].tolist() == csv["run"].tolist() == mat["run"].tolist() == list(range(40))
    schema = pq.read_schema(out / "runs.parquet")
    assert schema.metadata[b"scenario"] == mat["attributes"]["scenario"].encode()
    assert schema.metadata[b"drawn_with_seed"] == b"0"
    assert b"metrics" not in schema.metadata
    assert mat["units"]["controller_velocity_gain"] == "1/s"
    assert (out / "runs.png").read_bytes().startswith(b"\x89PNG")


def test_the_same_command_says_the_same_and_more_runs_begin_alike(said, table, tmp_path):
    again = json.loads(succeeded(*BATCH, "--runs", "40", "--strict", "--json", "--threads", "1"))
    assert again == said
    succeeded(*BATCH, "--runs", "3", "--strict", "--out", tmp_path / "new" / "few.parquet")
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "new" / "few.parquet"), table[:3])


def test_seeds_alone_vary_the_noise(tmp_path):
    args = ("batch", "paper/sine-pi", *SHORT, "--seeds", "--runs", "9", "--out", tmp_path / "runs.csv")
    text = succeeded(*args, "--out", tmp_path / "runs.svg")
    errors = pd.read_csv(tmp_path / "runs.csv")["rms_error [m/s]"]
    assert errors.nunique() == 9
    assert "simulation.seed" in text
    assert "<svg" in (tmp_path / "runs.svg").read_text()


def made_up(runs=10, lost=(), left=()):
    about = {name: metric_attributes(field) for name, field in METRICS.items()}
    numbers = {name: ("run", np.linspace(1.0, 2.0, runs), about[name]) for name in NUMBERS}
    flags = {"diverged": lost, "stroke_left": left, "demand_jumps": ()}
    masks = {name: ("run", np.isin(np.arange(runs), which), about[name]) for name, which in flags.items()}
    return xr.Dataset(numbers | masks, attrs=provenance(LOOP, LOOP))


def test_runs_that_diverged_are_counted_and_left_out():
    data = made_up(lost=(0, 9), left=(3,))
    data["rms_error"][9] = np.inf
    finding = batch_finding(data, "a[red]")
    assert (finding.numbers["diverged"], finding.numbers["stroke_left"]) == (2, 1)
    assert finding.numbers["metrics"]["rms_error"]["worst"] == data["rms_error"][8]
    assert finding.numbers["metrics"]["position_min"]["worst"] == data["position_min"][1]
    assert remarkable_run(data, "rms_error") == (0, "diverged")
    assert finding.title == "10 runs of a[red]"
    assert list(map(str, finding.lead[:3])) == [
        "2 of 10 runs diverged (20.0 %).",
        "1 of 10 runs left the stroke (10.0 %).",
        "10 of 10 runs oscillated to the end (100 %).",
    ]


def test_a_batch_of_nothing_but_divergence_has_no_quantiles():
    metrics = batch_finding(made_up(lost=range(10))).numbers["metrics"]
    assert all(np.isnan(list(spread.values())).all() for spread in metrics.values())


def test_the_worst_of_a_metric_that_no_run_has():
    data = made_up()
    data["settling_time"][:] = np.nan
    assert remarkable_run(data, "settling_time") == (0, "is the first")
    assert remarkable_run(data, "position_min") == (0, "has the worst position_min")
    assert remarkable_run(data, "rms_error") == (9, "has the worst rms_error")


@pytest.mark.parametrize(
    ("args", "problem"),
    [
        ((), "nothing varies: give --vary PATH=LOW..HIGH, or --seeds, or both"),
        (("--vary", "plant.mass=1..2", "--vary", "plant.mass=2..3"), "--vary: plant.mass: is given twice"),
        (("--seeds", "--runs", "0"), "--runs = 0: must be a whole number from 1 to 10000000"),
        (("--seeds", "--runs", "-3"), "--runs = -3: must be"),
        (("--seeds", "--runs", str(10**30)), "must be a whole number from 1 to 10000000"),
        (("--seeds", "--seed", "-1"), "--seed = -1: must be a whole number from 0 to 9223372036854775807"),
        (("--seeds", "--seed", str(2**63)), "--seed = 9223372036854775808: must be"),
        (("--seeds", "--metric", "rms"), "--metric = 'rms': must be one of rms_error, "),
        (("--seeds", "--metric", "diverged"), "--metric = 'diverged': must be one of"),
        (
            ("--seeds", "--out", "runs.xlsx"),
            "--out = 'runs.xlsx': must end in one of .csv, ",
        ),
        (("--seeds", "--set", "plant.mass=-1"), "plant.mass: -1 must be"),
        (("--seeds", "--set", f"simulation.seed={2**53 - 1}"), "simulation.seed = "),
    ],
)
def test_a_wrong_option_is_one_line(args, problem):
    assert problem in failed("batch", NAME, "--runs", "2", *args)


@pytest.mark.parametrize("args", [("--runs", "many"), ("--threads", "0"), ("--seeds", "1")])
def test_wrong_usage_exits_with_2(args):
    assert "--help)" in failed("batch", NAME, "--runs", "2", *args)


def test_a_folder_that_cannot_be_made_is_said_before_any_run(tmp_path):
    (tmp_path / "file").write_text("old")
    start = time.monotonic()
    message = failed("batch", NAME, "--runs", "100000", "--seeds", "--out", tmp_path / "file" / "runs.csv")
    assert str(tmp_path / "file") in message
    assert time.monotonic() - start < 10.0


def test_a_large_table_is_announced(monkeypatch):
    monkeypatch.setattr(command_module, "LARGE_TABLE", 100)
    result = hydroservo_(*BATCH, "--runs", "2", "--json")
    assert "MiB of memory" in result.stderr
    json.loads(result.stdout)


def test_progress_says_how_many_how_fast_and_how_long(monkeypatch):
    clock, seen = [100.0], []
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    progress = progress_with_rate(lambda fraction, text: seen.append((fraction, text)), 10_000)
    for clock[0], fraction in ((100.0, 0.1), (100.5, 0.2), (104.0, 0.3), (110.0, 1.0)):
        progress(fraction)
    assert seen == [
        (0.1, "1,000 of 10,000 runs"),
        (0.2, "2,000 of 10,000 runs"),
        (0.3, "3,000 of 10,000 runs, 500 per second, 0:14 left"),
        (1.0, "10,000 of 10,000 runs, 900 per second, 0:00 left"),
    ]


@needs_posix
def test_progress_is_shown_on_a_terminal_and_not_on_stdout():
    status, shown, stdout = on_terminal("stderr", *BATCH, "--runs", "40", "--json")
    assert status == 0
    assert json.loads(stdout)["runs"] == 40
    assert "runs" in shown


@needs_posix
def test_ctrl_c_leaves_nothing_half_written(tmp_path):
    out = tmp_path / "out"
    args = ("batch", NAME, *SHORT, *VARIED, "--seeds", "--runs", "200000", "--out", str(out / "runs.csv"))
    leaves_nothing(out, *args, "--set", "simulation.duration=8")


def test_batch_waits_with_heavy_libraries_until_they_are_used():
    assert heavy_libraries_of("hydroservo.cli.batch") == []
