"""Records that do not fit the run: refused where it sees nothing of them, said where something is made up."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from typer.testing import CliRunner

from hydroservo import Aim, loads, references, tune
from hydroservo.cli.commands import app
from hydroservo.control.loop import AUTO, Loop, Simulation
from hydroservo.core.errors import HydroservoWarning, ParameterError
from hydroservo.core.time_series import TimeSeries
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.cautions.records import check_records
from hydroservo.runs.run import runnable_loop, simulate
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example
from tests.support.bases import on_base

LOG = np.arange(8001) / 1000.0  # 8 s at 1 kHz
LONG = np.arange(60_000) / 1000.0


def series(time: Sequence[float] | np.ndarray) -> TimeSeries:
    return TimeSeries.from_samples(time, np.sin(np.arange(len(time))))


def lines(time: Sequence[float] | np.ndarray, duration: float = 8.0) -> list[str]:
    return check_records(example(Loop, Simulation(duration), reference=references.Recorded(series(time))))


def test_a_glimpse_of_a_long_record_and_a_short_pulse_are_no_other_unit() -> None:
    assert lines(LONG[::20], 0.5) == []  # 26 samples of 3000
    assert len(lines(LOG[:101])) == 1  # held from 0.1 s on


@pytest.mark.parametrize(
    "time",
    [
        LOG,
        LOG[:-1],  # as many samples as periods
        LOG[::100][:-1] + 0.1,
        LOG[1:],
        np.arange(-100, 200) * 0.1,  # longer than the run on both sides
        np.arange(3600 * 50) / 50,  # of an hour
        [0.0, 0.1, 0.2, 7.0, 7.1, 8.0],  # by hand
        [0.0, 8.0],
        [0.0, 3600.0],
        [*np.linspace(0.0, 1.0, 28), 8.0],  # 29 samples
        np.cumsum(np.tile([0.01, 0.02, 0.2], 60)),  # at irregular instants
        LOG[(LOG < 3.0005) | (LOG > 3.0095)],  # a step as long as ten
        np.concatenate([np.arange(-2000, -1000), np.arange(8001)]) / 1000.0,  # a hole before the run
        np.concatenate([np.arange(8001), np.arange(9000, 9999)]) / 1000.0,  # one after it
    ],
)
def test_records_that_fit(time: np.ndarray) -> None:
    assert lines(time) == []


@pytest.mark.parametrize(
    ("time", "says"),
    [
        (
            1234.0 + LOG,
            "goes from 1234 s to 1242 s, and the run from 0 s to 8 s, which would see its first sample",
        ),
        (1706459191.31 + LOG, "goes from 1706459191.31 s to 1706459199.31 s"),
        (1706459191.31 + LOG, "; subtract its first instant, 1706459191.31 s, from each"),
        (8.0 + LOG, "its first sample alone"),
        (
            LOG - 8.0,
            "goes from -8 s to 0 s, and the run from 0 s to 8 s, which would see its last sample alone",
        ),
        ([9.0, 10.0], "its first sample alone; subtract its first instant, 9 s, from each"),
        (
            1.7e12 + 1e3 * LOG,
            "it lasts 8000 s, .* sees 0 of its 8001 .* 1000 times too large (ms read as s)?",
        ),
    ],
)
def test_a_record_of_which_the_run_sees_nothing_is_refused(time: np.ndarray, says: str) -> None:
    with pytest.raises(ParameterError) as caught:
        lines(time)
    assert str(caught.value).startswith(f"reference.series = '{len(time)} samples': ")
    assert re.search(re.escape(says).replace(r"\.\*", ".*"), str(caught.value))


@pytest.mark.parametrize(
    ("time", "duration", "says"),
    [
        (LOG[:5001], 8.0, ["ends at 5 s of 8 s, and its last sample is held from then on"]),
        (LOG + 1.5, 8.0, ["starts at 1.5 s, and its first sample is held until then"]),
        (
            LOG[1000:2000],
            8.0,
            ["starts at 1 s, .* held until then and ends at 1.999 s of 8 s, .* from then on"],
        ),
        (LOG[:-2], 8.0, ["ends at 7.998 s of 8 s"]),
        ([0.0, 1.0], 8.0, ["ends at 1 s of 8 s"]),
        ([0.0, 10.0], 15.0, ["ends at 10 s of 15 s"]),
        (
            LOG[(LOG < 3.0005) | (LOG > 4.9995)],
            8.0,
            ["has a hole of 2 s after 3 s, bridged by .* where nine in ten .* are 0.001 s or less"],
        ),
        (
            LOG[(LOG % 2.0 < 1.0005) | (LOG % 2.0 > 1.4995) | (LOG > 5.4995)],
            8.0,
            ["has 3 holes, the longest of 0.5 s after"],
        ),
        ([*np.linspace(0.0, 1.0, 29), 8.0], 8.0, ["has a hole of 7 s after 1 s"]),
        (
            1e3 * LONG,
            8.0,
            ["lasts 59999 s, .* of 8 s sees 9 of its 60000 samples: .* 1000 times too large (ms read as s)?"],
        ),
        (1e6 * LOG, 8.0, ["sees 1 of its 8001 samples: .* 1000000 times too large (us read as s)?"]),
        (
            1e-3 * LONG,
            8.0,
            ["ends at 0.059999 s of 8 s", "sees 60000 of its .* 1000 times too small (s read as ms)?"],
        ),
    ],
)
def test_what_a_run_makes_up_is_said(time: np.ndarray, duration: float, says: list[str]) -> None:
    found = lines(time, duration)
    assert len(found) == len(says)
    for line, part in zip(found, says, strict=True):
        assert line.startswith(f"reference.series = '{len(time)} samples': ")
        assert re.search(re.escape(part).replace(r"\.\*", ".*"), line)


def test_each_recorded_block_is_looked_at_and_zeros_are_not() -> None:
    loop = example(
        Loop,
        Simulation(8.0),
        load=loads.Recorded(series(LOG[:5001])),
        reference=references.Recorded(series(LOG[:4001])),
    )
    found = sorted(check_records(loop))
    assert [line[: line.index(":")] for line in found] == [
        "load.series = '5001 samples'",
        "reference.series = '4001 samples'",
    ]
    assert check_records(loop._replace(load=loads.Recorded(), reference=references.Recorded())) == []


class Doubled(NamedTuple):
    """A load of one's own around another."""

    load: loads.Recorded

    def force(self, t: float) -> float:
        return 2.0 * self.load.force(t)

    def next_jump(self, t: float) -> float:
        return self.load.next_jump(t)


def test_records_inside_other_blocks_are_looked_at() -> None:
    loop = example(Loop, Simulation(8.0), load=Doubled(loads.Recorded(series(LOG + 9.0))))
    with pytest.raises(ParameterError, match=r"load\.load\.series"):
        check_records(loop)


def test_a_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("t [s],v [mm/s],F [kN]\n10,0,1\n11,1,2\n")
    (tmp_path / "my.toml").write_text(
        on_base("""reference = {type = "Recorded", series = {file = "log.csv"}}""")
    )
    with pytest.raises(
        ParameterError, match=re.escape("reference.series = 'log.csv, v [mm/s] over t [s]': goes")
    ):
        check_records(load_scenario(tmp_path / "my.toml"))


HELD = r"reference\.series = '51 samples': ends at 0\.05 s of 0\.1 s, and its last sample is held .*"
PARTLY = references.Recorded(TimeSeries.from_samples(np.arange(51) / 1000.0, np.full(51, 0.01)))
UNSEEN = references.Recorded(TimeSeries.from_samples([5.0, 6.0], [0.01, 0.02]))


def loop_with(demand: references.Recorded, substeps: int = 20) -> Loop:
    return example(Loop, Simulation(0.1, 1e-4, substeps), reference=demand)


def test_a_run_says_so() -> None:
    with pytest.warns(HydroservoWarning, match=HELD) as said:
        data = simulate(loop_with(PARTLY), record=())
    assert len(said) == 1
    assert re.fullmatch(HELD, data.attrs["warning"])
    with pytest.raises(ParameterError, match=r"reference\.series = '2 samples': goes from 5 s to 6 s"):
        simulate(loop_with(UNSEEN), record=())


@pytest.mark.parametrize("substeps", [20, AUTO])
def test_a_batch_says_so_once(substeps: int) -> None:
    with pytest.warns(HydroservoWarning, match=HELD) as said:
        data = simulate_batch(loop_with(PARTLY, substeps), {"plant.mass": [6.0, 7.0]})
    assert len(said) == 1
    assert re.fullmatch(HELD, data.attrs["warning"])
    with pytest.raises(ParameterError, match=r"reference\.series"):
        simulate_batch(loop_with(UNSEEN, substeps), {"plant.mass": [6.0, 7.0]})


@pytest.mark.slow  # some ten seconds
def test_a_search_says_so_once() -> None:
    ranges = {"controller.proportional_gain": (1.0, 10.0)}
    with pytest.warns(HydroservoWarning, match=HELD) as said:
        tune(Aim([loop_with(PARTLY)], [1.0]), ranges, candidates=64)
    assert len(said) == 1
    with pytest.raises(ParameterError, match=r"reference\.series"):
        tune(Aim([loop_with(UNSEEN)], [1.0]), ranges, candidates=64)


def test_what_has_no_duration_is_not_looked_at() -> None:
    assert runnable_loop(loop_with(UNSEEN)).reference == UNSEEN
    assert exported_unit(loop_with(UNSEEN), Part.LOOP, prefix="pi", title="PI").source


@pytest.fixture
def scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    Path("held.csv").write_text("t;v [mm/s]\n0;1\n0,05;2\n")
    Path("late.csv").write_text("t [s];v [mm/s]\n10;1\n11,5;2\n")
    Path("my.toml").write_text(
        on_base(
            'simulation = {duration = "0.1 s", period = "100 us", substeps = 20}\n'
            'reference = {type = "Recorded", series = {file = "held.csv"}}\n'
            'load = {type = "Recorded", series = {file = "force.csv"}}\n'
        )
    )
    Path("force.csv").write_text("t [s],F [kN]\n0,0\n0.1,0.01\n")
    return "my.toml"


def test_the_command_line_says_so(scenario: str) -> None:
    done = CliRunner().invoke(app, ["run", scenario])
    assert done.exit_code == 0
    assert [line for line in done.stderr.splitlines() if "warning" in line] == [
        "hydroservo: warning: my.toml: held.csv: column 't' has no unit and is read in s; "
        'write "t [s]", or the unit that it is in',
        "hydroservo: warning: my.toml: reference.series = 'held.csv, v [mm/s] over t': "
        "ends at 0.05 s of 0.1 s, and its last sample is held from then on",
    ]


def test_the_command_line_refuses(scenario: str) -> None:
    done = CliRunner().invoke(app, ["run", scenario, "--set", "reference.series.file=late.csv"])
    assert done.exit_code == 2
    assert done.stderr.splitlines() == [
        "hydroservo: my.toml: reference.series = 'late.csv, v [mm/s] over t [s]': goes from 10 s to 11.5 s, "
        "and the run from 0 s to 0.1 s, which would see its first sample alone; subtract its first instant, "
        "10 s, from each"
    ]
