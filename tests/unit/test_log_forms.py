"""One log in the forms in which loggers, controllers and spreadsheets leave it."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.core.field import Field
from hydroservo.identification.log import SignalLog, read_log
from hydroservo.scenario import load_scenario
from hydroservo.scenario.records.series import read_series
from tests.support.bases import on_base

TIME = np.round(0.01 * np.arange(40), 2)
COMMAND = np.round(5.0 * np.sin(20.0 * TIME), 3)
POSITION = np.round(400.0 + 30.0 * np.cos(20.0 * TIME), 2)  # mm
ROWS = np.c_[TIME, COMMAND, POSITION]
NAMES = {"time": "time [s]", "command": "command [V]", "position": "position [mm]"}


def table(mark: str = ",", comma: bool = False, head: str = "", rows: np.ndarray = ROWS) -> str:
    text = "\n".join(mark.join(f"{value:g}" for value in row) for row in rows)
    return f"{head}\n{text.replace('.', ',') if comma else text}\n"


def instants(write, first: str = "2024-05-01T08:00:00") -> str:
    start = datetime.fromisoformat(first)
    lines = [
        f"{write(start + timedelta(milliseconds=10 * k))};{COMMAND[k]:g};{POSITION[k]:g}" for k in range(40)
    ]
    return "\n".join(["time;command [V];position [mm]", *lines]) + "\n"


def assert_is_the_log(log: SignalLog) -> None:
    np.testing.assert_allclose(log.time - log.time[0], TIME, atol=1e-12)
    np.testing.assert_allclose(log.signals["command"], COMMAND, atol=1e-12)
    np.testing.assert_allclose(log.signals["position"], POSITION * 1e-3, atol=1e-12)


HEAD = "time [s],command [V],position [mm]"
TEXTS = {
    "comments": table(head=f"# rig 3, run 7\n# sampled at 100 Hz\n{HEAD}"),
    "timestamp": table(head=HEAD.replace("time", "Timestamp")),
    "comments below": table(head=HEAD).replace("\n0.1,", "\n# oil at 40 degrees\n0.1,"),
    "preamble": table(
        "\t", head="Test\tSweep\nOperator\tA\nChannels\t3\n\ntime\tcommand\tposition\ns\tV\tmm"
    ),
    "preamble of as many columns": table(
        ";", head="Rate;100;Hz\nFrom;0;s\nA;b;c\n\ntime [s];command [V];position [mm]"
    ),
    "units row": table(head="time,command,position\ns,V,mm"),
    "units row in brackets": table(head="time,command,position\n[s],[V],[mm]"),
    "units row with a label": table(";;", head="Name;;Time;;Command;;Position\nUnits;;s;;V;;mm").replace(
        "\n0", "\n;;0"
    ),
    "units after a stroke": table(";", head="time / s;command / V;position / mm"),
    "names that are numbers": table(head="x-axis,1,2\ns,V,mm"),
    "units in brackets after a stroke": table(";", head="time / (s);command / (V);position / (mm)"),
    "units in other cases": table(head="time [Sec],command [Volts],position [mm]"),
    "header in a comment, texts in a column": "% time [s],frame,command [V],position [mm]\n"
    + "\n".join(f"{t:g},axis,{u:g},{x:g}" for t, u, x in ROWS),
    "rows without their last cell": table("\t", head="time [s]\tcommand [V]\tposition [mm]\tComment"),
    "an index of dates without a name": instants(lambda at: at.isoformat(sep=" ")).replace("time;", ";"),
    "parentheses, capitals": table(head="Time (s),Command (V),Position (mm)"),
    "blanks around": table(", ", head=" time [s] , command [V] , position [mm] "),
    "hint of a spreadsheet": table(";", comma=True, head=f"sep=;\n{HEAD.replace(',', ';')}"),
    "blanks": table(" ", head="time [s] command [V] position [mm]"),
    "aligned by blanks": table("   ", head="   time[s]   command[V]   position[mm]"),
    "header in a comment": table(" ", head="# written by numpy\n# time[s] command[V] position[mm]"),
    "header after a percent sign": table(head="%time [s],command [V],position [mm]"),
    "an index in front": table(head=f",{HEAD}").replace("\n0", "\n7,0"),
    "clock": instants(lambda at: at.isoformat(timespec="milliseconds")),
    "clock of a zone": instants(lambda at: at.isoformat(timespec="milliseconds") + "+02:00"),
    "clock, decimal comma": instants(lambda at: f"{at:%d.%m.%Y %H:%M:%S},{at.microsecond // 1000:03d}"),
    "clock without a date, over midnight": instants(
        lambda at: f"{at:%H:%M:%S}.{at.microsecond // 1000:03d}", "2024-05-01T23:59:59.800"
    ),
    "clock with a date, over midnight": instants(
        lambda at: f"{at:%m/%d/%Y %I:%M:%S}.{at.microsecond // 1000:03d} {at:%p}", "2024-05-01T23:59:59.800"
    ),
    "minutes and seconds": instants(
        lambda at: f"{at.minute:02d}:{at.second:02d}.{at.microsecond // 1000:03d}"
    ),
}


@pytest.mark.parametrize("form", TEXTS)
def test_text_as_it_comes(form: str, tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    path.write_text(TEXTS[form], encoding="utf-8")
    names = dict(zip(NAMES, ("x-axis", "1", "2"), strict=True)) if "numbers" in form else {}
    assert_is_the_log(read_log(path, names))


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_text_in_the_encodings_of_loggers(encoding: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(
        table(";", head=HEAD.replace(",", ";") + ";angle [°]").replace("\n", ";1\n", 99), encoding
    )
    text = path.read_text(encoding).replace("°];1", "°]", 1)
    path.write_text(text, encoding)
    assert_is_the_log(read_log(path, {}))


@pytest.mark.parametrize(
    ("column", "says"),
    [
        ("command [mA]", {"column": "command [mA]", "scale": "0.25 V/mA"}),
        ("command [mA]", {"column": "command", "scale": "250 V/A"}),
        ("command [mA]", {"scale": "0.25 V/mA"}),
        ("command [%]", {"scale": "0.25 V/%"}),
        ("stick [deg]", {"column": "stick [deg]", "scale": "0.25 V/deg"}),
        ("command [LSB]", {"scale": "0.25 V/LSB"}),
        ("adc", {"column": "adc", "scale": "0.25 V"}),
        ("adc", {"column": "adc", "scale": "0.25 V/count"}),
        ("u", {"column": "u", "scale": "0.25 V/%"}),
        ("u / %", {"column": "u", "scale": "0.25 V/%"}),
        ("command [mV]", {"scale": "250"}),
    ],
)
def test_a_scale_takes_a_column_to_its_signal(column: str, says: dict[str, str], tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = np.c_[TIME, COMMAND * 4.0, POSITION]
    path.write_text(table(head=f"time [s],{column},position [mm]", rows=rows), encoding="utf-8")
    assert_is_the_log(read_log(path, {"command": says}))


def test_an_offset_moves_a_live_zero(tmp_path: Path) -> None:
    """A transducer of 0 to 250 bar on 4 to 20 mA."""
    path = tmp_path / "log.csv"
    current = 4.0 + 16.0 * np.abs(COMMAND) / 250.0
    path.write_text(table(head="time [s],command [V],p [mA]", rows=np.c_[TIME, COMMAND, current]), "utf-8")
    says = {"column": "p", "scale": "15.625 bar/mA", "offset": "-62.5 bar"}
    pressure = read_log(path, {"pressure_a": says}).signals["pressure_a"]
    np.testing.assert_allclose(pressure, np.abs(COMMAND) * 1e5, atol=1e5 * 1e-4)  # of %g


def test_a_period_stands_for_a_column_of_instants(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(table(head="command [V],position [mm]", rows=ROWS[:, 1:]), encoding="utf-8")
    assert_is_the_log(read_log(path, {"period": "10 ms"}))
    with pytest.raises(ScenarioError, match=r'column "time \[s\]" is missing among .*period = "1 ms"'):
        read_log(path, {})


def test_words_between_header_and_numbers_are_not_the_first_sample(tmp_path: Path) -> None:
    """As of a controller's scope, whose lines of settings hold numbers too."""
    path = tmp_path / "log.csv"
    head = "Name;Command [V];Name;Position [mm]\nSampleTime[ms];1;SampleTime[ms];1\nComment;;Comment;"
    rows = "\n".join(f"{t:g};{u:g};{t:g};{x:g}" for t, u, x in ROWS)
    path.write_text(f"{head}\n{rows}\n", encoding="utf-8")
    assert_is_the_log(read_log(path, {"period": 0.01}))


def test_a_unit_that_stands_for_another_is_shown(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(table(head=HEAD), encoding="utf-8")
    log = read_log(path, {"position": "position [m]"})
    assert log.columns["position"] == "position [mm], read in m"


@pytest.mark.parametrize(
    ("content", "kind"),
    [(b"MATLAB 5.0 MAT-file", "a MAT file; name it .mat"), (b"PAR1", "a Parquet file; name it .parquet")],
)
def test_a_file_of_another_ending_is_named(content: bytes, kind: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(content + bytes(range(256)))
    with pytest.raises(ScenarioError, match=f"log.csv: is {kind}"):
        read_log(path, {})


def matlab(path: Path, **arrays: object) -> Path:
    from scipy.io import savemat

    savemat(path, arrays)
    return path


BINARY = {
    "matrix": (lambda path: matlab(path, data=ROWS), ["data[1] [s]", "data[2] [V]", "data[3] [mm]"]),
    "channels in rows": (
        lambda path: matlab(path, data=ROWS.T),
        ["data[1] [s]", "data[2] [V]", "data[3] [mm]"],
    ),
    "rows beside columns": (
        lambda path: matlab(path, t=TIME[None], u=COMMAND[:, None], y=POSITION[None]),
        ["t [s]", "u [V]", "y [mm]"],
    ),
    "out of a model": (
        lambda path: matlab(path, tout=TIME[:, None], yout=ROWS[:, 1:]),
        ["tout [s]", "yout[1] [V]", "yout[2] [mm]"],
    ),
    "structure": (
        lambda path: matlab(path, log={"time": TIME, "command": COMMAND, "position": POSITION}),
        ["log.time [s]", "command [V]", "log.position [mm]"],
    ),
    "structure with signals": (
        lambda path: matlab(path, out={"time": TIME, "signals": {"values": ROWS[:, 1:]}}),
        ["out.time [s]", "out.signals.values[1] [V]", "out.signals.values[2] [mm]"],
    ),
    "structures in a row": (
        lambda path: matlab(path, out=np.array([{"v": TIME}, {"v": COMMAND}, {"v": POSITION}], object)),
        ["out[1].v [s]", "out[2].v [V]", "out[3].v [mm]"],
    ),
}


@pytest.mark.parametrize("form", BINARY)
def test_matlab_as_it_comes(form: str, tmp_path: Path) -> None:
    write, columns = BINARY[form]
    path = write(tmp_path / "log.mat")
    assert_is_the_log(read_log(path, dict(zip(NAMES, columns, strict=True))))


@pytest.mark.parametrize("ending", ["mat", "nc", "h5"])
def test_hdf5_is_read_with_its_units(ending: str, tmp_path: Path) -> None:
    import h5py

    path = tmp_path / f"log.{ending}"
    with h5py.File(path, "w", userblock_size=512 if ending == "mat" else 0) as file:
        for name, values in zip(NAMES, ROWS.T, strict=True):
            file[name] = values[None]
            unit = NAMES[name].partition("[")[2][:-1]
            if ending == "mat":  # which has them in a structure, and texts as numbers
                file[f"units/{name}"] = np.array([[ord(sign)] for sign in unit], "u2")
                file[f"units/{name}"].attrs["MATLAB_class"] = np.bytes_("char")
            else:
                file[name].attrs["units"] = unit
        file["note"] = "run 7"
    if ending == "mat":
        with path.open("r+b") as raw:
            raw.write(b"MATLAB 7.3 MAT-file".ljust(116) + b"\0" * 8 + b"\x00\x02IM")
    assert_is_the_log(read_log(path, {}))


def test_packed_numbers_of_netcdf_are_unpacked(tmp_path: Path) -> None:
    import h5py

    path = tmp_path / "log.nc"
    with h5py.File(path, "w") as file:
        for name, values in zip(NAMES, ROWS.T, strict=True):
            file[name] = np.append(np.round(values[:-1] * 1000).astype("i4"), -1)
            file[name].attrs.update({"scale_factor": 1e-3, "units": NAMES[name].partition("[")[2][:-1]})
        file["position"].attrs["_FillValue"] = -1
        file["time"][-1] = 1000 * 0.39
    log = read_log(path, {})
    np.testing.assert_allclose(log.signals["position"][:-1], POSITION[:-1] * 1e-3)
    assert np.isnan(log.signals["position"][-1])


def test_tdms_with_the_instants_of_a_waveform(tmp_path: Path) -> None:
    import nptdms

    path = tmp_path / "log.tdms"
    channels = [
        nptdms.ChannelObject(
            "Axis",
            name.capitalize(),
            values,
            {"wf_increment": 0.01, "wf_start_offset": 0.0, "unit_string": unit},
        )
        for name, values, unit in [("command", COMMAND, "V"), ("position", POSITION, "mm")]
    ]
    with nptdms.TdmsWriter(path) as file:
        file.write_segment(channels)
    assert_is_the_log(read_log(path, {}))


@pytest.mark.parametrize("other", [{"wf_increment": 0.02}, {"wf_start_offset": 0.005}])
def test_each_waveform_of_tdms_has_its_own_clock(other: dict[str, float], tmp_path: Path) -> None:
    import nptdms

    path = tmp_path / "log.tdms"
    clock = {"wf_increment": 0.01, "wf_start_offset": 0.0}
    with nptdms.TdmsWriter(path) as file:
        file.write_segment(
            [
                nptdms.ChannelObject("Axis", "command", COMMAND, clock | {"unit_string": "V"}),
                nptdms.ChannelObject("Axis", "position", POSITION, clock | other | {"unit_string": "mm"}),
            ]
        )
    log = read_log(path, {})
    there = np.isfinite(log.signals["position"])
    own = (clock | other)["wf_start_offset"] + (clock | other)["wf_increment"] * np.arange(40)
    np.testing.assert_allclose(log.time[there], own, atol=1e-9)
    np.testing.assert_allclose(log.signals["position"][there], POSITION * 1e-3)
    np.testing.assert_allclose(log.time[np.isfinite(log.signals["command"])], TIME, atol=1e-9)


def test_instants_of_parquet_are_dates(tmp_path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    first = datetime(2024, 5, 1, 8, tzinfo=UTC)
    dates = [first + timedelta(milliseconds=10 * k) for k in range(40)]
    path = tmp_path / "log.parquet"
    pq.write_table(
        pa.table({"__index_level_0__": dates, "command [V]": COMMAND, "position [mm]": POSITION}), path
    )
    assert_is_the_log(read_log(path, {}))


def test_a_file_without_columns_says_what_it_holds(tmp_path: Path) -> None:
    path = matlab(tmp_path / "log.mat", words="run 7", cube=np.zeros((2, 3, 4)))
    with pytest.raises(ScenarioError) as caught:
        read_log(path, {})
    assert str(caught.value).partition(": ")[2] == (
        "has no columns of numbers; it holds words: 1 char, cube: 2 x 3 x 4; save each signal as a vector, "
        "such as t = ts.Time; x = ts.Data; save('log.mat', 't', 'x')"
    )


@pytest.mark.parametrize(
    ("mapping", "problem"),
    [
        (
            {"command": {"colum": "u"}},
            r"columns.command = .* has the unknown key 'colum'; .* did you mean column",
        ),
        ({"command": {"scale": 0.25}}, r'has scale = 0.25, which must be a string such as "0.25 V/mA"'),
        ({"command": 3}, "must be the name of a column"),
        ({"command": {"offset": True}}, r'has offset = True, which must be a string such as "-62.5 bar"'),
        ({"period": True}, 'must be a time, such as "10 ms"'),
        ({"period": "10 ms", "time": "time [s]"}, "must be left out where time names a column"),
        ({"period": "0 s"}, "columns.period = '0 s': must be above 0"),
        ({"period": "10 mm"}, "columns.period = '10 mm': does not convert to s"),
    ],
)
def test_wrong_mappings(mapping: dict[str, object], problem: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(table(head=HEAD), encoding="utf-8")
    with pytest.raises(ParameterError, match=problem):
        read_log(path, mapping)


@pytest.mark.parametrize(
    ("offset", "problem"), [("-1", "has no unit; write '-1 m'"), ("1 V", "does not convert")]
)
def test_wrong_offsets_are_named_as_that(offset: str, problem: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(table(head=HEAD), encoding="utf-8")
    with pytest.raises(ScenarioError, match=f"has the offset '{offset}', which {problem}"):
        read_log(path, {"position": {"offset": offset}})
    log = read_log(path, {"position": {"offset": -0.1}})
    np.testing.assert_allclose(log.signals["position"], POSITION * 1e-3 - 0.1)


def test_a_row_with_a_bad_instant_is_refused_and_not_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(table(head=HEAD).replace("\n0,", "\nx,", 1), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"line 2, column time .*: 'x' must be a finite number"):
        read_log(path, {})


@pytest.mark.parametrize(
    ("scale", "problem"),
    [
        ("0.25 bar/mA", r"column 'command \[mA\]' times 0.25 bar/mA does not convert to V"),
        ("0 V/mA", "has the scale 0 V/mA, which must not be 0"),
        ("V/mA", "has the scale 'V/mA', which must be such as '0.25 V/mA'"),
        ("", r'write \[identify.columns\] command = { column = "command \[mA\]", scale = "NUMBER V/mA" }'),
    ],
)
def test_wrong_scales(scale: str, problem: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(table(head=HEAD.replace("[V]", "[mA]")), encoding="utf-8")
    with pytest.raises(ScenarioError, match=problem):
        read_log(path, {"command": {"column": "command", "scale": scale}})


def test_a_series_takes_what_a_log_takes(tmp_path: Path) -> None:
    position = Field("m", "position demand")
    plain = tmp_path / "demand.csv"
    plain.write_text(table(head=HEAD), encoding="utf-8")
    expected = read_series(plain, position, "position")
    for name, form in [("units.csv", "units row"), ("preamble.txt", "preamble"), ("clock.csv", "clock")]:
        (tmp_path / name).write_text(TEXTS[form], encoding="utf-8")
        series = read_series(tmp_path / name, position, "Position")
        np.testing.assert_allclose(series.coefficients, expected.coefficients, atol=1e-6)
    path = matlab(tmp_path / "demand.mat", data=ROWS)
    series = read_series(path, position, "data[3] [mm]", "data[1] [s]")
    np.testing.assert_array_equal(series.coefficients, expected.coefficients)
    (tmp_path / "one.csv").write_text(
        "angle [deg]\n" + "\n".join(f"{x:g}" for x in POSITION), encoding="utf-8"
    )
    series = read_series(tmp_path / "one.csv", position, period=0.01, scale="1 mm/deg")
    np.testing.assert_allclose(series.coefficients, expected.coefficients, atol=1e-9)


def test_a_scenario_maps_with_a_scale_and_a_period(tmp_path: Path) -> None:
    (tmp_path / "demand.csv").write_text(table(head="v [%],w", rows=ROWS[:, 1:]), encoding="utf-8")
    scenario = tmp_path / "my.toml"
    series = '{file = "demand.csv", period = "10 ms", scale = "0.01 (m/s)/%", offset = "1 mm/s"}'
    scenario.write_text(on_base(f'reference = {{type = "Recorded", series = {series}}}'), encoding="utf-8")
    loop = load_scenario(scenario)
    assert loop.reference.series.value(0.1) == pytest.approx(0.01 * COMMAND[10] + 1e-3)
    scenario.write_text(
        on_base('[identify.columns]\ncommand = {column = "u", scal = "1 V/mA"}'), encoding="utf-8"
    )
    with pytest.raises(ScenarioError, match=r"identify.columns.command: .* has the unknown key 'scal'"):
        load_scenario(scenario)
