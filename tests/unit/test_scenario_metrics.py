"""[metrics] of a scenario: which monitors a run has, and what is refused."""

from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from hydroservo import Loop, LoopError, ScenarioError, monitors, simulate
from hydroservo.control.controllers import PI
from hydroservo.control.metrics import declared_metrics, monitors_of, usual
from hydroservo.control.monitors.group import Usual
from hydroservo.core.group import group
from hydroservo.runs.provenance import canonical_toml, scenario_hash
from hydroservo.runs.results import metric_fields, metrics_of
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example
from tests.support.bases import CYLINDER, on_base
from tests.support.equality import assert_same_block

pytestmark = pytest.mark.usefixtures("forgotten")

SHORT = """\
[simulation]
duration = "20 ms"
period = "1 ms"
substeps = 20

"""
LOOP = on_base(f'{SHORT}[controller]\ntype = "PI"\nproportional_gain = "0.3 V s/m"\n')
USUAL = ["tracking_error", "step_response", "oscillation", "command_effort", "piston_travel"]
PLUGIN = '''\
from typing import Annotated, NamedTuple

from hydroservo import Field, ops
from hydroservo.core.roles import Monitor, role


class TopSpeedState(NamedTuple):
    top: Annotated[float, Field("m/s", "largest speed so far")]


class TopSpeedValues(NamedTuple):
    top_speed: Annotated[float, Field("m/s", "largest speed", smaller_is_better=True)]
    fast: Annotated[bool, Field("", "it was above the limit")]


@role(Monitor)
class TopSpeed(NamedTuple):
    """The largest speed of the piston."""

    limit: Annotated[float, Field("m/s", "what is fast", above=0)] = 0.1

    def init(self):
        return TopSpeedState(0.0)

    def step(self, m, loop, s, t, dt):
        return TopSpeedState(ops.maximum(ops.absolute(s.plant.velocity), m.top))

    def values(self, m):
        return TopSpeedValues(m.top, m.top > self.limit)
'''


@pytest.fixture
def write(tmp_path: Path):
    """Writes a file, by its name, and gives its path."""

    def written(text: str, name: str = "my.toml") -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return written


@pytest.fixture
def loaded(write):
    """The loop of a scenario with some lines at its end."""
    return lambda text="": load_scenario(write(LOOP + text))


def run(loop: Loop, **options: Any) -> xr.Dataset:
    """A run without its trajectory."""
    return simulate(loop, record=[], compiled=False, **options)


def refused(path: Path, changes: dict[str, object] | None = None) -> str:
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path, changes)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    "text", ["", "[metrics]\n", "[metrics]\nusual = true\n"], ids=["none", "empty", "usual"]
)
def test_the_usual_metrics_need_no_table(loaded, text: str) -> None:
    loop = loaded(text)
    assert list(monitors_of(loop)) == USUAL
    assert_same_block(group(monitors_of(loop)), group(usual(loop)))
    if "usual" not in text:
        assert isinstance(loop.metrics, Usual)


@pytest.mark.parametrize(
    ("law", "changes", "more"),
    [
        ("tsmc", {}, {"disturbance"}),
        ("pi", CYLINDER, {"chamber_pressures"}),
        ("tsmc", CYLINDER, {"disturbance", "chamber_pressures"}),
        ("backstepping", {}, set()),  # a model, but no estimates
    ],
    ids=["observer", "chambers", "both", "model"],
)
def test_what_is_usual_depends_on_the_loop(
    write, law: str, changes: dict[str, object], more: set[str]
) -> None:
    loop = load_scenario(write(on_base(SHORT + "[metrics.energy]\ntype = 'Energy'", law)), changes)
    assert set(monitors_of(loop)) == {*USUAL, *more, "energy"}


def test_metrics_of_one_s_own_come_besides_the_usual_ones(write, loaded) -> None:
    own = 'metrics.power = {type = "CommandEnergy", limit = 9}\nmetrics.criteria.type = "IntegralCriteria"\n'
    loop = load_scenario(write(own + LOOP))
    assert list(monitors_of(loop)) == [*USUAL, "power", "criteria"]
    assert_same_block(loop.metrics.power, monitors.CommandEnergy(limit=9.0))
    found = metrics_of(run(loop))
    assert {"rms_error", "iae", "itae", "control_energy", "saturation_share", "diverged"} < set(found)
    without = metrics_of(run(loaded()))
    assert {name: found[name] for name in without} == pytest.approx(without, nan_ok=True, rel=0.0, abs=0.0)


def test_one_of_a_usual_name_takes_its_place(loaded) -> None:
    text = '[metrics.step_response]\nband = "1 %"\n[metrics.piston_travel]\ntype = "RiseTime"'
    loop = loaded(text)
    assert list(monitors_of(loop)) == USUAL
    assert_same_block(loop.metrics.step_response, monitors.StepResponse(band=0.01))
    assert_same_block(loop.metrics.piston_travel, monitors.RiseTime())
    metrics = declared_metrics(monitors_of(loop))
    assert "rise_time" in metrics
    assert "position_max" not in metrics


def test_a_second_one_of_a_type_has_its_name_before_its_metrics(loaded) -> None:
    loop = loaded('[metrics.tight]\ntype = "StepResponse"\nband = 0.01')
    data = run(loop)
    assert float(data["tight_settling_time"]) >= float(data["settling_time"])
    assert metric_fields(data)["tight_settling_time"].smaller_is_better


def test_the_usual_ones_are_those_of_the_law_that_runs(write) -> None:
    """Of one that is put into the loop after it was loaded, too."""
    loop = load_scenario(write(on_base(SHORT + '[metrics.energy]\ntype = "Energy"', "tsmc")))
    assert list(monitors_of(loop)) == [*USUAL[:4], "disturbance", USUAL[4], "energy"]
    changed = loop._replace(controller=example(PI))
    assert list(monitors_of(changed)) == [*USUAL, "energy"]
    assert not run(changed)["diverged"]


def test_the_usual_ones_can_be_left_out(loaded) -> None:
    loop = loaded('[metrics]\nusual = false\ncriteria.type = "IntegralCriteria"')
    assert list(monitors_of(loop)) == ["criteria"]
    data = run(loop)
    assert set(metrics_of(data)) == {"iae", "ise", "itae", "diverged", "diverged_at"}
    none = loaded("[metrics]\nusual = false")
    assert monitors_of(none) == {}
    assert set(metrics_of(run(none))) == {"diverged", "diverged_at"}


def test_metrics_of_a_scenario_give_way_to_those_of_a_call(loaded) -> None:
    loop = loaded('[metrics.energy]\ntype = "Energy"')
    data = run(loop, metrics=[monitors.PistonTravel()])
    assert set(metrics_of(data)) == {"position_min", "position_max", "stroke_left", "diverged", "diverged_at"}


def test_what_a_run_is_judged_by_is_no_part_of_the_scenario(loaded) -> None:
    plain, judged = (loaded(text) for text in ("", '[metrics.energy]\ntype = "Energy"'))
    assert scenario_hash(plain) == scenario_hash(judged)
    assert canonical_toml(plain) == canonical_toml(judged)


def test_changes_lie_on_top(write) -> None:
    path = write(LOOP + '[metrics.criteria]\ntype = "IntegralCriteria"')
    changes = {"metrics.usual": False, "metrics.effort.type": "CommandEffort"}
    assert list(monitors_of(load_scenario(path, changes))) == ["criteria", "effort"]
    assert load_scenario(path, {"metrics.step_response.band": "2 %"}).metrics.step_response.band == 0.02
    retyped = load_scenario(path, {"metrics.criteria.type": "Energy"})
    assert_same_block(retyped.metrics.criteria, monitors.Energy())


def test_metrics_of_a_base_are_those_of_what_builds_on_it(write) -> None:
    write(
        LOOP + '[metrics.tight]\ntype = "StepResponse"\nband = 0.01\n[metrics.e]\ntype = "Energy"',
        "base.toml",
    )
    loop = load_scenario(
        write('base = "base.toml"\n[metrics.tight]\nband = 0.02\n[metrics.r]\ntype = "RiseTime"')
    )
    assert list(monitors_of(loop)) == [*USUAL, "tight", "e", "r"]
    assert_same_block(loop.metrics.tight, monitors.StepResponse(band=0.02))
    own = write('base = "base.toml"\n[metrics]\nusual = false\ntight.type = "RiseTime"')
    others = {"tight": monitors.RiseTime(), "e": monitors.Energy()}
    assert_same_block(group(monitors_of(load_scenario(own))), group(others))


def test_a_monitor_of_one_s_own(write) -> None:
    plugin = write(PLUGIN, "speed.py")
    path = write(LOOP + '[metrics.speed]\ntype = "TopSpeed"\nlimit = "1 um/s"')
    loop = load_scenario(path, plugins=[plugin])
    data = simulate(loop, compiled=False)
    assert float(data["top_speed"]) == pytest.approx(abs(data["plant.velocity"].values).max(), rel=0.2)
    assert bool(data["fast"]) is True
    assert data["top_speed"].attrs["units"] == "m/s"
    assert data["top_speed"].attrs["better"] == "smaller"
    assert data["speed.top"].values[-1] <= float(data["top_speed"])
    compiled = simulate(loop, strict=True)
    assert metrics_of(compiled) == pytest.approx(metrics_of(data), nan_ok=True, rel=0.0, abs=0.0)


@pytest.mark.parametrize(
    ("text", "key", "problem"),
    [
        ("metrics = 3", "metrics", "3 must be a table: [metrics]"),
        (
            "metrics.usual = 1",
            "metrics.usual",
            "1 must be true or false: whether the usual metrics count too",
        ),
        ('metrics.usual = "no"', "metrics.usual", "must be true or false"),
        ("metrics.energy = true", "metrics.energy", "must be a table: [metrics.energy]"),
        ("[metrics.mine]", "metrics.mine", "a type is needed; it must be one of "),
        ("[metrics.mine]\nlimit = 3", "metrics.mine", "a type is needed; it must be one of "),
        (
            'metrics.mine.type = "Enery"',
            "metrics.mine.type",
            "'Enery' is not a type here; did you mean Energy?",
        ),
        ('metrics.mine.type = "Enery"', "metrics.mine.type", "did you mean Energy?"),
        (
            'metrics.mine.type = "PI"',
            "metrics.mine.type",
            "'PI' cannot be a Monitor: it says that its role is Controller",
        ),
        ("metrics.mine.type = 3", "metrics.mine.type", "3 must be one of "),
        ('metrics.mine = {type = "RiseTime", hihg = 0.8}', "metrics.mine.hihg", "unknown key (value 0.8)"),
        ('metrics.mine = {type = "RiseTime", hihg = 0.8}', "metrics.mine.hihg", "did you mean high?"),
        ("metrics.step_response.band = -1", "metrics.step_response.band", "must be a finite number above 0"),
        (
            'metrics.step_response.band = "1 V"',
            "metrics.step_response.band",
            "'1 V' is not dimensionless; it must be",
        ),
        (
            'metrics."my own".type = "Energy"',
            "metrics.my own",
            "must stand under a name of letters, digits and",
        ),
        ('metrics._own.type = "Energy"', "metrics._own", "must stand under a name of letters, digits and"),
        ('metrics.class.type = "Energy"', "metrics.class", "must stand under a name of letters, digits and"),
        ('metrics.2nd.type = "Energy"', "metrics.2nd", "must stand under a name of letters, digits and"),
    ],
)
def test_what_is_wrong_is_one_line(write, text: str, key: str, problem: str) -> None:
    text = f"{text}\n{LOOP}" if not text.startswith("[") else LOOP + text
    path = write(text)
    said = refused(path)
    assert said.startswith(f"{path}: {key}: ")
    assert problem in said


def test_what_a_base_has_wrong_is_of_that_file(write) -> None:
    base = write(LOOP + '[metrics.mine]\ntype = "Enery"', "base.toml")
    assert refused(write('base = "base.toml"')).startswith(
        f"{base}: metrics.mine.type: 'Enery' is not a type here; did you mean Energy?"
    )


def test_a_monitor_that_does_not_fit_the_loop_is_named(loaded) -> None:
    loop = loaded('[metrics.seen]\ntype = "ChamberPressures"')
    with pytest.raises(LoopError) as caught:
        simulate(loop, compiled=False)
    said = str(caught.value)
    assert said.startswith("the metric seen (ChamberPressures) does not fit this loop: ")
    assert "pressure_a" in said
    assert "\n" not in said
    known = loaded('[metrics.d]\ntype = "Disturbance"')
    with pytest.raises(LoopError, match=r"^the metric d \(Disturbance\) does not fit this loop: "):
        simulate(known, compiled=False)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("return TopSpeedState(ops", "return (ops", "a step must return a state of init's type"),
        ("return TopSpeedState(0.0)", "return TopSpeedState(0)", "with floats only"),
        ("m.top > self.limit)", "'much')", "values must be a NamedTuple of floats and flags"),
        ("s.plant.velocity", "s.plant.speed", "'speed'"),
    ],
)
def test_a_monitor_of_one_s_own_that_is_none_is_told_so(write, old: str, new: str, says: str) -> None:
    assert old in PLUGIN
    plugin = write(PLUGIN.replace(old, new).replace("TopSpeed", "Wrong"), "wrong.py")
    loop = load_scenario(write(LOOP + '[metrics.own]\ntype = "Wrong"'), plugins=[plugin])
    with pytest.raises(LoopError) as caught:
        simulate(loop, compiled=False)
    assert str(caught.value).startswith("the metric own")
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_monitor_that_lacks_a_method_is_refused_where_it_is_loaded(write) -> None:
    plugin = write(PLUGIN.replace("def values(self, m)", "def value(self, m)"), "lame.py")
    with pytest.raises(ScenarioError, match=r"lame\.py: line \d+: .*TopSpeed.* Monitor.* values"):
        load_scenario(write(LOOP), plugins=[plugin])


def test_a_search_takes_a_metric_that_was_asked_for(write, loaded) -> None:
    tune = '[tune]\nmetric = "itae"\nvary.controller.proportional_gain = "0.1..1 V s/m"\n'
    assert "tune.metric: 'itae' must be one of rms_error, " in refused(write(LOOP + tune))
    loaded(tune + '[metrics.criteria]\ntype = "IntegralCriteria"')
