"""The table of what controllers take is made of measurements, and the page shows them."""

from pathlib import Path

import pytest
from benchmarks.targets.boards import BOARDS, COMPILER
from benchmarks.targets.costs import Costs, Sections
from benchmarks.targets.table import Measured, made_with, measured, page, tables
from benchmarks.targets.units import controllers, units

from needs import needs

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


@pytest.mark.parametrize("name", ["paper/sine-pi", "paper/sine-tsmc"])
def test_the_page_shows_what_is_measured(name: str) -> None:
    needs(COMPILER, "qemu-system-arm", "gcc", "valgrind")
    text = PAGE.read_text(encoding="utf-8")
    if made_with() not in text:
        pytest.skip("the page was made with other compilers")
    found = list(measured(units({name: controllers()[name]}), lambda _: None))
    assert [one.real for one in found] == ["double", "float"]
    assert all(len(one.boards) == len(BOARDS) for one in found)
    rows = [line for line in page(found).splitlines() if line.startswith("| `")]
    assert len(rows) == 3
    for row in rows:
        assert row in text, "run python -m benchmarks targets"
