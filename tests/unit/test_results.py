import hashlib
import io
import json
import math
import re

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import loadmat

import hydroservo
from hydroservo import HydroservoError, Simulation
from hydroservo.control.controllers import TSMC
from hydroservo.control.loop import Loop
from hydroservo.control.metrics import declared_metrics, usual
from hydroservo.core.outputs import staged, write_text
from hydroservo.runs.cautions import quietly
from hydroservo.runs.results import (
    FORMATS,
    best_runs,
    matlab_names,
    metric_fields,
    metrics_csv,
    metrics_of,
    save,
    scenario_tables,
    trajectory_of,
)
from hydroservo.show.files import METRICS, as_json, foreign_files, json_value, write_metrics
from hydroservo.testing.examples import example

METRIC_FIELDS = declared_metrics(usual(example(Loop, controller=example(TSMC))))  # that such a run has


@pytest.fixture(scope="module")
def dataset():
    """A short run with an observer; its seed needs 64 bits."""
    simulation = Simulation(duration=0.02, period=1e-4, record_period=1e-3, seed=2**40 + 1)
    loop = example(Loop, simulation=simulation, controller=example(TSMC))
    return quietly(hydroservo.simulate)(loop, compiled=False)  # its samples are too few for its limit cycle


def test_metrics_are_plain_numbers_by_name(dataset):
    metrics = metrics_of(dataset)
    assert list(metrics) == list(METRIC_FIELDS)
    assert {type(value) for value in metrics.values()} == {float, bool}
    assert type(metrics["diverged"]) is bool
    assert metrics["rms_error"] == float(dataset["rms_error"])


def test_trajectory_has_time_first_and_each_recorded_signal(dataset):
    columns = trajectory_of(dataset)
    assert next(iter(columns)) == "time"
    assert len(columns) == 1 + sum(variable.dims == ("time",) for variable in dataset.data_vars.values())
    assert {values.shape for values in columns.values()} == {(21,)}


def test_csv_gives_back_every_bit_under_headers_with_units(dataset, tmp_path):
    path = save(dataset, tmp_path / "run.csv")
    headers = path.read_text().splitlines()[0].split(",")
    assert headers[0] == "time [s]"
    assert {"controller.u [V]", "controller.observer.d2 [N/s]"} < set(headers)
    columns = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
    for (name, values), header, column in zip(trajectory_of(dataset).items(), headers, columns, strict=True):
        assert header.split(" [")[0] == name
        np.testing.assert_array_equal(column, values)


def test_csv_header_of_a_number_without_unit_has_no_brackets(dataset, tmp_path):
    bare = dataset.assign({"controller.ratio": ("time", np.ones(21), {"units": "", "long_name": "ratio"})})
    header = save(bare, tmp_path / "run.csv").read_text().splitlines()[0]
    assert header.endswith(",controller.ratio")


def test_parquet_gives_back_values_units_and_attributes(dataset, tmp_path):
    table = pq.read_table(save(dataset, tmp_path / "run.parquet"))
    for name, values in trajectory_of(dataset).items():
        np.testing.assert_array_equal(table[name].to_numpy(), values)
    assert table.schema.field("controller.u").metadata[b"units"] == b"V"
    assert table.schema.field("time").metadata[b"units"] == b"s"
    about = table.schema.metadata
    assert about[b"scenario"].decode() == dataset.attrs["scenario"]
    assert about[b"hash"].decode() == dataset.attrs["hash"]
    assert int(about[b"seed"]) == dataset.attrs["seed"]
    assert json.loads(about[b"metrics"]) == json_value(metrics_of(dataset))


def test_netcdf_gives_back_the_dataset(dataset, tmp_path):
    with xr.open_dataset(save(dataset, tmp_path / "run.nc"), engine="scipy") as back:
        back.load()
    for name in ("time", *map(str, dataset.data_vars)):
        np.testing.assert_array_equal(back[name].values, dataset[name].values)
        assert back[name].attrs == dataset[name].attrs
    assert back.attrs == {name: str(value) for name, value in dataset.attrs.items()}


def test_mat_gives_back_values_units_and_attributes(dataset, tmp_path):
    back = loadmat(save(dataset, tmp_path / "run.mat"), simplify_cells=True)
    for name, values in trajectory_of(dataset).items():
        np.testing.assert_array_equal(back[name.replace(".", "_")], values)
    assert back["units"]["controller_u"] == "V"
    assert back["units"]["rms_error"] == "m/s"
    assert back["attributes"]["hash"] == dataset.attrs["hash"]
    assert back["attributes"]["seed"] == dataset.attrs["seed"]
    assert back["metrics"]["rms_error"] == float(dataset["rms_error"])
    assert not back["metrics"]["diverged"]


def test_a_diverged_run_is_saved_in_every_format(dataset, tmp_path):
    lost = dataset.copy(deep=True)
    lost["plant.velocity"][5:] = math.nan
    lost["rms_error"] = ((), math.nan, dataset["rms_error"].attrs)
    for ending in FORMATS:
        save(lost, tmp_path / f"run{ending}")
    column = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1, usecols=1)
    np.testing.assert_array_equal(np.isnan(column), np.arange(21) >= 5)
    about = pq.read_table(tmp_path / "run.parquet").schema.metadata
    assert json.loads(about[b"metrics"])["rms_error"] is None


def test_unknown_ending_names_those_there_are(dataset, tmp_path):
    with pytest.raises(HydroservoError, match=rf"\.xlsx.*{re.escape(', '.join(FORMATS))}"):
        save(dataset, tmp_path / "run.xlsx")
    assert list(tmp_path.iterdir()) == []


def test_ending_in_capitals_is_understood(dataset, tmp_path):
    assert save(dataset, tmp_path / "RUN.CSV").read_text().startswith("time [s],")


def result(folder, mark):
    """A folder of results, every file of which says whose it is."""
    with staged(folder, last=METRICS) as stage:
        for name in ("run.png", "below/trajectory.csv"):
            write_text(stage / name, mark)
        write_metrics(stage, {"hash": mark, "lost": math.nan})


def test_metrics_json_names_every_file_of_its_result(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    result(tmp_path, "a")
    said = json.loads((tmp_path / METRICS).read_text())
    digest = hashlib.sha256(b"a").hexdigest()
    assert said == {
        "hash": "a",
        "lost": None,
        "files": dict.fromkeys(("below/trajectory.csv", "run.png"), digest),
    }
    assert foreign_files(tmp_path) == []


def test_files_of_another_result_are_named(tmp_path):
    result(tmp_path / "one", "a")
    result(tmp_path / "other", "b")
    (tmp_path / "other" / "run.png").replace(tmp_path / "one" / "run.png")
    assert foreign_files(tmp_path / "one") == ["run.png"]
    assert foreign_files(tmp_path / "other") == ["run.png"]
    (tmp_path / "one" / "below" / "trajectory.csv").write_text("changed")
    assert foreign_files(tmp_path / "one") == ["below/trajectory.csv", "run.png"]


@pytest.mark.parametrize("text", [None, "", "{}", "[]", '{"files": 1}', "\0"])
def test_a_folder_without_a_result_is_an_error(tmp_path, text):
    if text is not None:
        (tmp_path / METRICS).write_text(text)
    with pytest.raises(HydroservoError, match=r"metrics\.json: cannot be read"):
        foreign_files(tmp_path)


def test_json_has_null_for_what_is_not_finite_and_keeps_everything_else():
    given = {"a": [1, 2.5, math.nan, True], "b": {"c": -math.inf, "d": "nan"}, "e": None}
    expected = {"a": [1, 2.5, None, True], "b": {"c": None, "d": "nan"}, "e": None}
    assert json_value(given) == expected
    assert json.loads(as_json(given)) == expected


def test_the_scenario_of_a_run_is_its_loop_as_tables(dataset):
    scenario = scenario_tables(dataset)
    assert scenario["controller"]["type"] == "TSMC"
    assert scenario["simulation"]["period"] == 1e-4


def test_metrics_csv_has_a_row_for_each_run_and_units_in_its_headers(dataset):
    runs = [{"scenario": name, **metrics_of(dataset), "max_error": math.inf} for name in ("a,b", "c")]
    text = metrics_csv(pd.DataFrame(runs), metric_fields(dataset))
    table = pd.read_csv(io.StringIO(text), index_col="scenario", dtype=str)
    assert list(table.index) == ["a,b", "c"]
    assert float(table.loc["c", "rms_error [m/s]"]) == float(dataset["rms_error"])
    assert float(table.loc["c", "max_error [m/s]"]) == math.inf
    assert table["diverged"].tolist() == ["0", "0"]
    assert [column.split(" [")[0] for column in table.columns] == list(METRIC_FIELDS)


def metrics(**changes):
    return dict.fromkeys(METRIC_FIELDS, 1.0) | {"diverged": False, "stroke_left": False} | changes


@pytest.mark.parametrize(
    ("values", "best"),
    [
        ([1.0, 2.0], {0}),
        ([2.0, 1.0, 1.0], {1, 2}),
        ([1.0, 1.0], set()),
        ([math.nan, 1.0], set()),
        ([math.nan, 2.0, 1.0], {2}),
        ([1.0], set()),
        ([], set()),
    ],
)
def test_best_is_the_smallest_of_several_numbers(values, best):
    assert best_runs([metrics(rms_error=value) for value in values], "rms_error") == best


def test_a_diverged_run_is_never_best():
    runs = [metrics(control_rms=0.1, diverged=True), metrics(control_rms=1.0), metrics(control_rms=2.0)]
    assert best_runs(runs, "control_rms") == {1}


def test_a_run_without_the_metric_is_never_best():
    runs = [metrics(), metrics(rise_time=2.0), metrics(rise_time=1.0)]
    assert best_runs(runs, "rise_time") == {2}


def test_what_metrics_are_declared_as_is_in_their_variables(dataset):
    fields = metric_fields(dataset)
    assert fields == METRIC_FIELDS
    assert fields["rms_error"].smaller_is_better
    assert not fields["position_max"].smaller_is_better  # where the piston was is neither good nor bad
    assert fields["position_min"].least_is_worst
    assert fields["control_rms"].unit == "V"


@given(st.lists(st.text(min_size=1, max_size=80), unique=True, max_size=8))
def test_matlab_names_are_legal_and_distinct(paths):
    names = matlab_names(paths)
    assert list(names) == paths
    assert len(set(names.values())) == len(paths)
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,62}", name) for name in names.values())


def test_matlab_names_of_paths_that_differ_only_in_dots_stay_apart():
    assert matlab_names(["a.b_c", "a_b.c", "a.b.c"]) == {
        "a.b_c": "a_b_c",
        "a_b.c": "a_b_c_2",
        "a.b.c": "a_b_c_3",
    }
