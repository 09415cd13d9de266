import numpy as np
import pytest

from hydroservo import simulate
from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.identification.log import log_of_arrays, read_log
from hydroservo.identification.segments import noise_of, resolution_of, spikes_in, understand_log
from hydroservo.runs.results import save
from hydroservo.scenario import load_scenario

HEADER = "time [s],command [V],velocity [mm/s],hydraulic_force [kN]"
ROWS = [f"{0.001 * k:.3f},{k % 7},{k % 5},{k % 3}" for k in range(40)]


@pytest.fixture
def write(tmp_path):
    def written(*lines, name="log.csv"):
        path = tmp_path / name
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return path

    return written


def test_header_names_signals_and_units(write):
    log = read_log(write(HEADER, *ROWS), {})
    assert log.time[3] == pytest.approx(0.003)
    assert log.signals["velocity"][4] == pytest.approx(0.004)
    assert log.signals["hydraulic_force"][2] == pytest.approx(2000.0)


def test_mapping_names_columns_and_units(write):
    lines = ["t;u;v_piston [cm/s];junk", *(row.replace(",", ";") for row in ROWS)]
    mapping = {"time": "t [s]", "command": "u [V]", "velocity": "v_piston"}
    log = read_log(write(*lines), mapping)
    assert log.signals["velocity"][4] == pytest.approx(0.04)
    assert log.unused == ["junk"]


@pytest.mark.parametrize("ending", ["parquet", "mat", "nc"])
def test_binary_formats_give_what_text_does(tmp_path, ending, write):
    import xarray as xr

    from hydroservo.identification.log import SIGNALS
    from hydroservo.runs.results import FORMATS

    text = read_log(write(HEADER, *ROWS), {})
    rows = {name: ("time", values, {"units": SIGNALS[name].unit}) for name, values in text.signals.items()}
    data = xr.Dataset(rows, coords={"time": ("time", text.time, {"units": "s"})})
    path = tmp_path / f"log.{ending}"
    FORMATS[f".{ending}"].write(data, path)
    log = read_log(path, {})
    np.testing.assert_array_equal(log.time, text.time)
    for name, values in text.signals.items():
        np.testing.assert_array_equal(log.signals[name], values)


def test_mdf_gives_what_was_written(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    time = 0.001 * np.arange(50)
    signals = [
        asammdf.Signal(np.sin(time), time, name="command", unit="V"),
        asammdf.Signal(np.cos(time), time, name="velocity", unit="m/s"),
    ]
    with asammdf.MDF(version="4.10") as file:
        file.append(signals)
        path = file.save(tmp_path / "log.mf4")
    log = read_log(path, {})
    np.testing.assert_allclose(log.time, time)
    np.testing.assert_array_equal(log.signals["velocity"], np.cos(time))


def test_signals_of_an_mdf_file_stay_at_their_own_instants(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    time = 0.001 * np.arange(50)
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(np.sin(time), time, name="command", unit="V")])
        file.append([asammdf.Signal(np.cos(time[::2]), time[::2], name="velocity", unit="m/s")])
        path = file.save(tmp_path / "log.mf4")
    found = understand_log(read_log(path, {}))
    velocity = found.segments[0].measured["velocity"]
    np.testing.assert_array_equal(velocity[::2], np.cos(time[::2]))
    assert np.isnan(velocity[1::2]).all()
    assert "velocity: 25 samples missing, and count for nothing" in found.remarks


def test_a_file_without_lines_is_refused_without_one(tmp_path):
    from scipy.io import savemat

    path = tmp_path / "log.mat"
    savemat(path, {name: np.arange(20.0) for name in ("time", "command", "velocity")})
    with pytest.raises(ScenarioError) as caught:
        read_log(path, {})
    assert "log.mat: column 'time' has no unit; write [identify.columns] time = \"time [s]\"" in str(
        caught.value
    )
    units = {"time": "time [s]", "command": "command [V]", "velocity": "velocity [mm/s]"}
    assert read_log(path, units).signals["velocity"][1] == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (["time [s],velocity [m/s]", *["1,2"] * 3], 'line 1: column "command [V]" is missing'),
        (["time [s],command [V],flow [V]", *["1,2,3"] * 3], "no column of anything measured"),
        ([HEADER.replace("mm/s", "bar"), *ROWS], "column 'velocity [bar]' does not convert to m/s"),
        ([HEADER.replace(" [mm/s]", ""), *ROWS], "column 'velocity' has no unit"),
        (
            [HEADER, *ROWS[:20], "0.020,x,1,1", *ROWS[21:]],
            "line 22, column command [V]: 'x' must be a finite",
        ),
        ([HEADER, *ROWS[:20], ROWS[5], *ROWS[20:]], "line 22, column time [s]: '0.005' is not after"),
        ([HEADER, *ROWS[:9]], "too few samples to tell anything, 9"),
        (["0,1,2,3", *ROWS], "line 1: must name the columns"),
        ([HEADER + ",command [V]", *(row + ",1" for row in ROWS)], "column 'command' appears more than once"),
    ],
)
def test_wrong_logs_are_refused_in_one_line(write, lines, said):
    with pytest.raises(ScenarioError) as caught:
        read_log(write(*lines), {})
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_arrays_must_be_signals():
    time = np.arange(20.0)
    with pytest.raises(ParameterError, match="is not a signal"):
        log_of_arrays({"time": time, "command": time, "speed": time}, "log")
    with pytest.raises(ParameterError, match="must increase"):
        log_of_arrays({"time": -time, "command": time, "velocity": time}, "log")


def signals(**changes):
    time = 0.001 * np.arange(400)
    rng = np.random.default_rng(0)
    own = {
        "time": time,
        "command": np.sin(40.0 * time),
        "velocity": np.cos(40.0 * time) + 1e-3 * rng.normal(size=400),
    }
    return log_of_arrays(own | changes, "log")


def test_what_is_measured_is_taken_as_it_is_where_nothing_is_wrong():
    found = understand_log(signals())
    (segment,) = found.segments
    assert found.remarks == []
    assert segment.period == pytest.approx(0.001)
    np.testing.assert_array_equal(segment.measured["velocity"], found.log.signals["velocity"])


def test_outliers_count_for_nothing_and_are_said():
    velocity = signals().signals["velocity"].copy()
    velocity[[50, 200, 201]] += 3.0
    found = understand_log(signals(velocity=velocity))
    assert np.flatnonzero(np.isnan(found.segments[0].measured["velocity"])).tolist() == [50, 200, 201]
    assert "velocity: 3 samples out of line, and count for nothing" in found.remarks


def test_a_command_is_played_as_it_is():
    command = signals().signals["command"].copy()
    command[70] = 9.0
    found = understand_log(signals(command=command))
    assert found.segments[0].inputs["command"][70] == 9.0
    assert "command: 1 sample out of line; they are played as recorded" in found.remarks


def test_samples_that_lack_are_bridged_and_gaps_split():
    log = signals()
    keep = np.ones(400, dtype=bool)
    keep[100:103] = keep[200:300] = False
    rows = {name: values[keep] for name, values in log.signals.items()}
    found = understand_log(log_of_arrays({"time": log.time[keep], **rows}, "log"))
    assert [one.samples for one in found.segments] == [200, 100]
    assert np.flatnonzero(np.isnan(found.segments[0].measured["velocity"])).tolist() == [100, 101, 102]
    assert np.isfinite(found.segments[0].inputs["command"]).all()
    assert any("split it into 2 stretches" in line for line in found.remarks)


def test_uneven_instants_are_moved_onto_a_grid():
    log = signals()
    rng = np.random.default_rng(1)
    time = log.time + 2e-4 * rng.uniform(-1.0, 1.0, 400)
    rows = {"command": np.sin(40.0 * time), "velocity": np.cos(40.0 * time)}
    found = understand_log(log_of_arrays({"time": time, **rows}, "log"))
    (segment,) = found.segments
    np.testing.assert_allclose(segment.measured["velocity"], np.cos(40.0 * segment.time), atol=1e-3)
    assert any("instants are uneven" in line for line in found.remarks)


def test_samples_that_lack_among_uneven_instants_stay_missing():
    log = signals()
    time = log.time + 4e-5 * np.random.default_rng(1).uniform(-1.0, 1.0, 400)
    velocity = np.cos(40.0 * time)
    velocity[100:103] = np.nan
    found = understand_log(log_of_arrays({"time": time, "command": time, "velocity": velocity}, "log"))
    assert np.flatnonzero(np.isnan(found.segments[0].measured["velocity"])).tolist() == [100, 101, 102]


@pytest.mark.parametrize(("late", "parts"), [(0.5e-3, 2), (0.7e-3, 10), (0.25e-3, 4)])
def test_signals_at_instants_of_their_own_count_there(late, parts):
    """The command is held, not joined by lines, and no sample is moved or counted twice."""
    commanded, measured = 0.001 * np.arange(200), 0.002 * np.arange(100) + late
    time = np.sort(np.concatenate([commanded, measured]))
    own = np.isin(time, commanded)
    rows = {"command": np.where(own, np.sin(40.0 * time), np.nan)}
    rows["velocity"] = np.where(own, np.nan, np.cos(40.0 * time))
    (segment,) = understand_log(log_of_arrays({"time": time, **rows}, "log")).segments
    assert segment.period == pytest.approx(0.001 / parts)
    there = np.isfinite(segment.measured["velocity"])
    assert there.sum() == 100
    np.testing.assert_allclose(segment.time[there], measured, atol=1e-9)
    np.testing.assert_allclose(segment.measured["velocity"][there], np.cos(40.0 * measured), rtol=1e-9)
    held = np.repeat(np.sin(40.0 * commanded), parts)[: segment.samples]
    np.testing.assert_array_equal(segment.inputs["command"], held)


@pytest.mark.parametrize("every", [25, 7])
def test_a_command_that_is_logged_more_rarely_is_held(every):
    """And a measured signal keeps each of its samples, at its own instant."""
    time = 0.001 * np.arange(400)
    command = np.where(np.arange(400) % every == 0, np.sin(5.0 * time), np.nan)
    log = log_of_arrays({"time": time, "command": command, "velocity": np.cos(40.0 * time)}, "log")
    (segment,) = understand_log(log).segments
    np.testing.assert_allclose(segment.time, time, atol=1e-12)
    np.testing.assert_array_equal(segment.measured["velocity"], np.cos(40.0 * time))
    np.testing.assert_array_equal(segment.inputs["command"], command[np.arange(400) // every * every])


def test_a_gap_in_a_command_of_its_own_instants_splits_the_log():
    commanded = 0.001 * np.arange(400)
    commanded = commanded[(commanded < 0.1) | (commanded > 0.3)]
    time = np.sort(np.concatenate([commanded, commanded + 5e-4]))
    own = np.isin(time, commanded)
    rows = {"command": np.where(own, np.sin(40.0 * time), np.nan)}
    rows["velocity"] = np.where(own, np.nan, np.cos(40.0 * time))
    assert len(understand_log(log_of_arrays({"time": time, **rows}, "log")).segments) == 2


def test_what_never_changes_is_left_out_or_refused():
    found = understand_log(signals(position=np.full(400, 0.1)))
    assert "position" not in found.segments[0].measured
    assert "position never changes: it says nothing and is left out" in found.remarks
    with pytest.raises(ScenarioError, match="velocity: never changes"):
        understand_log(signals(velocity=np.zeros(400)))


def test_what_has_no_samples_is_told_from_what_never_changes():
    found = understand_log(signals(pressure_a=np.full(400, np.nan), external_force=np.zeros(400)))
    assert found.remarks == ["pressure_a has no samples: it says nothing and is left out"]
    assert not found.segments[0].inputs["external_force"].any()


def test_of_many_columns_that_are_not_used_some_are_named(write):
    more = [f"more_{i}" for i in range(8)]
    lines = [",".join([HEADER, *more]), *(",".join([row, *"12345678"]) for row in ROWS)]
    remarks = understand_log(read_log(write(*lines), {})).remarks
    assert "columns that are not used: more_0, more_1, more_2, more_3, more_4 and 3 more" in remarks


@pytest.mark.parametrize("name", ["paper/sine-pi", "axis/position"])
def test_the_trajectory_of_a_run_is_a_log(name, tmp_path):
    run = simulate(load_scenario(name, {"simulation.duration": "0.25 s"}))
    save(run, tmp_path / "trajectory.csv")
    log = read_log(tmp_path / "trajectory.csv", {})
    assert log.signals["command"].tolist() == run["controller.u"].values.tolist()
    assert log.signals["external_force"].tolist() == run["load.force"].values.tolist()
    shown = "sensors.position.value" if "sensors.position.value" in run else "plant.position"
    assert log.signals["position"].tolist() == run[shown].values.tolist()


def test_steps_of_a_signal_and_its_noise_are_told():
    rng = np.random.default_rng(2)
    smooth = np.sin(np.linspace(0.0, 6.0, 4000))
    assert noise_of(smooth + 0.01 * rng.normal(size=4000)) == pytest.approx(0.01, rel=0.05)
    assert resolution_of(np.round(smooth / 0.02) * 0.02) == pytest.approx(0.02)
    assert resolution_of(smooth) == 0.0
    assert not spikes_in(smooth).any()
