"""Recorded signals from CSV files: their units, separators and decimal marks, and what is refused."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from hydroservo import ScenarioError
from hydroservo.core.errors import HydroservoWarning
from hydroservo.core.field import Field
from hydroservo.core.time_series import TimeSeries
from hydroservo.scenario import load_scenario
from hydroservo.scenario.records.series import read_series
from tests.support.bases import on_base

VELOCITY = Field("m/s", "velocity demand")
SI = TimeSeries.from_samples([0.0, 0.5, 1.0], [0.0, 0.012, 0.03])
GOOD = "t [s],v [m/s]\n0,0\n0.5,0.012\n1,0.03\n"


def same(a: TimeSeries, b: TimeSeries) -> bool:
    return np.array_equal(a.knots, b.knots) and np.array_equal(a.coefficients, b.coefficients)


@pytest.fixture
def csv(tmp_path: Path):
    def write(text: str, name: str = "demand.csv") -> Path:
        path = tmp_path / name
        path.write_bytes(text.encode())
        return path

    return write


@pytest.mark.parametrize(
    "text",
    [
        GOOD,
        GOOD.replace("\n", "\r\n"),
        "\ufeff" + GOOD + "\n\n",
        GOOD + "  \n \t\n",
        "t [s],v [m/s]\n0,0\n0.5,0.012\n1,0.03",
        "t [ms], v [mm/s]\n0, 0\n500, 12\n1000, 30\n",
        'time (us),"v (mm/s)"\n0,0\n5e5,12\n"1e6",30\n',
        't [s];v [mm/s]\n0;0\n0,5;12\n1;"30,0"\n',
        "t [s];v [mm/s]\n0;0\n0.5;12\n1;30.0\n",
        "t [s]\tv [mm/s]\r\n0\t0\r\n0,5\t12\r\n1\t30\r\n",
        "t [s]\tv [mm/s]\n0.0\t0\n0.5\t12\n1e0\t3e1\n",
        '"t [s]";"v, as measured [mm/s]"\n0,0;0\n0,5;12\n1,0;30\n',
        "t [s];v [mm/s];\n0,0;0,000;\n0,5;12,000;\n1,0;30,000;\n;;\n;;\n",  # as spreadsheets write
        "t [s];v [mm/s]\n0,0;0;\n0,5;12;\n1,0;30;\n",
        "t [s],v [mm/s],t2 [s],w\n0,0,0,1\n0.5,12,1,1\n1,30,2,1\n,,3,1\n",
        "t [s];v, raw [mm/s]\n0,0;0,0\n0,5;12,0\n1,0;30,0\n",
        "t [min],v [m/min]\n0,0\n0.00833333333333333333,0.72\n0.016666666666666666,1.8\n",
    ],
)
def test_columns_and_units(csv, text: str) -> None:
    series = read_series(csv(text), VELOCITY)
    if "min" in text:
        np.testing.assert_allclose(series.value(0.5), 0.012, rtol=1e-14)
    else:
        assert same(series, SI)


@pytest.mark.parametrize(("column", "time"), [("v", "t"), ("v [mm/s]", "t"), ("v", "t [ms]")])
def test_columns_by_name(csv, column: str, time: str) -> None:
    path = csv("note,F (kN),v [mm/s],t [ms]\na,1,0,0\nb,2,12,500\n,3,30,1000\n")
    assert same(read_series(path, VELOCITY, column, time), SI)


WRONG = [
    ("", "line 1: must name at least two columns"),
    ("t\n0\n1\n", "line 1: must name at least two columns"),
    ("t v\na b\n", "line 1: must name at least two columns, separated by commas, semicolons, tabs or blanks"),
    ("0,0\n1,1\n2,2\n", "line 1: must name the columns"),
    ("t,v\n", "has 0 rows of numbers; at least 2"),
    ("t,v\n0,0\n", "has 1 rows of numbers; at least 2"),
    ("t,v\n0,0\n1\n", "line 3: has 1 cell; the header has 2"),
    ("t,v\n0,0\n1,2,3\n", "line 3: has 3 cells"),
    ("t,v\n0,0\n\n1,1\n", "line 3, column t: is empty, and numbers follow"),
    ("t,v\n0,0\n1,fast\n", "line 3, column v: 'fast' must be a finite number"),
    ("t,v [mm/s]\n0,0\n1,nan\n", r"line 3, column v \[mm/s\]: 'nan' must be a finite number"),
    ("t,v\n0,0\n1,inf\n", "'inf' must be"),
    ("t,v\n0,0\n1,1e999\n", "'1e999' must be"),
    ("t,v\n0,0\n1,1_0\n", "'1_0' must be"),
    ("t,v\n0,0\n1,\n", "line 3, column v: is empty"),
    ("t,v\n0,0\n0,1\n", "line 3, column t: '0' is not after"),
    ("t,v\n0,0\n2,1\n1,1\n", "line 4, column t: '1' is not after"),
    (
        "t,v [bar]\n0,0\n1,1\n",
        r"line 1: column 'v \[bar\]' does not convert to m/s; another column is chosen by",
    ),
    ("t [m],v\n0,0\n1,1\n", r"line 1: column 't \[m\]' does not convert to s"),
    ("t,v [mm/z]\n0,0\n1,1\n", "unknown unit z"),
    ('t,v\n0,"0\n1,1\n', "is not CSV"),
    ("t,v\n0,0\n1,1e300\n2,-1e308\n3,1e308", "column v"),
    ("t,v\n0,5,1,25\n", "line 2: has 4 cells; the header has 2; with decimal commas, semicolons must"),
    ("t,v\n  0.00 2.9\n  0.02 2.8\n", "line 2: is separated by blanks, and the header by commas"),
    ("t;v, raw\na;b,5\n", "line 1: has cells that may be separated by commas or semicolons"),
    ("t\0;\0v\0\n", "line 1: has null characters"),
    ("t [s],v\n0,0\n,\n1,1\n", r"line 3, column t \[s\]: is empty, and numbers follow"),
    ("t,v\n12:00:01.5,1\n0.1,2\n", "line 3, column t: '0.1' must be a time of day, as in the first row"),
    ("t,v\n0,1\n1,12:00:01.5\n", "line 3, column v: '12:00:01.5' is a time of day"),
    ('t,v\n0,"1,5"\n', "line 2, column v: '1,5' has a comma, and commas separate the cells"),
    ('t,v\n0,"1,234.5"\n', "line 2, column v: '1,234.5' has a comma, and commas separate the cells"),
    ("t;v\n0;1.234,5\n", "line 2, column v: '1.234,5' has its thousands separated"),
    ("t;v\n0;1,234,567\n", "line 2, column v: '1,234,567' has its thousands separated"),
    ("t;v\n0;1 234\n", "line 2, column v: '1 234' has its thousands separated"),
    ("t,v\n0,1'234\n", "has its thousands separated"),
    ("t;v\n0;1,2,3\n", "line 2, column v: '1,2,3' must be a finite number"),
    ("t;v\n0,5;1.5\n", "line 2, column v: '1.5' has a decimal point, and '0,5' in line 2 a decimal comma"),
    (
        "t;v\n0;1.5\n1;1,5\n",
        "line 3, column v: '1,5' has a decimal comma, and '1.5' in line 2 a decimal point",
    ),
    ("t;v\n0;850\n1;1,234\n", "line 3, column v: '1,234' may have a decimal comma or a comma between thou"),
    ("t\tv\n0\t1.234\n1\t2.345\n", "line 2, column v: '1.234' may have a decimal point or a point betw"),
    ("t,v\n0,0\n" + "9" * 70_000 + ",1\n", "line 3: is longer than"),
]


@pytest.mark.parametrize(("text", "problem"), WRONG)
def test_wrong_files(csv, text: str, problem: str) -> None:
    path = csv(text)
    with pytest.raises(ScenarioError, match=problem) as caught:
        read_series(path, VELOCITY)
    assert str(caught.value).startswith(f"{path}: ")
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("value", ["1,234", "-12,345", "0,001"])
def test_three_decimals_are_decimals_where_one_number_shows_it(csv, value: str) -> None:
    series = read_series(csv(f"t [s];v [m/s]\n0,5;{value}\n1,5;{value}\n"), VELOCITY)
    assert series.value(1.0) == float(value.replace(",", "."))


def test_a_column_without_a_unit_is_said_to_be_read_in_si(csv) -> None:
    path = csv(GOOD.replace(" [s]", "").replace(" [m/s]", ""))
    with pytest.warns(HydroservoWarning) as said:
        assert same(read_series(path, VELOCITY), SI)
    t, v = (str(warning.message) for warning in said)
    assert t == f"{path}: column 't' has no unit and is read in s; write \"t [s]\", or the unit that it is in"
    assert (
        v
        == f"{path}: column 'v' has no unit and is read in m/s; write \"v [m/s]\", or the unit that it is in"
    )


def test_a_mass_is_no_force(csv) -> None:
    path = csv("t [s],F (lbs)\n0,0\n1,1\n")
    with pytest.raises(ScenarioError, match=r"'F \(lbs\)' does not convert to N; .* the force is lbf$"):
        read_series(path, Field("N", "force"), "F")


def test_wrong_column_names(csv) -> None:
    path = csv("t,velocity,v,v\n0,0,1,2\n1,1,1,1\n")
    with pytest.raises(ScenarioError, match=r"column 'velocty' is missing; .* did you mean velocity"):
        read_series(path, VELOCITY, "velocty")
    with pytest.raises(ScenarioError, match="column 'v' appears more than once"):
        read_series(path, VELOCITY, "v")
    with pytest.raises(ScenarioError, match="column 'x' is missing; it must be one of t, velocity"):
        read_series(path, VELOCITY, "velocity", "x")


def test_files_that_are_none(tmp_path: Path) -> None:
    def named(name: str, content: bytes) -> Path:
        path = tmp_path / name
        path.write_bytes(content)
        return path

    blob = named("blob.csv", b"t,v\n0,0\n\x81\xfe\n")
    huge = tmp_path / "huge.csv"
    with huge.open("wb") as file:
        file.truncate((512 << 20) + 1)
    for path, problem in [
        (blob, "is not text in UTF-8, UTF-16 or Windows' code page 1252"),
        (huge, "is larger than 512 MiB"),
        (named("utf16.csv", GOOD.encode("utf-16-le")), "has null characters"),
        (named("log.csv.gz", gzip.compress(GOOD.encode())), "is compressed by gzip; unpack it"),
        (named("log.xlsx", b"PK\x03\x04\x14\x00\x06\x00\xff"), "is a zip archive or a workbook"),
        (tmp_path, "is a directory"),
        (tmp_path / "none.csv", "no such file"),
        (Path("/dev/zero"), "is not a regular file"),
    ]:
        with pytest.raises(ScenarioError, match=problem):
            read_series(path, VELOCITY)


def test_a_scenario_names_its_file(csv, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    csv(GOOD)
    csv("t [s],F [mN]\n0,0\n0.5,12\n1,30\n", "force.csv")
    scenario = tmp_path / "my.toml"
    scenario.write_text(
        on_base(
            'reference = {type = "Recorded", series = {file = "demand.csv"}}\n'
            'load = {type = "Recorded", series = {file = "force.csv", column = "F"}}'
        )
    )
    loop = load_scenario(scenario)  # beside the scenario
    assert same(loop.reference.series, SI)
    assert same(loop.load.series, SI)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "other.csv").write_text("t [s],v [m/s]\n0,1\n1,2\n")
    monkeypatch.chdir(elsewhere)  # an override starts where the user is
    changed = load_scenario(scenario, {"reference.series.file": "other.csv"})
    assert changed.reference.series.value(1.0) == 2.0


@pytest.mark.parametrize(
    ("series", "problem"),
    [
        ("", "reference.series: a file is needed"),
        ("series = {}", "reference.series: a file is needed"),
        ("series = 3", r"reference.series: 3 must be a table: \[reference.series\]"),
        ("series.file = 3", "reference.series.file: 3 must be a string"),
        ('series.file = "none.csv"', "reference.series.file: 'none.csv' there is no such file"),
        ('series = {file = "demand.csv", colum = "v"}', "reference.series.colum: .* did you mean column"),
        ('series = {file = "force.csv"}', r"force.csv: line 1: column 'F \[kN\]' does not convert to m/s"),
    ],
)
def test_wrong_tables(csv, tmp_path: Path, series: str, problem: str) -> None:
    csv(GOOD)
    csv("t,F [kN]\n0,0\n1,1\n", "force.csv")
    scenario = tmp_path / "my.toml"
    scenario.write_text(on_base(f'[reference]\ntype = "Recorded"\n{series}'))
    with pytest.raises(ScenarioError, match=problem):
        load_scenario(scenario)
