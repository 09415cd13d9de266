"""Blocks as a reader sees them: a line for each, or a table."""

import re
from typing import Annotated, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pytest

from hydroservo.control.controlled import Position
from hydroservo.control.controllers import PI, TSMC
from hydroservo.control.loop import AUTO, Loop, Simulation
from hydroservo.control.outline import WIDTH, outline, outline_table
from hydroservo.core.field import Field
from hydroservo.machine.oils import AeratedOil
from hydroservo.machine.plants import Cylinder
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example


class Inner(NamedTuple):
    """What is nested."""

    area: Annotated[float, Field("m^2", "area <A>")] = 4.91e-4


class Outer(NamedTuple):
    """Numbers of all kinds."""

    pressure: Annotated[float, Field("Pa", "pressure")] = 4e6
    count: Annotated[int, Field("", "how many", auto=AUTO)] = 1
    samples: np.ndarray = np.zeros(3)
    printed: bool = False
    unknown: object = None
    inner: Inner = Inner()
    other: Inner = Inner(1e-4)


def test_a_line_for_each_block_with_units_of_datasheets():
    assert outline(Outer(unknown=2.5)).splitlines() == [
        "Outer: unknown 2.5, pressure 40 bar, count 1, samples 3 numbers, printed False",
        "  inner  Inner: area 4.91 cm²",
        "  other  Inner: area 1 cm²",
    ]


def test_what_differs_comes_first_and_what_is_open_says_so():
    first = outline(Outer(count=AUTO, printed=True)).splitlines()[0]
    assert first == "Outer: count auto, printed True, pressure 40 bar, samples 3 numbers"


def test_nested_blocks_that_are_default_are_left_out():
    lines = outline(example(Loop, controller=example(TSMC))).splitlines()
    assert lines[0] == "Loop"
    shown = [line.split()[0] for line in lines[1:] if re.match("  [a-z]", line)]
    assert shown == [name for name in Loop._fields if name != "command"]  # which is in volts
    changed = outline(example(Loop, plant=example(Cylinder, oil=AeratedOil())))
    assert re.search(r"^    oil +AeratedOil: ", changed, re.MULTILINE)
    assert "Stops" not in changed


@pytest.mark.parametrize("name", ["paper/sine-tsmc", "rig/excavator-link", "rig/encoder-tsmc-sine"])
def test_lines_of_a_loop_fit_a_terminal(name):
    text = repr(load_scenario(name))
    assert max(map(len, text.splitlines())) <= WIDTH
    assert len(text.splitlines()) < 40
    assert text.splitlines()[1].startswith("  simulation")


def test_every_block_nested_in_one_of_a_users_own_is_shown():
    lines = outline(example(Loop, plant=Outer())).splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("  plant"))
    nested = [line.split() for line in lines[start + 1 : start + 3]]
    assert nested == [["inner", "Inner:", "area", "4.91", "cm²"], ["other", "Inner:", "area", "1", "cm²"]]


def test_what_differs_is_said_of_a_loop():
    loop = example(Loop, Simulation(duration=2.0, substeps=AUTO), controller=PI(5.0, 100.0))
    assert "Simulation: duration 2 s, substeps auto, " in repr(loop)
    assert "PI: proportional_gain 5 V s/m, integral_gain 100 V/m, " in repr(loop)


def test_a_notebook_shows_every_number_with_its_meaning():
    loop = load_scenario("rig/excavator-link")
    page = ElementTree.fromstring(f"<div>{loop._repr_html_()}</div>")
    empty = {"controls", "drive", "metrics", "start", "command"}  # without numbers: the usual ones
    assert len(page.findall("details")) == len(set(Loop._fields) - empty)
    rows = [["".join(cell.itertext()) for cell in row.findall("td")] for row in page.iter("tr")]
    assert ["air_content", "0.005", "", "volume share of free air at atmospheric pressure"] in rows
    assert ["supply_pressure", "160", "bar", "supply pressure p_s"] in rows
    assert "plant.friction LuGre" in ["".join(row.itertext()) for row in page.iter("tr")]


def test_a_table_marks_what_differs_and_escapes_text():
    page = outline_table(Outer(inner=Inner(2e-4)))
    assert "<b>2</b>" in page
    assert "<b>40</b>" not in page
    assert "area &lt;A&gt;" in page


def test_a_law_that_controls_what_its_loop_does_does_not_say_so():
    loop = load_scenario("paper/sine-pi")
    assert outline(runnable_loop(loop)).count("controls") == 1
    law = loop.controller._replace(controls=Position())
    assert outline(loop._replace(controller=law)).count("controls") == 2
