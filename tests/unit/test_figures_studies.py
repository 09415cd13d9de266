"""Pictures of a study: what is where, in which colour, and that no name covers another."""

import math
from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.colors import to_hex
from matplotlib.text import Text

from hydroservo.core.formatting import NONE
from hydroservo.figures.studies.fronts import (
    FrontLine,
    FrontPanel,
    TargetPoint,
    plot_fronts,
    plot_target,
    staircase,
)
from hydroservo.figures.studies.grid import CellPlace, GridAxis, GridLevel, MapGrid
from hydroservo.figures.studies.looks import NamedPoint, family_colours, name_points, round_ticks
from hydroservo.figures.studies.map import HATCH, Winner, plot_map, shade
from hydroservo.figures.studies.ratios import (
    LESS,
    MORE,
    TIE,
    Combination,
    Distance,
    FactorShare,
    RatioLine,
    plot_distance,
    plot_factorial,
    plot_forest,
    ratio_with_interval,
)

FAMILIES = ["LQ", "PI", "TSMC"]


def grid_of(*sizes):
    """Axes a, b, ... of so many levels, and a cell for each combination."""
    axes = [
        GridAxis(n, n, [GridLevel(f"{n}{i}", f"{i}") for i in range(size)])
        for n, size in zip("abcde", sizes, strict=False)
    ]
    names = [axis.name for axis in axes]
    every = product(*([level.name for level in axis.levels] for axis in axes))
    return MapGrid(axes, {"-".join(one) or "only": dict(zip(names, one, strict=True)) for one in every})


def panels_of(fig):
    return [axis for part in fig.subfigs[:1] for axis in part.axes]


@pytest.mark.parametrize("sizes", [(), (3,), (3, 2), (3, 2, 2), (3, 2, 2, 3), (2, 2, 2, 2, 2)])
def test_each_cell_has_a_place_of_its_own(sizes):
    grid = grid_of(*sizes)
    places = grid.places()
    assert len(set(places.values())) == math.prod(sizes)
    assert max(place.row for place in places.values()) + 1 == len(grid.rows)
    assert max(place.column for place in places.values()) + 1 == len(grid.columns)


def test_the_first_two_axes_lie_inside_a_panel_the_third_makes_columns_and_the_rest_rows():
    grid = grid_of(2, 3, 4, 5, 2)
    assert grid.place({"a": "a1", "b": "b2", "c": "c3", "d": "d4", "e": "e1"}) == CellPlace(9, 3, 2, 1)
    assert grid.rows[9] == ("d: 4", "e: 1")


@pytest.mark.parametrize("sizes", [(), (3,), (3, 2), (2, 2, 2, 2)])
def test_the_map_shows_winners_ties_and_what_nobody_masters(sizes):
    grid = grid_of(*sizes)
    cells = list(grid.cells)
    kinds = [(["TSMC"], 1.3), (["LQ", "PI"], 1.01), ([], math.nan)]
    winners = [Winner(cell, *kinds[i % 3][:1], "ESO", kinds[i % 3][1]) for i, cell in enumerate(cells)]
    fig = plot_map(grid, winners, FAMILIES)
    assert len(panels_of(fig)) >= len(grid.rows) * len(grid.columns)
    patches = [patch for axis in panels_of(fig) for patch in axis.patches]
    colours = family_colours(FAMILIES)
    won = [patch for patch in patches if to_hex(patch.get_facecolor()) == shade(colours["TSMC"], 1.3)]
    assert len(won) == len(cells[0::3])
    assert sum(patch.get_hatch() == HATCH for patch in patches) == len(cells[2::3])
    strips = [patch for patch in patches if 0.0 < patch.get_height() < 0.5]
    assert len(strips) == 2 * len(cells[1::3])


def test_names_with_signs_of_a_dollar_are_drawn_as_typed():
    grid = MapGrid([GridAxis("a", "$_{ by $", [GridLevel("a0", "$^ or $")])], {"a0": {"a": "a0"}})
    fig = plot_map(grid, [Winner("a0", ["p$_{i$"], "ESO", 1.3)], ["p$_{i$"])
    fig.draw_without_rendering()
    shown = {text.get_text() for text in fig.findobj(Text) if not text.get_parse_math()}
    assert {"$^ or $", "p$_{i$"} <= shown


def test_a_greater_margin_is_a_stronger_colour():
    shades = [shade("#0072B2", margin) for margin in (0.98, 1.04, 1.1, 1.25, 1.5, 2.0, math.inf)]
    assert shades[0] == shades[1]
    assert shades[-1] == shades[-2] == "#0072b2"
    red = [int(one[1:3], 16) for one in shades]
    assert red == sorted(red, reverse=True)


def test_the_colours_of_a_forest_say_what_is_sure():
    lines = [
        RatioLine("a", 0.8, 0.7, 0.9, True),
        RatioLine("b", 1.3, 1.1, 1.5, True),
        RatioLine("c", 1.0, 0.5, 2.0, False),
    ]
    axis = plot_forest(lines, "ratio", 1.05).axes[0]
    dots = [line.get_color() for line in axis.lines if line.get_marker() == "o"]
    assert dots == [LESS, MORE, TIE]
    assert [tick.get_text() for tick in axis.get_yticklabels()] == ["a", "b", "c"]


def test_an_interval_beyond_the_axis_leaves_it_with_an_arrow():
    wide = RatioLine("wide", 1.2, 0.0, math.inf, False)
    axis = plot_forest([wide, RatioLine("none", math.nan, 0.0, math.inf, False)], "ratio").axes[0]
    assert [line.get_marker() for line in axis.lines if line.get_marker() in "<>"] == ["<", ">"]
    assert ratio_with_interval(wide) == "1.20 [0, ∞]"
    assert any(text.get_text() == NONE for text in axis.texts)


def test_names_of_points_cover_neither_each_other_nor_leave_the_panel():
    random = np.random.default_rng(3)
    points = [
        TargetPoint(f"law number {i}", FAMILIES[i % 3], float(y), float(x), "linear")
        for i, (x, y) in enumerate(np.exp(random.normal(0.0, 0.5, (12, 2))))
    ]
    fig = plot_target(points, FAMILIES, "rms error", "m/s")
    fig.draw_without_rendering()
    axis = fig.axes[0]
    boxes = [Text.get_window_extent(text) for text in axis.texts]
    assert len(boxes) == 12
    assert not [pair for pair in combinations(boxes, 2) if pair[0].overlaps(pair[1])]
    assert all(axis.bbox.x0 <= box.x0 and box.x1 <= axis.bbox.x1 for box in boxes)


def test_where_all_is_taken_a_name_is_still_written():
    fig = plot_target([TargetPoint("a", "PI", 1.0, 1.0, "linear")], FAMILIES, "error", "m")
    axis = fig.axes[0]
    crowd = [(x, y) for x in np.geomspace(*axis.get_xlim(), 60) for y in np.geomspace(*axis.get_ylim(), 60)]
    before = len(axis.texts)
    name_points(fig, axis, [NamedPoint("b", 1.0, 1000.0, "black")], crowd)
    assert len(axis.texts) == before + 1


@pytest.mark.parametrize(("cells", "rows"), [(1, 1), (3, 1), (4, 1), (5, 2), (8, 2)])
def test_fronts_have_a_panel_a_cell_and_a_colour_for_each_named_law(cells, rows):
    lines = [
        FrontLine("pi", [0.5, 1.0], [(1.2, 1.1, 1.3), (1.0, 1.0, 1.0)], [(1.0, 1.0)]),
        FrontLine("lq", [1.0, 4.0], [(0.9, 0.8, 1.0), (0.6, 0.5, 0.7)], [(1.0, 0.9), (4.0, 0.6)]),
        FrontLine("other", [2.0], [(0.8, 0.7, 0.9)], []),
    ]
    panels = [FrontPanel(f"cell {i}", 1e-3, 2.5, lines) for i in range(cells)]
    fig = plot_fronts(panels, ["pi", "lq"], "pi", [0.5, 1.0, 8.0], "m/s")
    drawn = [axis for axis in fig.axes if axis.get_title(loc="left")]
    assert [axis.get_title(loc="left") for axis in drawn] == [
        f"cell {i}\n1.00 mm/s at 2.5 %/s" for i in range(cells)
    ]
    assert fig.axes[0].get_subplotspec().get_geometry()[0] == rows
    assert [text.get_text() for text in fig.legends[0].texts] == ["pi", "lq", "other laws"]
    colours = [to_hex(line.get_color()) for line in drawn[0].lines if len(line.get_xdata()) == 2]
    assert len(set(colours)) == 3  # that of the reference's error, and of two laws
    assert len([line for line in drawn[0].lines if line.get_marker() == "."]) == 3
    assert len(drawn[0].collections) == 2  # bands
    below = drawn[max(cells - min(cells, 4), 0) :]
    assert all(axis.get_xlabel() and axis.xaxis.get_tick_params()["labelbottom"] for axis in below)


@pytest.mark.parametrize("error", [[], [(math.nan, 0.0, math.inf)]])
def test_fronts_without_a_known_error_can_be_drawn(error):
    lines = [FrontLine("lq", [1.0] * len(error), error, [])] if error else []
    fig = plot_fronts([FrontPanel("cell", math.nan, 2.5, lines)], ["pi"], "pi", [1.0, 8.0], "m/s")
    assert fig.axes[0].get_ylim()[0] < 1.0


def test_the_line_of_a_front_falls_in_steps():
    assert staircase([(1.0, 3.0), (2.0, 4.0), (3.0, 1.0)]) == [(1.0, 3.0), (3.0, 3.0), (3.0, 1.0)]


def test_a_factorial_prints_each_pair_and_each_share():
    pairs = [
        Combination("LQ", "ESO", 0.8, 0.7, 0.9, 0.0),
        Combination("PI", "ESO", math.inf, 0.0, math.inf, 1.0),
    ]
    table, bars = plot_factorial(pairs, [FactorShare("family", 0.4, 0.3, 0.5)], "ratio").axes
    assert [text.get_text() for text in table.texts] == ["0.800", "[0.700, 0.900]", "lost", "100 % lost"]
    assert [text.get_text() for text in bars.texts] == ["40 %"]
    assert bars.patches[0].get_width() == pytest.approx(40.0)
    assert len(plot_factorial(pairs, [], "ratio").axes) == 1


def test_bars_begin_at_the_limit_and_those_below_it_are_seen():
    lines = [
        Distance("a", "PI", 2.0, 1.9, 2.2),
        Distance("b", "LQ", 0.8, 0.7, 0.9),
        Distance("c", "PI", *[math.inf] * 3),
    ]
    axis = plot_distance(lines, FAMILIES, 1.3).axes[0]
    bars = [patch for patch in axis.patches if patch.get_height() == pytest.approx(0.6)]
    assert [bar.get_x() for bar in bars] == [1.0, 1.0]
    assert [bar.get_width() for bar in bars] == pytest.approx([1.0, -0.2])
    assert axis.get_xlim()[0] < 0.7
    assert {"2.00", "0.800", " lost", " causal limit"} == {text.get_text() for text in axis.texts}


@given(st.floats(1e-6, 1e6), st.floats(1.05, 1e6))
def test_ticks_are_few_and_inside(low, factor):
    ticks = round_ticks(low, low * factor, 7)
    assert all(low <= tick <= low * factor for tick in ticks)
    assert len(ticks) <= 7 or factor > 1e5


def test_equal_pictures_are_equal_bytes(tmp_path):
    grid = grid_of(2, 2)
    winners = [Winner(cell, ["PI"], "ESO", 1.2) for cell in grid.cells]
    one, other = (plot_map(grid, winners, FAMILIES).save(tmp_path / f"{i}.svg", origin="x") for i in range(2))
    assert one.read_bytes() == other.read_bytes()


def test_laws_without_margins_are_hollow_beside_their_prices():
    points = [
        TargetPoint("a", "PI", 2e-3, 15, "linear"),
        TargetPoint("b", "TSMC", 1e-3, 2000, "rough"),
        TargetPoint("c", "LQ", 3e-3, 400, "unstable"),
    ]
    fig = plot_target(points, FAMILIES, "rms error", "m/s")
    marks = [line for line in fig.axes[0].lines if line.get_marker() in "oX"]
    assert [line.get_fillstyle() for line in marks] == ["full", "none", "none"]
    assert [line.get_xydata().tolist()[0] for line in marks] == [[15.0, 2.0], [2000.0, 1.0], [400.0, 3.0]]
    assert {text.get_text() for text in fig.axes[0].texts} == {"a", "b", "c"}
