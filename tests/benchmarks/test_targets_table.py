"""The table of what controllers take is made of measurements, and the page shows them."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.targets.table import Measured, made_with, measured, page, tables
from benchmarks.targets.units import units
from tests.support.needs import needs
from tools.targets.boards import BOARDS, COMPILER
from tools.targets.controllers import controllers
from tools.targets.costs import Costs, Sections

# What other compilers than the page's may differ by: a share, and bytes or instructions where there are few.
OTHERS, OTHERS_LEAST = 0.05, 32.0
PAGE = Path(__file__).parents[2] / "docs" / "target.md"
COSTS = Costs(
    own=Sections(1000, 234, 0, 0),
    linked=Sections(2000, 345, 0, 0),
    state=16,
    parameters=24,
    stack=40,
    touched=60,
    instructions=5678,
)


def test_each_combination_of_blocks_is_there_once() -> None:
    found = controllers()
    assert {"paper/sine-pi", "paper/sine-backstepping", "paper/sine-tsmc"} <= found.keys()
    assert not {"paper/square-pi", "paper/square-tsmc"} & found.keys()


def test_a_row_has_a_cell_for_each_column() -> None:
    found = [Measured("one", real, 90, (COSTS, COSTS)) for real in ("double", "float")]
    found += [Measured("two", real, 80, (COSTS, COSTS)) for real in ("double", "float")]
    (_, steps), (_, double), (_, single) = tables(found)
    cells = ("1,234", "2,345", "60")
    assert double == single
    assert double[1][0] == ("one", "16", "24", *cells, *cells)
    assert steps[1][1] == ("two", *["5,678", "5,678", "80"] * 2)
    assert all(len(header) == len(row) for header, rows in (steps, double) for row in rows)


def numbers(text: str) -> dict[str, list[list[float]]]:
    """By its name what each row of all tables holds, in the order of the tables."""
    found: dict[str, list[list[float]]] = {}
    for line in text.splitlines():
        if line.startswith("| `"):
            name, *cells = line.strip("| ").split(" | ")
            found.setdefault(name.strip("`"), []).append([float(cell.replace(",", "")) for cell in cells])
    return found


@pytest.mark.slow  # it lists every combination of blocks
def test_each_row_of_the_page_is_of_a_combination() -> None:
    """A combination without a row has not been measured yet."""
    shown = numbers(PAGE.read_text(encoding="utf-8"))
    assert shown.keys() <= controllers().keys()
    assert {len(rows) for rows in shown.values()} == {3}


@pytest.mark.nightly  # each compiles for two targets
@pytest.mark.parametrize("name", ["PI", "backstepping filtered", "rate limit", "paper/sine-tsmc"])
def test_the_page_shows_what_is_measured(name: str) -> None:
    needs(COMPILER, "qemu-system-arm", "gcc", "valgrind")
    text = PAGE.read_text(encoding="utf-8")
    found = list(measured(units({name: controllers()[name]}), lambda _: None))
    assert [one.real for one in found] == ["double", "float"]
    assert all(len(one.boards) == len(BOARDS) for one in found)
    here, shown = numbers(page(found))[name], numbers(text)[name]
    rtol, atol = (0.0, 0.0) if made_with() in text else (OTHERS, OTHERS_LEAST)
    assert len(here) == len(shown) == 3
    for row, expected in zip(here, shown, strict=True):
        np.testing.assert_allclose(row, expected, rtol, atol, err_msg="run python -m benchmarks targets")
