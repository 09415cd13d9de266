"""A page that runs a loop: the bits of its WebAssembly, what it refuses, and what a browser makes of it."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.core.errors import HydroservoError, LoopError, ParameterError, ScenarioError
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.page import check_bits, export_page, metric_columns, recorded_paths, write_page
from hydroservo.export.products import Export
from hydroservo.export.unit import CModule, Part
from hydroservo.export.wasm import Replay, WasmLoop, wasm_of
from hydroservo.export.watched import page_monitors, watched_loop
from hydroservo.runs.trace import Trace
from hydroservo.scenario import assemble
from hydroservo.scenario.ranges import as_entries
from tests.support.browser import browser
from tests.support.export.foreign import foreign_load
from tests.support.needs import needs
from tests.support.scenarios import LOOPS
from tests.support.tiers import mostly

GAIN = "controller.proportional_gain"
PI = "rig/1khz-pi-sine"
MOST = 300_000  # bytes
DESIGNED = ("laws/lq", "laws/mpc", "laws/h-infinity", "laws/internal")  # by what is varied
OFTEN = ["axis/position", "cases/limits", "laws/lq-sine"]


def replayed(loop: hs.Loop, **values: float) -> tuple[CModule, Replay, Trace]:
    """A loop as WebAssembly and as a strict run, with the same values of one parameter or none."""
    unit = exported_unit(loop, Part.LOOP, prefix="loop", title="loop", block=watched_loop)
    changes = {path.replace("__", "."): value for path, value in values.items()}
    sliders = [signal for signal in unit.parameters if signal.path in changes]
    record = recorded_paths(unit)
    run = hs.prepare_run(loop, record=record, metrics=page_monitors(loop), strict=True)
    wasm = WasmLoop(wasm_of(unit, sliders), unit, len(sliders))
    found = wasm.replay([changes[one.path] for one in sliders], run.plan.samples, run.plan.stride)
    return unit, found, run(changes)


def compare(unit: CModule, found: Replay, run: Trace) -> None:
    at = {signal.path: i for i, signal in enumerate(unit.states)}
    check_bits(found, run, {path: at[path] for path in run.wanted} | metric_columns(unit, run), "here")


def page_of(name: str, file: Path) -> tuple[Export, list[str]]:
    """The page of a scenario, with sliders for what ``hydroservo tune`` varies, or else for its demand."""
    described = assemble(name)
    loop, ranges = described.loop, {path: one.entry for path, one in described.search.ranges.items()}
    demand = "amplitude" if hasattr(loop.reference, "amplitude") else "max_rate"
    if name.startswith(DESIGNED):
        with pytest.raises(HydroservoError, match="choose another number"):
            write_page(loop, file, ranges, fitting_only=True)
    if name.startswith(DESIGNED) or not ranges:
        ranges = as_entries({f"reference.{demand}": hs.relative(-0.2, 0.2)})
    return write_page(loop, file, ranges, fitting_only=True, name=name)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::hydroservo.HydroservoWarning")
@pytest.mark.parametrize("name", mostly(pytest.mark.nightly, LOOPS, OFTEN))
def test_built_in_scenarios_bit_for_bit(name: str, tmp_path: Path) -> None:
    found, sliders = page_of(name, tmp_path / "page.html")
    simulation = hs.load_scenario(name).simulation
    rows = math.floor(simulation.duration / max(simulation.record_period, simulation.period) + 1e-9) + 1
    assert len(sliders) >= 1
    assert found.proof.samples == rows * (1 + 2 * len(sliders))
    assert (tmp_path / "page.html").stat().st_size < MOST


@pytest.mark.slow
@pytest.mark.parametrize("integrator", ["Tsit5", "Rosenbrock"])
def test_integrators_that_choose_their_steps(integrator: str) -> None:
    changes = {"simulation.integrator.type": integrator, "simulation.duration": "0.1 s"}
    compare(*replayed(hs.load_scenario("rig/excavator-link", changes)))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::hydroservo.HydroservoWarning")
def test_a_run_that_is_lost_ends_where_the_simulation_does() -> None:
    changes = {
        "simulation.period": "1 ms",
        "simulation.duration": "0.1 s",
        "simulation.record_period": "3 ms",
    }
    unit, found, run = replayed(hs.load_scenario("paper/sine-pi", changes), plant__mass=0.01)
    assert run["diverged"]
    assert found.reached * unit.period == run["diverged_at"]
    assert len(found.rows) == found.reached // 3 + 1
    compare(unit, found, run)


@pytest.mark.slow
def test_an_open_loop_has_no_error(tmp_path: Path) -> None:
    changes = {"controls.type": "Command", "controller.type": "OpenLoop", "simulation.duration": "50 ms"}
    changes["reference.amplitude"] = "20 mV"
    loop = hs.load_scenario(PI, changes)
    unit, found, run = replayed(loop)
    compare(unit, found, run)
    assert not [name for name in run.metrics if "error" in name]
    export_page(loop, tmp_path / "page.html", {"reference.amplitude": "10..30 mV"})
    assert '"name": "error"' not in (tmp_path / "page.html").read_text()


@pytest.mark.slow
def test_another_number_is_seen(tmp_path: Path) -> None:
    loop = hs.load_scenario(PI, {"simulation.duration": "50 ms"})
    unit, found, run = replayed(loop, controller__proportional_gain=4.0)
    compare(unit, found, run)
    beside = np.nextafter(4.0, 5.0)
    other = replayed(loop, controller__proportional_gain=beside)[1]
    with pytest.raises(LoopError, match=r"nothing is written: here, .* is not that of the simulation"):
        compare(unit, other, run)
    found.last[metric_columns(unit, run)["rms_error"]] *= 1.0 + 1e-15
    with pytest.raises(LoopError, match="here, rms_error of the page"):
        compare(unit, found, run)


@pytest.mark.parametrize(
    ("sliders", "said"),
    [
        ({}, "must name numbers"),
        ({3: (1.0, 2.0)}, "must name numbers"),
        ({"controller.nothing": (1, 2)}, "sliders: controller.nothing: must be one of controller."),
        ({"simulation.period": (1, 2)}, "is not a number that can vary"),
        ({GAIN: (2.0, 1.0)}, "is more than"),
        ({GAIN: (4.0, 4.0)}, "is not a range"),
        ({GAIN: (4.0, 5.0)}, "must hold the value of the loop, 3.23 V s/m"),
        ({GAIN: "1..5 kg"}, "does not convert to V s/m"),
        ({"command.share": (0.0, 1.0)}, "is not a number that the exported loop reads"),
    ],
)
def test_sliders_that_cannot_be(sliders: dict[str, Any], said: str, tmp_path: Path) -> None:
    with pytest.raises((ParameterError, ScenarioError), match=said) as caught:
        export_page(hs.load_scenario(PI), tmp_path / "page.html", sliders)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_what_is_designed_before_a_run_cannot_be_moved(tmp_path: Path) -> None:
    loop = hs.load_scenario("laws/lq-sine")
    with pytest.raises(
        ScenarioError,
        match=r"effort: cannot be a slider: before a run, it decides controller.gain_1 and 2 others",
    ):
        export_page(loop, tmp_path / "page.html", {"controller.effort": hs.relative(-0.5, 0.5)})


def test_other_loops_and_files_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    loop, sliders = hs.load_scenario(PI), {GAIN: (1.0, 9.0)}
    with pytest.raises(HydroservoError, match=r"page.txt: its name must end in .html"):
        export_page(loop, tmp_path / "page.txt", sliders)
    with pytest.raises(LoopError, match=r"the load is the FMU .* nothing can write a page"):
        export_page(foreign_load(), tmp_path / "page.html", sliders)
    monkeypatch.setattr("hydroservo.export.wasm.PACKAGES", ("ziglang", "no_compiler"))
    with pytest.raises(HydroservoError, match=r"no_compiler: pip install 'hydroservo\[page\]'"):
        export_page(loop, tmp_path / "page.html", sliders)


def test_a_page_that_fails_leaves_the_old_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    (tmp_path / "page.html").write_text("old")
    monkeypatch.setattr("hydroservo.export.wasm.zig", lambda: sys.executable)
    monkeypatch.setattr("hydroservo.export.wasm.TARGET", ("-c", "exit('error: no')"))
    with pytest.raises(HydroservoError, match="fails: error: no") as caught:
        export_page(hs.load_scenario(PI), tmp_path / "page.html", {GAIN: (1.0, 9.0)})
    assert "\n" not in str(caught.value)
    assert [one.read_text() for one in tmp_path.iterdir()] == ["old"]


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    needs("chromium")
    with browser() as found:
        yield found


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page with two sliders, whose title is not HTML."""
    path = tmp_path_factory.mktemp("page") / "page.html"
    sliders = {GAIN: "0.3..30 V s/m", "plant.mass": hs.relative(-0.5, 0.5)}
    export_page(hs.load_scenario(PI), path, sliders, name=PI, title="</script><b>A & B")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1024])
def test_a_browser_runs_it_by_keys_alone(chromium: Any, file: Path, scheme: str, width: int) -> None:
    from axe_playwright_python.sync_playwright import Axe

    context = chromium.new_context(
        viewport={"width": width, "height": 844}, color_scheme=scheme, bypass_csp=True, offline=True
    )
    page = context.new_page()
    wrong: list[str] = []
    asked: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda line: wrong.append(line.text))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(file.as_uri())
    page.wait_for_selector("body[data-run]")
    assert "default-src 'none'" in file.read_text()
    assert page.inner_text("h1") == "</script><b>A & B"
    first = page.evaluate("now.metrics")
    page.get_by_role("slider", name="proportional gain").focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_selector("body[data-run='2']")
    value, found = page.evaluate("[values[0], now.metrics]")
    run = hs.prepare_run(hs.load_scenario(PI), record=["controlled.value"], strict=True)
    names = page.evaluate("known.metrics.map((one) => one.meaning)")
    expected = run({GAIN: value})
    by_meaning = {expected.fields[name].meaning: float(one) for name, one in expected.metrics.items()}
    assert found == [by_meaning[name] for name in names]
    assert found != first
    assert page.evaluate("now.signal") == expected["controlled.value"].tolist()
    page.get_by_role("button", name="Reset").press("Enter")
    page.wait_for_selector("body[data-run='3']")
    assert page.evaluate("now.metrics") == first
    serious = [one["id"] for one in Axe().run(page).response["violations"] if one["impact"] != "minor"]
    assert serious == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert wrong == []
    assert asked == [file.as_uri()]
    context.close()
