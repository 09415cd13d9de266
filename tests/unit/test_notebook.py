"""What a notebook shows: results at a glance, and how far a search is."""

import re
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from IPython.core.interactiveshell import InteractiveShell

import hydroservo as hs
from hydroservo.core.formatting import number
from hydroservo.linear import margins
from hydroservo.notebook import result_html, show_results_in
from hydroservo.testing.examples import example
from hydroservo.work import notebook_bar
from hydroservo.work.notebook_bar import Bar, shows_progress
from tests.support.synthetic_logs import RANGES, SCENARIO, SHORT, exact_log, recorded

BRIEF = SHORT | {"simulation.duration": "0.5 s", "reference.period": "0.2 s"}


@pytest.fixture(scope="module")
def loop():
    return hs.load_scenario("rig/1khz-pi-sine", {"simulation.duration": "0.2 s"})


@pytest.fixture(scope="module")
def run(loop):
    return hs.simulate(loop)


def rows_of(page):
    """The rows of a page's tables, by their first cell."""
    tree = ElementTree.fromstring(f"<div>{page}</div>")
    rows = [["".join(one.itertext()) for one in row] for row in tree.iter("tr")]
    return {row[0]: row[1:] for row in rows}


def plain(page):
    """A page without the random names of xarray's sections."""
    return re.sub(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}", "", page)


def glance(data):
    """The tables above the data, for those of xarray are no XML."""
    card, found, _ = result_html(data).partition("<details>")
    assert found
    return card


def test_a_run_has_its_metrics_in_units_of_datasheets(run):
    page = glance(run)
    number, unit, meaning = rows_of(page)["rms_error"]
    assert unit == "mm/s"
    assert float(number) == pytest.approx(1e3 * float(run["rms_error"]), rel=5e-4)
    assert meaning == run["rms_error"].attrs["long_name"]
    assert "did not diverge" in page
    assert "200 ms at 1000 Hz" in page


def test_a_run_that_diverged_says_when_and_by_what(run):
    lost = run.assign(diverged=((), True), diverged_at=((), 0.125)).assign_attrs(diverged_by="plant.<x>")
    assert "<b>The run diverged</b>: plant.&lt;x&gt; stopped being finite at 125 ms." in glance(lost)


def test_many_runs_have_what_varied_and_quantiles(loop):
    masses = np.linspace(4.0, 8.0, 11)
    table = hs.simulate_batch(loop, {"plant.mass": masses})
    rows = rows_of(glance(table))
    assert rows["plant.mass"][:3] == ["4", "8", "kg"]
    expected = 1e3 * float(table["rms_error"].quantile(0.95))
    assert float(rows["rms_error"][2]) == pytest.approx(expected, rel=5e-3)
    assert "No run diverged" in glance(table)
    assert "1 of 11 runs diverged" in glance(table.assign(diverged=("run", np.arange(11) == 3)))


def test_a_frequency_response_has_its_margins(loop):
    data = hs.bode(loop, measure=False)
    rows = rows_of(glance(data))
    degrees, unit = rows["phase margin"]
    assert unit == "\N{DEGREE SIGN}"
    assert float(degrees) == pytest.approx(np.degrees(float(data["phase_margin"])), rel=5e-3)
    assert rows["phase margin"] == rows_of(margins(loop)._repr_html_())["phase margin"]


@pytest.mark.parametrize(
    "data", [xr.Dataset(), xr.Dataset({"rms_error": 1.0}), xr.Dataset({"a": ("run", [1.0])})]
)
def test_any_other_dataset_looks_as_ever(data):
    assert plain(result_html(data)) == plain(data._repr_html_())


def test_what_is_left_of_a_run_looks_as_a_dataset_does(run):
    part = run[["plant.velocity"]]
    assert plain(result_html(part)) == plain(part._repr_html_())


def test_a_linear_model_has_its_poles(loop):
    model = hs.linearize(loop, command=0.1)
    page = model._repr_html_()
    assert "in continuous time" in page
    (pair,) = model.poles[model.poles.imag > 0.0]
    imaginary, frequency, _ = rows_of(page)[number(pair.real, 5)]
    assert float(imaginary) == pytest.approx(pair.imag, rel=5e-5)
    assert float(frequency) == pytest.approx(abs(pair) / (2.0 * np.pi), rel=5e-5)
    assert "sampled every 1.00 ms" in hs.linearize(loop, "loop")._repr_html_()


def test_a_search_has_its_values_and_the_metric_before_and_after(loop):
    found = hs.tune(hs.Aim([loop]), {"controller.proportional_gain": (0.3, 30.0)}, candidates=64)
    page, _, standing = found._repr_html_().partition("<div>Margins while moving.</div>")
    rows = rows_of(page)
    gain = dict(zip(rows["parameter"], rows["controller.proportional_gain"], strict=True))
    assert gain["unit"] == "V s/m"
    best = found.parameters["controller.proportional_gain"]
    shown = [float(gain[name]) for name in ("best", "from", "to")]
    assert shown == pytest.approx([best, 0.3, 30.0], rel=1e-4)
    metrics = dict(zip(rows["loop"], rows["loop 1"], strict=True))
    assert float(metrics["after [mm/s]"]) == pytest.approx(1e3 * found.after[0], rel=5e-4)
    assert "64 closed loops were simulated" in page
    assert "phase margin" in rows_of(standing)["machine"]


def test_an_identification_has_its_intervals():
    found = hs.identify(SCENARIO, recorded(exact_log(BRIEF), 0), RANGES, changes=BRIEF, threads=1)
    row = rows_of(found._repr_html_())["plant.mass"]
    value, low, high = map(float, row[:3])
    assert low <= value <= high
    assert row[3:5] == ["kg", "tell it"]


def test_an_audit_has_its_verdicts():
    page = hs.audit(hs.load_scenario("rig/1khz-pi-sine", {"simulation.duration": "0.2 s"}))._repr_html_()
    assert "chatter" in page
    rows_of(page)


def test_a_notebook_shows_results_by_it_and_other_datasets_as_ever(run):
    shell = InteractiveShell()
    show_results_in(shell)
    show = shell.display_formatter.formatters["text/html"]
    assert "did not diverge" in show(run)
    other = xr.Dataset({"a": 1.0})
    assert plain(show(other)) == plain(other._repr_html_())
    assert show(pd.DataFrame({"a": [1]})).startswith("<div>")


@shows_progress
def work(*, progress=None):
    """Reports thrice, the last time after what it calls."""
    if progress is not None:
        progress(0.25)
        inner = inside()
        progress(1.0, 3.0)
        return progress, inner
    return None, None


@shows_progress
def inside(*, progress=None):
    return progress


@pytest.fixture
def pages(monkeypatch):
    """What a notebook shows, update by update, if all takes long."""
    shown = []

    def display(page, display_id):
        assert display_id
        shown.append(page.data)
        return SimpleNamespace(update=lambda page: shown.append(page.data))

    monkeypatch.setattr("IPython.display.display", display)
    monkeypatch.setattr(notebook_bar, "in_notebook", lambda: True)
    monkeypatch.setattr(notebook_bar, "PAUSE", 0.0)
    monkeypatch.setattr(notebook_bar, "PATIENCE", 0.0)
    return shown


def test_a_bar_appears_moves_and_goes(pages):
    _, inner = work()
    assert inner is None  # one bar, of what was called
    assert [re.search(r"\d+ %", page)[0] for page in pages[:2]] == ["25 %", "100 %"]
    assert pages[2:] == [""]
    assert Bar.shown is None


def test_a_bar_goes_after_an_error_too(pages):
    @shows_progress
    def fails(*, progress=None):
        progress(0.5)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fails()
    assert pages[-1] == ""
    assert Bar.shown is None


def test_what_is_quick_shows_none(pages, monkeypatch):
    monkeypatch.setattr(notebook_bar, "PATIENCE", 60.0)
    work()
    assert pages == []


def test_who_gives_progress_gets_it_and_a_program_has_no_bar(pages, monkeypatch):
    said = []
    assert work(progress=lambda fraction, *_: said.append(fraction))[1] is not None
    assert said == [0.25, 1.0]
    monkeypatch.setattr(notebook_bar, "in_notebook", lambda: False)
    pages.clear()
    assert work() == (None, None)
    assert pages == []


def test_a_batch_in_a_notebook_has_the_bits_of_one_elsewhere(pages):
    short = example(hs.Loop, hs.Simulation(duration=0.01))
    masses = {"plant.mass": np.array([5.0, 6.0])}
    there = hs.simulate_batch(short, masses)
    assert any("simulate batch" in page for page in pages)
    assert there.identical(hs.simulate_batch(short, masses, progress=lambda _: None))
