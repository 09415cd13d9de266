"""The table of what controllers take is made of measurements, and the page shows them."""

from pathlib import Path

import pytest
from benchmarks.targets.boards import BOARDS, COMPILER
from benchmarks.targets.costs import Costs, Sections
from benchmarks.targets.table import Measured, columns, made_with, measured, page, tables
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
    found = [Measured("one", "double", 90, (COSTS, COSTS)), Measured("two", "float", 80, (COSTS, COSTS))]
    (_, double), (_, single) = tables(found)
    cells = ("1,234 (2,345) B", "60 B", "5,678")
    assert double == (columns(), [("one", "16 B", "24 B", *cells, *cells, "90")])
    assert [row[0] for row in single[1]] == ["two"]
    assert len(columns()) == len(double[1][0])


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
    assert len(rows) == 2
    for row in rows:
        assert row in text, "run python -m benchmarks targets"
