"""A static map from a log, and what is refused in one line."""

import hashlib
import json
from html import escape

import numpy as np
import pandas as pd
import pytest

from hydroservo.core.formatting import brief
from hydroservo.identification.maps import map_logs
from hydroservo.identification.maps.finding import map_finding
from hydroservo.scenario import load_scenario
from hydroservo.show.table import texts_of
from tests.support.characteristic_logs import sweep
from tests.support.commands.runner import failed, hydroservo_, succeeded
from tests.support.commands.tuning import rows_of
from tests.support.map_logs import scenario
from tests.support.reports import check_report, text_of

pytestmark = pytest.mark.slow  # it runs and draws


@pytest.fixture
def log(tmp_path):
    """Pressures that decay, as if only past the piston."""
    time = np.linspace(0.0, 5.0, 1001)
    apart = 40.0 * np.exp(-1.4 * time)
    table = {"time [s]": time, "pressure_a [bar]": 60.0 + apart, "pressure_b [bar]": 60.0 - apart}
    path = tmp_path / "decay.csv"
    pd.DataFrame(table).to_csv(path, index=False)
    return path


def mapped(tmp_path, log):
    """The log with the columns that a run of the example has."""
    table = pd.read_csv(log)
    names = {f"pressure_{one} [bar]": f"sensors.pressure_{one}.value [bar]" for one in "ab"}
    table = table.rename(columns=names)
    table["controller.u [V]"] = 0.0
    table["sensors.position.value [m]"] = 0.2
    path = tmp_path / "mapped.csv"
    table.to_csv(path, index=False)
    return path


def test_map_writes_what_it_found(log, tmp_path):
    out = tmp_path / "found"
    log = mapped(tmp_path, log)
    result = hydroservo_("map", "decay", log, "--scenario", scenario("decay"), "--json", "--out", out)
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    leak = said["numbers"]["internal_leakage"]
    assert leak["low"] <= leak["value"] <= leak["high"]
    check_report(out, said)
    assert hashlib.sha256(log.read_bytes()).hexdigest() in text_of(out)
    assert load_scenario(out / "scenario.toml").plant.internal_leakage == leak["value"]
    curve = pd.read_csv(out / "map.csv")
    assert len(curve["pressure_a [Pa]"]) == len(said["curve"]["pressure_a"]["values"])


def test_map_shows_its_numbers(log, tmp_path):
    log = mapped(tmp_path, log)
    text = succeeded("map", "decay", log, "--scenario", scenario("decay"))
    found = map_logs("decay", log, scenario("decay"))
    row = rows_of(text)["internal_leakage"]
    assert row[0] == brief(found.numbers["internal_leakage"].value)
    count, total = len(found.numbers), len(found.numbers) + len(found.undetermined)
    assert f"{count} of {total} numbers can be determined, from {found.curve.sizes['point']:,} points" in text


def test_a_notebook_shows_the_numbers_of_a_map(log, tmp_path):
    found = map_logs("decay", mapped(tmp_path, log), scenario("decay"))
    (table,) = map_finding(found).tables
    number = found.numbers["bulk_modulus"]
    (row,) = (row for row in table.rows if row[0].value == "bulk_modulus")
    assert [cell.value for cell in row[1:4]] == [*number[:3]]
    page = found._repr_html_()
    assert all(remark in page for remark in map(escape, found.remarks))
    for text in (*texts_of(table).rows[0], *found.undetermined):
        assert escape(text) in page


def written_log(path, columns):
    """A log in a file."""
    pd.DataFrame(columns).to_csv(path, index=False)
    return path


def test_a_characteristic_is_written_as_a_table_from_which_curves_are_read(tmp_path):
    signals, out = sweep(0), tmp_path / "found"
    units = {"time": "s", "command": "V", "velocity": "m/s"}
    log = written_log(
        tmp_path / "sweep.csv", {f"{name} [{units[name]}]": row for name, row in signals.items()}
    )
    result = hydroservo_("map", "characteristic", log, "--json", "--out", out)
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    check_report(out, said)
    assert not (out / "scenario.toml").exists()
    table = pd.read_csv(out / "characteristic.csv")
    assert list(table)[:2] == ["command [V]", "speed [m/s]"]
    assert table["speed [m/s]"].tolist() == said["characteristic"]["speed"]["values"]
    assert table["samples"].dtype.kind == "i"
    text = succeeded("map", "characteristic", log)
    assert f"of {len(table)} points; all are in characteristic.csv." in text
    assert len(text.splitlines()) < 40
    page = map_logs("characteristic", log)._repr_html_()
    assert "all are in characteristic.csv" in page


def test_the_table_of_a_valve_that_takes_a_current_is_over_that(tmp_path):
    signals, out, mine = sweep(0), tmp_path / "found", tmp_path / "mine.toml"
    columns = {"time [s]": signals["time"], "command [mA]": 4.0 * signals["command"]}
    log = written_log(tmp_path / "sweep.csv", {**columns, "velocity [m/s]": signals["velocity"]})
    own = 'base = "axis/position"\ncommand.full_scale = "40 mA"\n'
    mine.write_text(own)
    succeeded("map", "characteristic", log, "--scenario", mine, "--out", out)
    table = pd.read_csv(out / "characteristic.csv")
    assert table["command [mA]"].iloc[-1] == pytest.approx(39.6, abs=0.3)
    mine.write_text(
        own + '[controller]\ntype = "CharacteristicCompensation.from_speed"\n'
        'speed = { file = "found/characteristic.csv" }\nfull_command = "40 mA"\nthreshold = "0.4 mA"\n'
        'controller = { type = "PID", proportional_gain = "800 mA/m", integral_gain = "0 mA/(m s)" }\n'
    )
    inverse = load_scenario(mine).controller.inverse
    assert inverse.value(10.0) == pytest.approx(9.9, abs=0.1)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ("flow",),
            "kind = 'flow': must be one of valve-flow, characteristic, pressure-gain, friction, decay",
        ),
        (("decay",), "a decay map needs one"),
        (("valve-flow",), 'column "command [V]" is missing'),
        (("friction",), 'no column "velocity [m/s]" or "position [m]"'),
        (("decay", "--set", "plant.mass=3"), "need a scenario"),
    ],
)
def test_what_makes_no_map_is_one_line(log, arguments, said):
    kind, *rest = arguments
    assert said in failed("map", kind, log, *rest)
