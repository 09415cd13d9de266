"""``hydroservo batch``: what is drawn, how it is replayed, what is printed and written."""

import json
import re
import shlex
import signal
import subprocess
import time

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import loadmat
from test_cli import failed, hydroservo_, succeeded
from test_cli_process import HYDROSERVO, needs_posix, on_terminal

import hydroservo
from hydroservo import Loop, ScenarioError, simulate
from hydroservo.block import replace
from hydroservo.cli import batch as command_module
from hydroservo.cli.batch_summary import batch_summary, remarkable_run, show_batch
from hydroservo.cli.replay import Origin, command
from hydroservo.cli.variations import drawn_runs, variations
from hydroservo.metrics import METRIC_FIELDS
from hydroservo.provenance import scenario_hash
from hydroservo.scenario import load_scenario, parse_override

NAME = "paper/sine-backstepping"  # whose controller has a model of the machine
SHORT = ("--set", "simulation.duration=5 ms", "--set", "sensors.type=NoisySensors")
VARIED = ("--vary", "plant.bulk_modulus=-30%..+30%", "--vary", "controller.velocity_gain=1500..2500")
BATCH = ("batch", NAME, *SHORT, *VARIED, "--seeds")
NUMBERS = [name for name in METRIC_FIELDS if name not in ("diverged", "stroke_left")]


# --- what is drawn


def drawn(*ranges, changes=(), seed=0, runs=50, seeds=False, name=NAME):
    origin = Origin(name, changes, ())
    loop = origin.loop({})
    return loop, drawn_runs(loop, variations(ranges, loop, origin.nominal()), seed, runs, seeds=seeds)


@given(seed=st.integers(0, 2**63 - 1), few=st.integers(1, 20), more=st.integers(20, 60))
def test_a_run_has_the_same_parameters_whatever_their_number_and_whatever_else_varies(seed, few, more):
    mass, area = "plant.mass=4..8kg", "plant.piston_area=-10..10%"
    _, one = drawn(mass, seed=seed, runs=few)
    _, other = drawn(area, mass, seed=seed, runs=more, seeds=True)
    for path in one.parameters:
        np.testing.assert_array_equal(one.parameters[path], other.parameters[path][:few])
    for path in one.settings:
        np.testing.assert_array_equal(one.settings[path], other.settings[path][:few])


def test_another_seed_and_another_path_draw_other_numbers():
    _, one = drawn("plant.mass=1..2", "controller.velocity_gain=1..2", runs=1000)
    _, other = drawn("plant.mass=1..2", seed=1, runs=1000)
    mass, gain = one.parameters["plant.mass"], one.parameters["controller.velocity_gain"]
    assert abs(np.corrcoef(mass, gain)[0, 1]) < 0.1
    assert abs(np.corrcoef(mass, other.parameters["plant.mass"])[0, 1]) < 0.1


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("plant.bulk_modulus=0.5e9 Pa..1.5e9 Pa", 0.5e9, 1.5e9),
        ("plant.bulk_modulus=0.5..1.5 GPa", 0.5e9, 1.5e9),
        ("plant.bulk_modulus=5000 bar .. 1.5 GPa", 0.5e9, 1.5e9),
        ("plant.bulk_modulus=5e8..1.5e9", 0.5e9, 1.5e9),
        ("plant.bulk_modulus=-30%..+30%", 4.9e8, 9.1e8),
        ("plant.bulk_modulus = -30 .. 30 %", 4.9e8, 9.1e8),
        ("plant.bulk_modulus=\N{MINUS SIGN}30..30%", 4.9e8, 9.1e8),
        ("valve.orifice.discharge_coefficient=1/2..5/7", 0.5, 5 / 7),
        ("load.offset=-50..50N", -50.0, 50.0),
        ("load.phase=-.5...5", -0.5, 0.5),
        ("controller.velocity_gain=1e2..2e2 1/s", 100.0, 200.0),
    ],
)
def test_numbers_are_spread_evenly_over_the_range(text, low, high):
    _, found = drawn(text, runs=4000)
    (path,) = found.ranges
    assert found.ranges[path] == pytest.approx((low, high), rel=1e-12)
    share = (np.sort(found.parameters[path]) - low) / (high - low)
    assert np.max(np.abs(share - (np.arange(4000) + 0.5) / 4000)) < 0.03  # Kolmogorov-Smirnov, p below 0.002


def test_percentages_of_a_negative_number_span_it():
    _, found = drawn("load.amplitude=-10..20%", changes=["load.amplitude=-100N"])
    assert found.ranges["load.amplitude"] == pytest.approx((-120.0, -90.0))
    assert np.all(
        (found.parameters["load.amplitude"] > -120.0) & (found.parameters["load.amplitude"] < -90.0)
    )


def test_seeds_count_from_that_of_the_scenario():
    _, found = drawn(changes=["simulation.seed=7"], runs=3, seeds=True)
    assert found.settings["simulation.seed"].tolist() == [7, 8, 9]
    assert found.ranges == {"simulation.seed": (7, 9)}


def test_only_the_truth_of_the_machine_varies():
    loop, found = drawn("plant.mass=4..8kg")
    assert list(found.parameters) == ["plant.mass"]
    assert list(found.settings) == ["uncertainty.plant.mass"]
    assert loop.nominal is loop.controller.model


def test_disturbances_are_defined_against_the_model_that_varies():
    _, found = drawn("controller.model.plant.mass=4..8kg")
    assert list(found.settings) == ["controller.model.plant.mass"]
    assert list(found.parameters) == ["controller.model.plant.mass", "nominal.plant.mass"]


# --- replays


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


def test_no_replay_is_offered_where_the_nominal_model_would_follow():
    changes = ["plant.leakage=0"]
    _, found = drawn("plant.leakage=0..1e-11", changes=changes, name="paper/sine-pi")
    assert command(Origin("paper/sine-pi", changes, ()), *found.of_run(0)) is None


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


# --- the command


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A strict batch in every format, and what it printed."""
    out = tmp_path_factory.mktemp("batch")
    files = [out / f"runs.{ending}" for ending in ("csv", "parquet", "nc", "mat", "png")]
    options = [word for file in files for word in ("--out", file)]
    return succeeded(*BATCH, "--runs", "40", "--strict", *options), out


@pytest.fixture(scope="module")
def said():
    return json.loads(succeeded(*BATCH, "--runs", "40", "--strict", "--json"))


@pytest.fixture(scope="module")
def table(done):
    return pd.read_parquet(done[1] / "runs.parquet")


def test_json_is_one_object_with_the_quantiles_of_the_table(said, table):
    assert list(said) == [
        *("scenario", "hash", "version", "seed", "runs", "varied", "metrics", "diverged", "stroke_left")
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
    settings = ["uncertainty.plant.bulk_modulus", "controller.velocity_gain", "simulation.seed"]
    for i in (0, 39):
        changes = dict(map(parse_override, SHORT[1::2])) | {name: table[name][i].item() for name in settings}
        single = simulate(load_scenario(NAME, changes), record=(), strict=True)
        for name in METRIC_FIELDS:
            np.testing.assert_array_equal(table[name][i], single[name].item())


def test_the_screen_shows_ranges_spreads_verdict_and_a_replay(done, table):
    text = done[0]
    rows = {line.split()[1]: line.split() for line in text.splitlines() if line.startswith(("│", "|"))}
    assert rows["plant.bulk_modulus"][3:8:2] == ["4900", "9100", "bar"]
    assert set(NUMBERS) <= set(rows)
    spread = [*np.quantile(table["rms_error"], [0.05, 0.5, 0.95]), table["rms_error"].max()]
    assert rows["rms_error"][3:11:2] == [f"{1e3 * value:.4g}" for value in spread]
    assert rows["rms_error"][11] == "mm/s"
    assert "No run diverged, and no piston left its stroke." in text
    assert re.search(r"s, [\d.,]+ runs per second", text)
    worst = int(table["steady_rms_error"].argmax())
    line = next(line for line in text.splitlines() if line.startswith("run "))
    start, _, replay = line.partition("; alone: ")
    assert start == f"run {worst} has the worst steady_rms_error"
    again = json.loads(succeeded(*shlex.split(replay)[1:], "--json"))
    assert again["metrics"]["steady_rms_error"] == table["steady_rms_error"].max()


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


# --- what it says of runs that fail


def made_up(runs=10, lost=(), left=()):
    numbers = {name: ("run", np.linspace(1.0, 2.0, runs)) for name in NUMBERS}
    flags = {"diverged": lost, "stroke_left": left}
    masks = {name: ("run", np.isin(np.arange(runs), which)) for name, which in flags.items()}
    return xr.Dataset(numbers | masks, attrs={"hash": "abc", "version": "1"})


def test_runs_that_diverged_are_counted_and_left_out(capsys):
    data = made_up(lost=(0, 9), left=(3,))
    data["rms_error"][9] = np.inf
    summary = batch_summary("a[red]", 5, data, {})
    assert (summary.diverged, summary.stroke_left) == (2, 1)
    assert summary.metrics["rms_error"].worst == data["rms_error"][8]
    assert summary.metrics["position_min"].worst == data["position_min"][1]
    assert remarkable_run(data, "rms_error") == (0, "diverged")
    show_batch(summary, data, 4.0)
    text = capsys.readouterr().out
    assert "a[red]" in text
    assert "DIVERGED: 2 of 10 runs (20 %): " in text
    assert "LEFT THE STROKE: 1 of 10 runs (10 %)." in text
    assert "4 s, 2.5 runs per second" in text


def test_a_batch_of_nothing_but_divergence_has_no_quantiles():
    summary = batch_summary("a", 0, made_up(lost=range(10)), {})
    assert all(np.isnan(list(spread)).all() for spread in summary.metrics.values())


def test_the_worst_of_a_metric_that_no_run_has():
    data = made_up()
    data["estimate_rms_error_1"][:] = np.nan
    assert remarkable_run(data, "estimate_rms_error_1") == (0, "is the first")
    assert remarkable_run(data, "position_min") == (0, "has the worst position_min")
    assert remarkable_run(data, "rms_error") == (9, "has the worst rms_error")


# --- what goes wrong


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("plant.mss=1..2", "plant.mss: must be one of plant.mass, plant.damping, "),
        ("plant.mss=1..2", "; did you mean plant.mass?"),
        ("plnt.mass=1..2", "plnt.mass: is no number that can vary; did you mean plant.mass?"),
        ("mass=1..2", "mass: is no number that can vary"),
        ("nominal.plant.mass=1..2", "is no number that can vary; did you mean "),
        ("plant=1..2", "plant: is no number that can vary"),
        ("plant.as_printed=0..1", "plant.as_printed: must be one of plant.mass"),
        ("simulation.period=1..2", "simulation.period: is no number that can vary"),
        ("simulation.seed=1..2", "simulation.seed: is varied by --seeds"),
        ("plant.mass", "'plant.mass' must be of the form PATH=LOW..HIGH"),
        ("plant.mass=4", "'plant.mass=4' must be of the form PATH=LOW..HIGH"),
        ("=1..2", "must be of the form PATH=LOW..HIGH"),
        (
            "plant.mass=8..4kg",
            "'8 kg' is more than '4kg', its upper end; it must be a finite number above 0 [kg]",
        ),
        ("plant.mass=30%..-30%", "'30%' is more than '-30%', its upper end"),
        ("plant.mass=4..4", "'4..4' is no range: both its ends are 4"),
        ("plant.mass=4m..8m", "plant.mass: '4m' does not convert to kg; it must be"),
        ("plant.mass=4kg..8", "'8' has no unit; write '8 kg'"),
        ("plant.mass=4..heavy", "'heavy' is not a quantity"),
        ("plant.mass=..8", "'' is not a quantity"),
        ("plant.mass=nan..8", "'nan' is not a quantity"),
        ("plant.mass=0..8kg", "'0..8kg' reaches 0; it must be a finite number above 0 [kg]"),
        ("plant.mass=-150%..0%", "reaches -3; it must be a finite number above 0 [kg]"),
        ("plant.mass=-30%..8", "'8' has no % while '-30%' has one"),
        ("plant.mass=-30%..8kg", "'8kg' has no % while '-30%' has one"),
        ("load.offset=-30%..30%", "is 0 in the scenario, of which there is no percentage"),
        ("plant.mass=1..2\n", "plant.mass"),
        ("plant.mass=1..2 k\ng", "plant.mass: "),
        ("plant.mass=" + "1" * 5000 + "..2", "must be of the form"),
    ],
)
def test_a_wrong_range_is_one_line_that_names_it(text, problem):
    if text == "plant.mass=1..2\n":
        assert drawn(text)[1].ranges == {"plant.mass": (1.0, 2.0)}
        return
    message = failed("batch", NAME, "--runs", "2", "--vary", text)
    assert message.startswith("hydroservo: --vary: ")
    assert problem in message
    assert message.rstrip("\n").isprintable()


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
            "runs.xlsx: the ending '.xlsx' names no format; use one of .csv, ",
        ),
        (("--seeds", "--out", "runs"), "runs: the ending '' names no format"),
        (("--seeds", "--set", "plant.mass=-1"), "plant.mass: -1 must be"),
        (("--seeds", "--set", f"simulation.seed={2**53 - 1}"), "simulation.seed = "),
    ],
)
def test_a_wrong_option_is_one_line(args, problem):
    assert problem in failed("batch", NAME, "--runs", "2", *args)


@given(text=st.text(max_size=20) | st.text("0123456789.%-+ kgPa", max_size=12).map("plant.mass={}".format))
def test_any_range_is_drawn_from_or_refused_in_one_line(text):
    loop = load_scenario(NAME)
    try:
        (found,) = variations([text], loop, loop)
    except ScenarioError as error:
        found = str(error)
    assert found.isprintable() if isinstance(found, str) else 0.0 < found.low < found.high


@pytest.mark.parametrize("args", [("--runs", "many"), ("--threads", "0"), ("--seeds", "1")])
def test_wrong_usage_exits_with_2(args):
    result = hydroservo_("batch", NAME, "--runs", "2", *args)
    assert result.exit_code == 2
    assert "Usage" in result.stderr


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


# --- progress and interrupts


def test_progress_says_how_many_how_fast_and_how_long(monkeypatch):
    clock, seen = [100.0], []
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    progress = command_module.paced(lambda fraction, text: seen.append((fraction, text)), 10_000)
    for clock[0], fraction in ((100.0, 0.1), (100.5, 0.2), (104.0, 0.3), (110.0, 1.0)):
        progress(fraction)
    assert seen == [
        (0.1, "1,000 of 10,000 runs"),
        (0.2, "2,000 of 10,000 runs"),
        (0.3, "3,000 of 10,000 runs, 500 a second, 0:14 left"),
        (1.0, "10,000 of 10,000 runs, 900 a second, 0:00 left"),
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
    running = subprocess.Popen(
        [*HYDROSERVO, *args, "--set", "simulation.duration=8"],
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    with running:
        deadline = time.monotonic() + 60.0
        while not out.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        time.sleep(2.0)
        running.send_signal(signal.SIGINT)
        try:
            stdout, stderr = running.communicate(timeout=60)
        finally:
            running.kill()
    assert running.returncode == 130
    assert stdout == ""
    assert stderr == "hydroservo: interrupted; nothing was left half-written\n"
    assert list(out.iterdir()) == []


def test_batch_waits_with_heavy_libraries_until_they_are_used():
    heavy = "{'matplotlib', 'xarray', 'pandas', 'numba', 'scipy', 'pint', 'rich'}"
    code = f"import sys, hydroservo.cli.batch; print(*sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([HYDROSERVO[0], "-c", code], text=True, capture_output=True, check=True)
    assert done.stdout.split() in ([], ["rich"])  # which typer may load
