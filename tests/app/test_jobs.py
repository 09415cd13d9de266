"""What a page is told of a scenario."""

import math
import os

import numpy as np
import pandas as pd
import pytest

import hydroservo as hs
from hydroservo.app.drawing import MOST_POINTS, extent_of, outliers_text, thin_lines
from hydroservo.app.form import all_numbers, failure_at_field, failure_on_page, form_of
from hydroservo.app.jobs import JOBS
from hydroservo.app.source import Home, page_source
from hydroservo.core.errors import HydroservoError, ParameterError, ScenarioError
from hydroservo.scenario import assemble, scenarios
from tests.support.synthetic_logs import SCENARIO, exact_log, with_units

pytestmark = pytest.mark.slow  # it runs and draws

RIG = "rig/1khz-pi-sine"
KEY = "0123456789abcdef"  # of a log


@pytest.fixture
def home(tmp_path):
    return Home(RIG, (), tmp_path)


@pytest.fixture
def done(home):
    def one(job, **request):
        return JOBS[job](request, home, lambda *_: None)

    return one


@pytest.mark.parametrize("name", sorted(scenarios()))
def test_what_the_form_shows_is_the_scenario(name):
    """Each text of the form, entered as it stands, changes nothing."""
    before = assemble(name)
    changes = {}
    for one in all_numbers(form_of(before)):
        changes[one["path"]] = before_text(one)
    assert hs.load_scenario(name, changes) == before.loop


def before_text(one):
    if one["kind"] == "float":
        return one["text"]
    return {"bool": lambda text: text == "True", "int": lambda text: text if text == "auto" else int(text)}[
        one["kind"]
    ](one["text"])


ODD = [
    *(None, [], {}, -1, math.inf, True, ["a"]),
    *("", "x" * 300, "a\0b", "../x", "plant.nothing", "a.b.c", "drive.drive"),
]
ODD_TEXTS = [
    *('base = ["a"]', "base = { a = 1 }", "base = 5", f'base = "{RIG}"\ncontroller = 5'),
    *(f'base = "{RIG}"\nplant.type = ["x"]', f'base = "{RIG}"\nstart = []', "a = 1979-05-27", "# \ud800"),
]


@pytest.mark.parametrize(
    ("job", "field"),
    [
        *(("run", name) for name in ("text", "name", "changes", "substeps", "signals")),
        *(("retype", name) for name in ("path", "type")),
        *(
            ("log", "log"),
            ("identify", "log"),
            ("identify", "ranges"),
            ("frequency", "band"),
            ("export", "kind"),
        ),
    ],
)
def test_odd_requests_are_no_defects(done, job, field):
    usual = {"changes": {"simulation.duration": 0.01}, "path": "controller", "type": "PI", "kind": "csv"}
    problems = []
    for value in [*ODD, *(ODD_TEXTS if field == "text" else [])]:
        try:
            done(job, **{**usual, field: value})
        except Exception as error:
            problems.append(failure_on_page(error)["problem"])
    assert [problem for problem in problems if "a defect" in problem] == []


def test_a_type_for_no_block_says_what_has_one(done):
    with pytest.raises(ScenarioError, match=r"'plant.nothing': is not a block that can have"):
        done("retype", path="plant.nothing", type="PI")


def test_texts_of_pages_are_forgotten(home, monkeypatch):
    monkeypatch.setattr("hydroservo.app.source.MOST_TEXTS", 4)
    for i in range(8):
        source = page_source({"text": f'base = "{RIG}"\ntitle = "{i}"\n'}, home)
        os.utime(source.scenario, (i, i))
    texts = [file.read_text() for file in home.folder.glob("*.toml")]
    assert sorted(text[-4:-2] for text in texts) == ['"4', '"5', '"6', '"7']


def test_a_run_is_that_of_the_library(done):
    about, content = done("run", changes={"plant.mass": "6 kg", "simulation.duration": "0.5 s"})
    run = hs.simulate(hs.load_scenario(RIG, {"plant.mass": "6 kg", "simulation.duration": "0.5 s"}))
    rows = np.frombuffer(content, dtype=np.float32).reshape(-1, about["points"])
    panel = about["panels"][0]
    assert [one["path"] for one in panel["lines"]] == ["reference.value", "controlled.value"]
    np.testing.assert_allclose(rows[0], run["time"], rtol=1e-6)
    np.testing.assert_allclose(rows[2], panel["factor"] * run["controlled.value"], rtol=1e-6, atol=1e-6)
    assert about["hash"] == run.attrs["hash"]
    assert about["diverged"] == ""


def test_a_sketch_is_the_same_run(done):
    changes = {"simulation.duration": "0.5 s"}
    (whole, content), (sketch, other) = (
        done("run", changes=changes, **more) for more in ({}, {"substeps": 1})
    )
    assert content == other
    assert sketch["metrics"] == whole["metrics"]


def test_a_sketched_curve_lies_on_the_whole_one(done):
    about, content = done("frequency")
    rows = np.frombuffer(content, dtype=np.float32).reshape(-1, about["points"])
    said, other = done("frequency", band=[2.0 * float(rows[0, 0]), 0.5 * float(rows[0, -1])])
    sketch = np.frombuffer(other, dtype=np.float32).reshape(-1, said["points"])
    for row in (1, 2):
        wanted = np.interp(np.log(sketch[0]), np.log(rows[0]), rows[row])
        np.testing.assert_allclose(sketch[row], wanted, rtol=2e-2, atol=0.3)


def test_long_lines_keep_their_peaks():
    time = np.linspace(0.0, 1.0, 50_001)
    line = np.zeros(50_001)
    line[12_345], line[30_000] = 7.0, -5.0
    rows = thin_lines(time, [line])
    assert rows.shape[1] <= MOST_POINTS
    assert (rows[1].max(), rows[1].min()) == (7.0, -5.0)
    assert np.all(np.diff(rows[0]) > 0.0)


def test_saved_text_builds_on_its_base(done, tmp_path):
    about, _ = done("toml", changes={"plant.mass": "7 kg", "controller.type": "PI"})
    file = tmp_path / "saved.toml"
    file.write_text(about["text"])
    assert about["text"].startswith(f'base = "{RIG}"')
    assert hs.load_scenario(file) == hs.load_scenario(RIG, {"plant.mass": "7 kg", "controller.type": "PI"})


def test_an_opened_text_is_saved_with_its_changes(done, tmp_path):
    text = 'base = "axis/position"\n[load]\ntype = "Step"\ninitial = "0 N"\nfinal = "1 kN"\ntime = "1 s"\n'
    changes = {"load.type": "Constant", "load.amplitude": "200 N"}
    about, _ = done("toml", text=text, changes=changes)
    file = tmp_path / "saved.toml"
    file.write_text(about["text"])
    assert hs.load_scenario(file) == hs.load_scenario("axis/position", changes)
    assert "final" not in about["text"]


@pytest.mark.parametrize(
    ("request_", "key"),
    [
        ({"text": 'base = "../secret.toml"'}, "base"),
        (
            {"text": 'base = "axis/position"\n[reference]\nsignal = {file = "/etc/passwd"}'},
            "reference.signal.file",
        ),
        ({"changes": {"reference.signal.file": "/etc/passwd"}}, "reference.signal.file"),
        ({"name": "/etc/passwd"}, ""),
        ({"changes": {"base": "axis/force"}}, "base"),
    ],
)
def test_a_page_has_no_file_read(home, request_, key):
    with pytest.raises(ScenarioError) as caught:
        page_source(request_, home).assemble()
    assert caught.value.key == key


@pytest.mark.parametrize(
    "changes", [[], "x", {"a": None}, {"a": [1]}, dict.fromkeys(map(str, range(3000)), 1)]
)
def test_what_are_no_changes_is_refused(home, changes):
    with pytest.raises(ScenarioError):
        page_source({"changes": changes}, home)


def test_another_type_begins_with_numbers_of_its_like(done):
    about, _ = done("retype", name="axis/position", path="controller", type="PID")
    assert about["origin"].startswith("axis/")
    assert about["changes"]["controller.type"] == "PID"
    hs.load_scenario("axis/position", about["changes"])


def test_numbers_that_nobody_has_are_asked_for(done):
    about, _ = done("retype", name="axis/position", path="reference", type="Sine")
    assert {one["name"] for one in about["missing"]} == {"amplitude", "frequency"}
    assert next(one for one in about["missing"] if one["name"] == "amplitude")["unit"] == "mm"


def test_errors_lead_to_their_fields():
    assert failure_on_page(ScenarioError("f", "plant.mass", "is wrong")) == {
        "path": "plant.mass",
        "problem": "is wrong",
    }
    assert failure_on_page(ParameterError("plant.mass", 1, "no"))["path"] == "plant.mass"
    assert "a defect of hydroservo: ValueError" in failure_on_page(ValueError("x\ny"))["problem"]


BEFORE = {"name": "axis/position", "before": {"plant.mechanism.mass": "0.2 t"}}


@pytest.mark.parametrize(
    ("path", "text", "said"),
    [
        ("plant.stroke", "63", "63 has no unit: 63 mm?"),
        ("sensors.area_a", "63", "63 has no unit: 63 cm²?"),
        ("load.final", "3", "3 has no unit: 3 kN?"),  # as its scenario writes it
        ("plant.mechanism.mass", "3", "3 has no unit: 3 t?"),  # as the page had it before
        ("plant.oil.air_content", "63", "63 has no unit: 63 %?"),
        ("plant.stroke", "-3 mm", "'-3 mm' must be a finite number above 0 [mm]"),
        (
            "plant.stroke",
            "",
            "'' is not a quantity such as '300 mm'; it must be a finite number above 0 [mm]",
        ),
        (
            "plant.stroke",
            "3 bar",
            "'3 bar' does not convert to mm; it must be a finite number above 0 [mm]",
        ),
        ("plant.start_position", "0.4 m", "0.4 m: must be at most the stroke, 300 mm"),
        ("hold.delay", "50 ms", "50 ms: must be at most the sample period of 1 ms"),
        ("controller.bits", "63", "'63' must be a whole number at least 1 and at most 32"),
    ],
)
def test_what_is_wrong_is_said_in_the_unit_of_its_field(done, home, path, text, said):
    request = {**BEFORE, "changes": {**BEFORE["before"], path: text}}
    with pytest.raises(HydroservoError) as caught:
        done("run", **request)
    assert failure_at_field(caught.value, request, home) == {"path": path, "problem": said}


def test_a_number_that_a_type_asked_for_is_refused_in_its_unit(done):
    asked = {"name": "axis/position", "path": "reference", "type": "Sine"}
    given = {"reference.amplitude": "63", "reference.frequency": "1 Hz"}
    with pytest.raises(ScenarioError, match="63 has no unit: 63 mm"):
        done("retype", **asked, given=given)
    about, _ = done("retype", **asked, given={**given, "reference.amplitude": "63 mm"})
    assert about["missing"] == []
    assert hs.load_scenario("axis/position", about["changes"]).reference.amplitude == 0.063


def test_a_signal_that_does_not_fit_says_why(done):
    with pytest.raises(ScenarioError, match=r"controls.type: Velocity: reference.initial: .* m/s"):
        done("retype", name="axis/position", path="controls", type="Velocity")


def test_an_axis_leaves_out_a_spike_and_says_so():
    wave = 4e5 * np.sin(np.linspace(0.0, 20.0, 2000))
    wave[[300, 900, 1500]] = 12e5, 41e5, 41e5
    found = extent_of([wave, np.zeros(2000)])
    assert (found.low, found.high) == (wave.min(), 12e5)  # a little beyond the others is seen
    assert outliers_text(found, "bar", 1e-5) == "2 samples up to 41.0 bar"


def test_an_axis_shows_what_comes_again_and_a_step_whole():
    kicks = np.zeros(3000)
    kicks[::200] = 10.0
    step = np.where(np.arange(3000) < 2990, 0.0, 1.0)
    for line in (kicks, step):
        assert extent_of([line])[:3] == (0.0, line.max(), 0)


def test_an_axis_of_a_lost_run_shows_what_was_before():
    time = np.arange(1000)
    line = np.sin(0.1 * time) + np.where(time < 960, 0.0, 1.6 ** (time - 960.0))
    line[990:] = np.nan
    found = extent_of([line], diverged=True)
    assert found.high < 10.0
    assert found.most > 100.0 * found.high
    assert extent_of([np.full(9, np.nan)]) is None


def sent(home, signals):
    pd.DataFrame(with_units(signals)).to_csv(home.folder / f"{KEY}.csv", index=False)


def drawn(done, **request):
    """The lines of a log, by signal and name, and what is said of its replay."""
    about, content = done("log", log=KEY, **request)
    rows = iter(np.frombuffer(content, dtype=np.float32).reshape(-1, about["points"])[1:])
    lines = {(one["title"], line["name"]): next(rows) for one in about["panels"] for line in one["lines"]}
    return lines, about["replay"]


def test_a_log_has_its_replay_on_its_axes(done, home):
    """The log is a run of the same machine, which its command must lead through the same motion."""
    sent(home, exact_log())
    lines, said = drawn(done, name=SCENARIO)
    assert said == "Replayed: the recorded command drives the scenario's machine, under the scenario's load"
    measured, replay = lines["velocity", "log"], lines["velocity", "replay"]
    np.testing.assert_allclose(replay[50:], measured[50:], atol=0.01 * np.ptp(measured))
    other, _ = drawn(done, name=SCENARIO, changes={"plant.mass": "20 kg"})
    assert np.abs(other["velocity", "replay"] - measured).max() > 0.1 * np.ptp(measured)


def test_a_log_is_replayed_whatever_its_scenario_records(done, home):
    run = hs.simulate(hs.load_scenario("axis/position"))
    sent(home, {"time": run.time, "command": run["controller.u"], "position": run["plant.position"]})
    lines, _ = drawn(done, name="axis/position", changes={"simulation.record_period": "10 ms"})
    np.testing.assert_array_equal(lines["position", "replay"], lines["position", "log"])


def test_a_log_that_cannot_be_replayed_says_why(done, home):
    log = exact_log()
    sent(home, {name: values for name, values in log.items() if name != "command"})
    assert drawn(done, name=SCENARIO)[1] == "Not replayed: the log has no command"
    sent(home, {**log, "time": 0.1 * log["time"]})
    lines, said = drawn(done, name="axis/position")
    assert said.startswith("Not replayed: hold.delay = 0.0005: must be at most the sample period")
    assert {name for _, name in lines} == {"log"}
