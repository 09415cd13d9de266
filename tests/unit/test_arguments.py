"""Whatever the functions of ``import hydroservo as hs`` are given in place of the right kind: one line."""

import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import hydroservo as hs

NAME = "paper/sine-pi"
RANGES = {"controller.proportional_gain": (1.0, 2.0)}
WRONG = [3, None, [], {}, "axis.toml", Path("axis.toml"), hs.Loop]


@pytest.fixture(scope="module")
def loop() -> hs.Loop:
    return hs.load_scenario(NAME, {"simulation.duration": "1 ms", "simulation.period": "1 ms"})


@pytest.fixture(scope="module")
def run(loop: hs.Loop) -> Any:
    return hs.simulate(loop, compiled=False)


@pytest.fixture(scope="module")
def table(run: Any) -> Any:
    """As one of a batch: a dimension for the runs, and no trajectory."""
    return run.drop_dims("time").expand_dims("run")


def refused(call: Callable[[], object]) -> str:
    """What is said, in one line and without the ways that it took."""
    with pytest.raises(hs.HydroservoError) as error:
        call()
    assert "\n" not in str(error.value)
    assert len(traceback.format_exception(error.value)) < 20
    return str(error.value)


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize(
    "function",
    [
        hs.simulate,
        lambda wrong: hs.simulate_batch(wrong, {"plant.mass": [6.0]}),
        lambda wrong: hs.draws(wrong, {"plant.mass": (6.0, 7.0)}, 2),
        lambda wrong: hs.run_of(wrong, None, 0),  # type: ignore[arg-type]
        lambda wrong: hs.export_c(wrong, "folder"),
        lambda wrong: hs.export_fmu(wrong, "unit.fmu"),
        lambda wrong: hs.tune(hs.Aim([wrong]), RANGES),
    ],
)
def test_what_is_no_loop(function: Callable[[Any], object], wrong: Any, tmp_path: Path) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        said = refused(lambda: function(wrong))
    assert ": must be a Loop" in said
    assert ("load_scenario('axis.toml') makes one" in said) == isinstance(wrong, str | Path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("wrong", [3, None, [], {}, "axis.toml", hs.Loop, "loop", "table"])
@pytest.mark.parametrize(
    ("function", "says"),
    [
        (hs.metrics_of, "dataset = {}: must be what simulate returned"),
        (hs.differences, "runs = {}: must be a list of what simulate returned"),
        (lambda wrong: hs.differences([wrong]), "runs[0] = {}: must be what simulate returned"),
        (hs.winners, "runs = {}: must be a list of what simulate returned"),
        (lambda wrong: hs.winners([wrong]), "runs[0] = {}: must be what simulate returned"),
        (lambda wrong: hs.plot([wrong]), "results[0] = {}: must be what simulate returned"),
    ],
)
def test_what_is_no_run(
    function: Callable[[Any], object], says: str, wrong: Any, loop: hs.Loop, table: Any
) -> None:
    given = {"loop": (loop, "a Loop"), "table": (table, "a Dataset")}
    value, shown = given[wrong] if isinstance(wrong, str) and wrong in given else (wrong, repr(wrong))
    assert refused(lambda: function(value)).startswith(says.format(shown))


def test_one_run_is_no_list_of_runs(run: Any) -> None:
    for function in (hs.differences, hs.winners):
        assert refused(lambda function=function: function(run)).startswith("runs = a Dataset: must be a list")
        assert function([run]) is not None


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (hs.plot, "results = a Loop: must be what simulate or simulate_batch returned"),
        (lambda _: hs.plot(3), "results = 3: must be what"),  # type: ignore[arg-type]
        (lambda _: hs.plot([]), "results = []: must be a list of what simulate returned, with at least"),
        (lambda _: hs.save(3, "x.csv"), "dataset = 3: must be what simulate"),  # type: ignore[arg-type]
        (
            lambda loop: hs.simulate(loop, record="plant.velocity"),
            "record = 'plant.velocity': must be a list",
        ),
        (lambda loop: hs.simulate(loop, record=[3]), "record = 3: must be a string such as"),
        (lambda loop: hs.replace(loop, None), "changes = None: must map paths to values"),
        (lambda loop: hs.replace(loop, {3: 1.0}), "path = 3: must be a string such as"),
        (lambda _: hs.replace("plant", {}), "block = 'plant': must be a block"),
        (
            lambda loop: hs.simulate(hs.replace(loop, {"metrics": {"effort": hs.monitors.Energy()}})),
            "metrics = {'effort': Energy()}: must be a block: a NamedTuple with the methods of its role; "
            "simulate, simulate_batch and Aim take monitors as metrics",
        ),
        (lambda loop: hs.simulate_batch(loop, ["plant.mass"]), "parameters = ['plant.mass']: must map"),
        (lambda loop: hs.simulate_batch(loop, {3: [1.0]}), "parameters = 3: must be a string such as"),
        (
            lambda loop: hs.simulate_batch(loop, {"plant.mass": "6 kg"}),
            "plant.mass = '6 kg': must be an array",
        ),
        (lambda loop: hs.simulate_batch(loop, {"plant.mass": loop.plant}), "plant.mass = LoadPressurePlant"),
        (lambda _: hs.load_scenario(3), "source = 3: must be the name of a scenario"),
        (hs.load_scenario, "source = a Loop: must be the name of a scenario"),
        (lambda _: hs.load_scenario(NAME, "plant.mass=7"), "changes = 'plant.mass=7': must map paths"),
        (lambda _: hs.load_scenario(NAME, {}, "my.py"), "plugins = 'my.py': must be a list of files"),
        (lambda _: hs.load_scenario(NAME, {}, [3]), "plugins = 3: must be a path"),
        (lambda _: hs.tune(3), "aim = 3: must be an Aim"),
        (lambda _: hs.tune(NAME, ["a"]), "ranges = ['a']: must map paths to ranges"),
        (lambda _: hs.tune(NAME, RANGES, changes="a=1"), "changes = 'a=1': must map paths"),
        (lambda loop: hs.tune(hs.Aim(loop), RANGES), "loops = a Loop: must be a list of loops"),
        (lambda loop: hs.tune(hs.Aim([loop], 3), RANGES), "weights = 3: must be a number above 0"),
        (lambda loop: hs.draws(loop, "a", 3), "ranges = 'a': must map paths to ranges"),
        (lambda loop: hs.run_of(loop, loop, 0), "table = a Loop: must be what simulate_batch returned"),
        (lambda loop: hs.export_c(loop, 3), "folder = 3: must be a path"),
        (lambda loop: hs.export_c(loop, "folder", name=[]), "name = []: must be a string"),
        (lambda loop: hs.export_c(loop, "folder", prefix=3), "prefix = 3: must be letters"),
        (
            lambda loop: hs.export_fmu(loop, "a.fmu", platforms="x86_64-linux"),
            "platforms = 'x86_64-linux': must be",
        ),
    ],
)
def test_what_is_of_another_kind(
    call: Callable[[Any], object], says: str, loop: hs.Loop, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert refused(lambda: call(loop)).startswith(says)
    assert not list(tmp_path.iterdir())


def test_what_is_given_may_be_any_iterable(loop: hs.Loop, run: Any) -> None:
    recorded = hs.simulate(loop, record=iter(["plant.velocity"]), compiled=False)  # type: ignore[arg-type]
    assert "plant.velocity" in recorded
    assert hs.differences({"a": run, "b": run}.values()) == {}  # type: ignore[arg-type]
