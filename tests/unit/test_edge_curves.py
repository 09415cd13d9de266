"""Shapes of edges from curves: what they open, and which curves are none of edges."""

from typing import Any

import pytest

from hydroservo import ParameterError, ScenarioError, identify, linearize, simulate
from hydroservo.core.curve import Curve
from hydroservo.core.signals import EdgeOpenings, Pressures
from hydroservo.core.validation import checked
from hydroservo.machine.valves import CurvedEdges, FourCurves, FourEdges, StraightEdges
from tests.support.axes import AXIS as AXIS_FILE
from tests.support.axes import COMMANDED, commanded_axis, step

LITRE = 1.0 / 6e4  # m^3/s, of 1 L/min
PROGRESSIVE = Curve.from_samples([0.0, 0.5, 1.0], [0.0, 7.0 * LITRE, 50.0 * LITRE])
SIGNED = Curve.from_samples([-1.0, -0.5, 0.0, 0.5, 1.0], [-30 * LITRE, -12 * LITRE, 0, 7 * LITRE, 50 * LITRE])
POINT = {"rated_flow": 50.0 * LITRE, "rated_drop": 10e5, "rated_opening": 1e-3}
FULL = {"opening": 1e-3, "supply_drop": 10e5, "load_pressure": 0.0}

EXAMPLE = CurvedEdges(1e-3, Curve.from_samples([0.0, 0.5, 1.0], [0.0, 0.125, 1.0]))
SHUT = CurvedEdges(1e-2, Curve.from_samples([0.0, 0.5, 1.0], [0.0, 0.0, 1.0]))


def curve(*points: tuple[float, float]) -> Curve:
    return Curve.from_samples(*zip(*points, strict=True))


def test_straight_edges_open_as_the_spool_moves() -> None:
    assert StraightEdges().openings(0.25) == EdgeOpenings(0.25, -0.25, -0.25, 0.25)
    assert FourEdges.rated(**POINT).shape == StraightEdges()


@pytest.mark.parametrize("share", [-1.0, -0.5, 0.0, 0.5, 1.0])
def test_both_directions_are_those_of_the_curve_or_alike(share: float) -> None:
    for one, sign in ((SIGNED, 1.0), (PROGRESSIVE, -1.0 if share < 0.0 else 1.0)):
        edges = FourEdges.rated(**POINT, flow_curve=one, transition_drop=0.0)
        wanted = sign * one.value(sign * share if one is PROGRESSIVE else share)
        assert edges.flow(share * 1e-3, 10e5, 0.0) == pytest.approx(wanted, rel=1e-12, abs=1e-18)


def test_the_rated_flow_may_be_left_to_the_curve() -> None:
    given, left = (
        FourEdges.rated(**POINT | {"rated_flow": q}, flow_curve=PROGRESSIVE)
        for q in (50.2 * LITRE, float("inf"))
    )
    assert given.area_gradient == left.area_gradient
    assert left.flow(**FULL) == pytest.approx(50.0 * LITRE)


def test_a_shape_is_scaled_to_the_rated_flow() -> None:
    edges = FourEdges.rated(**POINT, shape=EXAMPLE, transition_drop=0.0)
    flows = [edges.flow(opening, 10e5, 0.0) for opening in (1e-3, 5e-4, -5e-4)]
    assert flows == pytest.approx([50.0 * LITRE, 6.25 * LITRE, -6.25 * LITRE], rel=1e-12)


def test_a_spool_that_moves_beyond_its_curve_opens_no_further() -> None:
    edges = FourEdges.rated(**POINT, flow_curve=PROGRESSIVE)
    assert edges.flow(1.5e-3, 10e5, 0.0) == edges.flow(**FULL)


def test_within_an_overlap_an_edge_leaks_as_one_that_is_just_closed() -> None:
    lapped = curve((0.0, 0.0), (0.2, 0.0), (1.0, 50.0 * LITRE))
    leaking = {"null_leakage": 0.4 * LITRE, "supply_pressure": 100e5}
    edges = FourEdges.rated(**POINT, **leaking, flow_curve=lapped)
    line = Pressures(100e5, 0.0)
    for opening in (0.0, 1e-4, -2e-4):
        assert edges.port_flows(opening, line, 50e5, 50e5).supply == pytest.approx(0.4 * LITRE)
    dry = FourEdges.rated(**POINT, flow_curve=lapped)
    assert max(map(abs, dry.port_flows(2e-4, line, 50e5, 20e5))) == 0.0


def test_edges_of_their_own_curves_are_filled_from_that_of_all() -> None:
    own = curve((0.0, 0.0), (1.0, 20.0 * LITRE))
    shape = FourEdges.rated(**POINT, flow_curve=SIGNED, flow_curve_bt=own).shape
    assert shape.openings(5e-4) == pytest.approx((1e-3 * 7 / 50, -5e-4, -5e-4, 1e-3 * 10 / 50))
    assert shape.openings(-5e-4) == pytest.approx((-5e-4, 1e-3 * 12 / 50, 1e-3 * 12 / 50, -5e-4))


def test_an_edge_that_begins_below_0_is_open_at_null() -> None:
    underlapped = curve((-0.1, 0.0), (0.0, 1.0 * LITRE), (1.0, 50.0 * LITRE))
    edges = FourEdges.rated(
        **POINT, flow_curve=PROGRESSIVE, flow_curve_pa=underlapped, flow_curve_at=underlapped
    )
    flows = edges.port_flows(0.0, Pressures(10e5, 0.0), 5e5, 5e5)
    assert flows.supply == pytest.approx(1.0 * LITRE, rel=3e-3)
    assert edges.port_flows(-1.1e-4, Pressures(10e5, 0.0), 5e5, 5e5).supply == pytest.approx(
        edges.port_flows(1.1e-4, Pressures(10e5, 0.0), 5e5, 5e5).tank
    )


def test_areas_are_those_of_the_root_law() -> None:
    areas = Curve.from_samples([0.0, 0.5e-3, 1e-3], [0.0, 2e-6, 12e-6])
    edges = FourEdges.from_areas(0.7, 860.0, areas, clearance=0.0, transition_drop=0.0)
    for opening, area in ((5e-4, 2e-6), (1e-3, 12e-6), (-5e-4, -2e-6)):
        wanted = 0.7 * area * (2.0 / 860.0 * 5e5) ** 0.5
        assert edges.flow(opening, 10e5, 0.0) == pytest.approx(wanted, rel=1e-12)
    assert edges.simplified().area_gradient == pytest.approx(12e-3)


WRONG: list[tuple[dict[str, Any], str]] = [
    (
        {"flow_curve": curve((0, 0), (0.8, 1e-3))},
        "flow_curve = 'ends at 80 %': must go on to full opening, 100 %",
    ),
    ({"flow_curve": curve((0, 0), (100, 1e-3))}, "flow_curve = 'ends at 1e.04 %': .*at most to 1000 %"),
    (
        {"flow_curve": curve((-0.5, -1e-3), (1, 1e-3))},
        "'begins at -50 %': must begin at 0, .* or go from -100 %",
    ),
    ({"flow_curve": curve((0, 1e-5), (1, 1e-3))}, "'0.600 L/min': must be 0 where it begins, at 0 %"),
    ({"flow_curve": curve((0.1, 1e-5), (1, 1e-3))}, "must be 0 where it begins, at 10 %"),
    ({"flow_curve": curve((0, 0), (0.5, -1e-5), (1, 1e-3))}, "'.0.600 L/min': must not be below 0"),
    ({"flow_curve": curve((0, 0), (0.5, 1e-5), (1, 0))}, "'0 L/min': must be above 0 at 100 %"),
    ({"flow_curve": curve((-1, 0), (1, 1e-3))}, "'0 L/min': must be below 0 at -100 %"),
    (
        {"flow_curve": PROGRESSIVE, "rated_flow": 40 * LITRE},
        "rated_flow = '40.0 L/min': must be that of the flow curve, 50.0",
    ),
    ({"flow_curve": PROGRESSIVE, "lap": 1e-4}, "lap = 0.0001: must be 0 beside a flow curve"),
    ({"flow_curve": PROGRESSIVE, "extra_lap_bt": 1e-4}, "lap = 0.0001: must be 0 beside a flow curve"),
    ({"flow_curve_pa": PROGRESSIVE}, "flow_curve_at = 'missing': must be given, or flow_curve for all edges"),
    (
        {"flow_curve": PROGRESSIVE, "flow_curve_pb": curve((0, 0), (1, -1e-3))},
        "flow_curve_pb = .* not be below 0",
    ),
    (
        {"flow_curve": PROGRESSIVE, "flow_curve_pb": curve((0, 0), (1, 0))},
        "flow_curve_pb = '0': must be above 0 at",
    ),
    (
        {"flow_curve": PROGRESSIVE, "shape": EXAMPLE},
        "shape = .*must not stand beside a flow curve",
    ),
    ({"shape": SHUT}, "rated_opening = .* must open the edge P-A of that shape"),
    ({"rated_flow": float("inf")}, "rated_flow = 'auto': must be a number without a flow curve"),
]


@pytest.mark.parametrize(("changes", "problem"), WRONG)
def test_curves_that_no_edges_have(changes: dict[str, Any], problem: str) -> None:
    with pytest.raises(ParameterError, match=problem):
        FourEdges.rated(**POINT | changes)


def test_areas_must_be_given() -> None:
    with pytest.raises(ParameterError, match="area_curve = 'missing': must be given, or one of each edge"):
        FourEdges.from_areas(0.7, 860.0)


def test_shapes_that_no_edges_have() -> None:
    with pytest.raises(ParameterError, match=r"curve = 0\.1: must begin at 0 and not fall below"):
        checked(CurvedEdges(1e-3, curve((0, 0.1), (1, 1))))
    with pytest.raises(ParameterError, match=r"curve = -0\.1: must begin at 0 and not fall below"):
        checked(CurvedEdges(1e-3, curve((0, 0), (0.5, -0.1), (1, 1))))
    right = curve((0, 0), (1, 1))
    with pytest.raises(ParameterError, match=r"pb = -1\.0: must not be below 0"):
        checked(FourCurves(1e-3, right, right, curve((0, 0), (1, -1)), right))


FLOW_CURVE = {"points": [["0 %", "0 L/min"], ["50 %", "5 L/min"], ["100 %", "40 L/min"]]}
EDGES = {
    "type": "FourEdges.rated",
    "rated_flow": "auto",
    "rated_drop": "70 bar",
    "rated_opening": "1 mm",
    "flow_curve": FLOW_CURVE,
}

AXIS = {"reference": step("0 V", "5 V", "0.1 s"), "simulation.duration": "0.4 s", "valve.orifice": EDGES}


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        ({"points": [["0 mm", "0 L/min"], ["1 mm", "1 L/min"]]}, "'0 mm' is not dimensionless"),
        ({"points": [["0 %", "0 mm^2"], ["100 %", "1 mm^2"]]}, "'0 mm.2' does not convert to m.3/s"),
        (FLOW_CURVE | {"full": "1 mm"}, "'0 %' does not convert to mm"),
        (FLOW_CURVE | {"full": "1 foo"}, "flow_curve.full: '1 foo' has the unknown unit foo"),
        (FLOW_CURVE | {"full": "-1 mm"}, "flow_curve.full: '-1 mm' must be above 0"),
        (FLOW_CURVE | {"full": 1}, "flow_curve.full: 1 is not a quantity such as '1.5 V'"),
    ],
)
def test_wrong_units_are_refused_in_one_line(table: dict[str, Any], problem: str) -> None:
    with pytest.raises(ScenarioError, match=problem) as caught:
        commanded_axis(AXIS | {"valve.orifice": EDGES | {"flow_curve": table}})
    assert len(str(caught.value).splitlines()) == 1


def test_what_100_percent_is_may_be_said() -> None:
    rows = [["0 V", "0 L/min"], ["5000 mV", "5 L/min"], ["10 V", "40 L/min"]]
    one, other = (
        commanded_axis(AXIS | {"valve.orifice": EDGES | {"flow_curve": table}}).valve.orifice.shape.curve
        for table in (FLOW_CURVE, {"points": rows, "full": "10 V"})
    )
    assert [*one.knots, *one.samples] == pytest.approx([*other.knots, *other.samples], rel=1e-15)


def test_a_shape_may_be_given_as_shares() -> None:
    rows = [["0 %", "0 %"], ["50 %", "12.5 %"], ["100 %", "100 %"]]
    shape = {"type": "CurvedEdges", "full_opening": "1 mm", "curve": {"points": rows}}
    numbers = {"type": "FourEdges", "discharge_coefficient": 0.62, "area_gradient": "10 mm", "density": 850}
    valve = {"type": "StaticValve", "gain": "0.1 mm/V", "max_opening": "1 mm"}
    orifice = numbers | {"shape": shape}
    edges = commanded_axis(
        {"reference": AXIS["reference"], "valve": valve | {"orifice": orifice}}
    ).valve.orifice
    assert edges.shape.openings(-5e-4) == pytest.approx((-1.25e-4, 1.25e-4, 1.25e-4, -1.25e-4))


def test_the_slope_at_a_point_is_that_of_the_curve() -> None:
    """Without a load, the velocity grows by the slope of the flow at twice the rated drop over the area."""
    loop = commanded_axis(AXIS | {"supply.supply_pressure": "140 bar", "plant.rod": "0.01 mm"})
    model = linearize(loop, command=5.0)
    assert model.inexact == ()
    table = Curve.from_samples([0.0, 0.5, 1.0], [0.0, 5.0 * LITRE, 40.0 * LITRE])
    slope = 0.1 * table.rate(0.5) * 2.0**0.5 / loop.plant.area_a
    assert model.steady_gain("velocity", "command") == pytest.approx(slope, rel=1e-3)


@pytest.mark.slow  # some ten seconds
def test_the_scale_of_a_curve_is_found_from_a_log() -> None:
    sine = {"type": "Sine", "amplitude": "6 V", "frequency": "5 Hz"}
    changes = {"reference": sine, "simulation.duration": "0.5 s", "valve.orifice": EDGES}
    run = simulate(commanded_axis(changes))
    columns = {"time": "time", "command": "controller.u", "position": "plant.position"}
    log = {name: run[path].values for name, path in columns.items()}
    sought = (("rated_drop", "100 bar", "50..120 bar", 70e5), ("rated_opening", "0.9 mm", "0.8..1 mm", 1e-3))
    for name, wrong, between, right in sought:
        path = f"valve.orifice.{name}"
        found = identify(AXIS_FILE, log, {path: between}, changes=COMMANDED | changes | {path: wrong})
        assert found.parameters[path].value == pytest.approx(right, rel=1e-3)
