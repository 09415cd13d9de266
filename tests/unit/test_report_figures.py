"""Figures 3 to 10, drawn from runs made up for the purpose."""

import numpy as np
import pytest

from hydroservo.papers.tsmc_eha_2021.report import figures
from hydroservo.papers.tsmc_eha_2021.report.figures import FIGURES, draw_figures
from tests.support.study import lost, made_up, made_up_runs


def panels(fig):
    return [axis for axis in fig.axes if axis.get_title(loc="left").startswith("(")]


def labelled(axis):
    return {line.get_label(): line for line in axis.get_lines()}


@pytest.fixture(scope="module")
def runs():
    return made_up_runs()


@pytest.fixture(scope="module")
def drawn(runs):
    return {one.number: one.draw(runs) for one in FIGURES}


def test_all_figures_are_written_in_both_formats_with_the_same_bytes_each_time(runs, tmp_path, monkeypatch):
    monkeypatch.setattr(figures, "FIGURES", FIGURES[:2])
    steps = []
    written = draw_figures(runs, tmp_path, "abc", lambda *step: steps.append(step))
    assert [path.name for path in written] == ["fig03.png", "fig03.svg", "fig04.png", "fig04.svg"]
    assert steps == [(1, 2, "figure 3"), (2, 2, "figure 4")]
    assert written[0].read_bytes().startswith(b"\x89PNG")
    assert b"<svg" in written[1].read_bytes()
    first = [path.read_bytes() for path in written]
    assert [path.read_bytes() for path in draw_figures(runs, tmp_path, "abc")] == first


def test_the_figures_are_the_papers(drawn):
    assert list(drawn) == [3, 4, 5, 6, 7, 8, 9, 10]


@pytest.mark.parametrize(
    ("index", "units"),
    [
        (3, ["mm/s"] * 3),
        (4, ["mm/s"] * 4),
        (5, ["mm/s"] * 3),
        (6, ["mm/s"] * 4),
        (7, ["m/s²", "m/s²", "kN/s", "N/s"]),
        (8, ["m/s²", "m/s²", "kN/s", "N/s"]),
        (9, ["mm/s", "mm/s", "10⁻³ m/s²", "10⁻³ m/s²", "mV", "mV"]),
        (10, ["mm/s", "mm/s", "10⁻³ m/s²", "10⁻³ m/s²", "mV", "mV"]),
    ],
)
def test_each_panel_names_its_unit(drawn, index, units):
    found = [axis.get_ylabel().split("[")[1].rstrip("]") for axis in panels(drawn[index])]
    assert [unit.replace("µm/s", "mm/s") for unit in found] == units
    assert all(axis.get_xlabel().endswith(("[s]", "[ms]")) for axis in panels(drawn[index]))


@pytest.mark.parametrize("index", [3, 5])
def test_velocities_are_drawn_in_mm_per_s(runs, drawn, index):
    demand = "sine" if index == 3 else "square"
    whole = labelled(panels(drawn[index])[0])
    assert set(whole) == {"PI", "backstepping", "TSMC", "demand"}
    for name, label in (("pi", "PI"), ("tsmc", "TSMC")):
        expected = 1e3 * runs[f"{demand}-{name}"]["controlled.value"].to_numpy()[:-1]
        np.testing.assert_allclose(whole[label].get_ydata(), expected)


@pytest.mark.parametrize("index", [4, 6])
def test_a_panel_of_its_own_range_shows_the_two_small_errors(drawn, index):
    wide, _, close, _ = panels(drawn[index])
    assert wide.get_ylim()[1] > 20.0
    low, high = close.get_ylim()
    assert -0.6 < low < -0.3
    assert 0.3 < high < 0.6
    for label in ("PI", "TSMC"):
        values = labelled(close)[label].get_ydata()
        assert np.mean((values > low) & (values < high)) > 0.9
        assert np.ptp(values) > 0.5 * (high - low)
    assert "backstepping" in close.get_title(loc="right")


def test_the_error_of_an_estimate_is_its_estimate_less_the_truth(drawn):
    line = labelled(panels(drawn[7])[1])["error"]
    time = line.get_xdata()
    np.testing.assert_allclose(line.get_ydata(), -0.1 * np.sin(0.5 * np.pi * time), atol=1e-12)


def test_no_legend_lies_on_a_panel(drawn):
    for fig in drawn.values():
        assert all(axis.get_legend() is None for axis in panels(fig))


def test_diverged_runs_are_drawn_up_to_where_they_are_lost(runs):
    broken = {name: lost(data) for name, data in runs.items()}
    for one in FIGURES:
        for axis in panels(one.draw(broken)):
            for line in axis.get_lines():
                assert np.all(np.abs(line.get_ydata()) < 1e6)
            assert np.all(np.isfinite(axis.get_ylim()))
        assert one.seen(broken)


def test_what_is_seen_follows_the_numbers(runs):
    for one in FIGURES[:4]:
        changed = dict(runs)
        for demand in ("sine", "square"):
            changed[f"{demand}-pi"] = made_up(demand, "pi", 7.0)
        before, after = one.seen(runs), one.seen(changed)
        assert before.index("PI") < before.index("backstepping") < before.index("TSMC")
        assert after.index("backstepping") < after.index("TSMC") < after.index("PI")
    assert "backstepping 1.00 mm/s" in FIGURES[1].seen(runs)


def test_the_last_sample_is_never_drawn(runs, drawn):
    for fig in drawn.values():
        for axis in panels(fig):
            if axis.get_xlabel() == "time [s]":
                assert all(line.get_xdata()[-1] < 8.0 for line in axis.get_lines())
    assert panels(drawn[4])[0].get_xlim() == (0.0, 8.0)


def test_captions_name_the_windows_that_are_drawn(drawn):
    for number, words in ((3, "First 30 ms"), (4, "first 30 ms"), (5, "Jump at 2 s"), (3, "Trough at 3 s")):
        assert words in FIGURES[number - 3].caption
    assert panels(drawn[3])[1].get_xlim() == (0.0, 30.0)
    assert panels(drawn[5])[1].get_title(loc="left") == "(b) jump at 2 s"
    start, stop = panels(drawn[3])[2].get_xlim()
    assert start < 3.0 < stop
