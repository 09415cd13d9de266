"""Results read by pandas, Polars and DuckDB as they are: in memory, and in the folder of a batch."""

from pathlib import Path

import duckdb
import numpy as np
import polars as pl
import pytest

import hydroservo as hs
from hydroservo.scenario import assemble
from hydroservo.scenario.parameter_draws import variations
from hydroservo.scenario.ranges import as_entries
from hydroservo.scenario.stored_batch import SampledBatch, simulate_in_parts

SHORT = {"simulation.period": "0.1 ms", "simulation.duration": "5 ms"}
RUNS = 300


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a batch."""
    found = tmp_path_factory.mktemp("frames") / "runs"
    scenario = assemble("paper/sine-pi", SHORT)
    varied = variations(scenario, as_entries({"plant.mass": "4..8kg"}))
    what = SampledBatch(scenario, varied, seed=0, seeds=False, strict=False, cuda=False)
    simulate_in_parts(what, RUNS, found)
    return found


@pytest.fixture(scope="module")
def wanted() -> np.ndarray:
    """The errors of its runs, as a batch in memory has them."""
    loop = assemble("paper/sine-pi", SHORT)
    drawn = hs.draws(loop, {"plant.mass": "4..8kg"}, runs=RUNS)
    return hs.simulate_batch(loop.loop, drawn.parameters)["rms_error"].to_numpy()


def test_polars_scans_the_folder_of_a_batch(folder: Path, wanted: np.ndarray) -> None:
    table = pl.scan_parquet(folder / "parts" / "*.parquet").sort("run").select("run", "rms_error").collect()
    assert table["run"].to_list() == list(range(RUNS))
    assert np.array_equal(table["rms_error"].to_numpy(), wanted)


def test_duckdb_asks_the_folder_of_a_batch(folder: Path, wanted: np.ndarray) -> None:
    found = duckdb.read_parquet(f"{folder}/parts/*.parquet").order("run").fetchnumpy()
    assert np.array_equal(found["rms_error"], wanted)


def test_tables_in_memory_go_through_pandas() -> None:
    loop = hs.load_scenario("paper/sine-pi", SHORT)
    table = hs.simulate_batch(loop, {"plant.mass": [5.0, 6.0, 7.0]})
    frame = table.to_dataframe()
    assert np.array_equal(pl.from_pandas(frame)["rms_error"].to_numpy(), table["rms_error"].to_numpy())
    assert duckdb.sql("SELECT max(rms_error) FROM frame").fetchall() == [(float(table["rms_error"].max()),)]
    run = hs.simulate(loop)
    signals = run.drop_vars([name for name in run if run[name].dims == ()]).to_dataframe().reset_index()
    assert np.array_equal(
        pl.from_pandas(signals)["plant.velocity"].to_numpy(), run["plant.velocity"].to_numpy()
    )
